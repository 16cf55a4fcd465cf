"""Charts: lines at their values, downsampling without losing peaks, obstacles and zooms at true positions."""

import re
from contextlib import closing

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.contacts import solid_objects
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.reporting import figures, paths
from vpf_sim.reporting.kit import interval_chart
from vpf_sim.reporting.kit.chart import Axis, Plot, plain, reach, thinned, ticks
from vpf_sim.reporting.kit.interval_chart import Dot, Mark
from vpf_sim.reporting.paths import Track
from vpf_sim.reporting.road_layout import RoadLayout, layouts
from vpf_sim.types import Floats


def points(path: str) -> Floats:
    """(M, 2) px of a path of relative moves."""
    start, *moves = re.findall(r"[Ml](-?[\d.]+) (-?[\d.]+)", path)
    return np.cumsum(np.array([start, *moves], float), axis=0)


def paths_of(svg: str, style: str) -> list[Floats]:
    return [points(found) for found in re.findall(rf'<path class="{style}" d="([^"]+)"', svg)]


def test_a_line_is_drawn_at_its_values() -> None:
    plot = Plot(200.0, 100.0, Axis(0.0, 10.0), Axis(-1.0, 1.0), (20.0, 20.0, 10.0, 10.0))
    x = np.linspace(0.0, 10.0, 1000)
    plot.line(x, np.sin(x), "wave")
    (drawn,) = paths_of(plot.svg("a wave"), "wave")
    assert drawn[0] == pytest.approx([20.0, 50.0])
    assert drawn[-1] == pytest.approx([180.0, 50.0 - 40.0 * np.sin(10.0)], abs=0.06), "rounding does not add up"
    expected = 50.0 - 40.0 * np.sin((drawn[:, 0] - 20.0) / 16.0)
    assert drawn[:, 1] == pytest.approx(expected, abs=0.4)


def test_a_gap_in_the_values_is_a_gap_in_the_line() -> None:
    plot = Plot(100.0, 100.0, Axis(0.0, 5.0), Axis(0.0, 1.0))
    plot.line(np.arange(6.0), np.array([0.0, 1.0, np.nan, 1.0, 0.5, np.nan]), "gap")
    assert [len(drawn) for drawn in paths_of(plot.svg(""), "gap")] == [2, 2]


@pytest.mark.parametrize(
    ("low", "high", "count", "expected"),
    [
        (0.0, 10.0, 5, (0.0, 2.0, 4.0, 6.0, 8.0, 10.0)),
        (-1.06, 1.06, 4, (-1.0, 0.0, 1.0)),
        (12.0, -7.0, 4, (-5.0, 0.0, 5.0, 10.0)),
        (3.0, 3.0, 4, ()),
        (0.0, float("nan"), 4, ()),
    ],
)
def test_ticks_are_round_and_few(low: float, high: float, count: int, expected: tuple[float, ...]) -> None:
    assert ticks(low, high, count) == pytest.approx(expected)


def test_numbers_have_a_true_minus_sign() -> None:
    assert [plain(value) for value in (-0.5, 0.0, 200.0)] == ["−0.5", "0", "200"]


def test_thinning_keeps_every_peak_and_both_ends() -> None:
    x, y = np.arange(5000.0), np.zeros(5000)
    y[[0, 137, 2500, 4999]] = [3.0, 9.0, -9.0, 4.0]
    y[3000:3100] = np.nan
    thin_x, thin_y = thinned(x, y, 50)
    assert len(thin_x) <= 102
    assert {0.0, 137.0, 2500.0, 4999.0} <= set(thin_x)
    assert (np.nanmax(thin_y), np.nanmin(thin_y)) == (9.0, -9.0)
    assert np.all(np.diff(thin_x) > 0.0)
    assert thinned(x[:90], y[:90], 50)[0] is not None
    assert len(thinned(x[:90], y[:90], 50)[0]) == 90


def test_an_axis_has_room_about_its_values() -> None:
    assert reach([1.0, 1.0], 0.5) == pytest.approx((0.75, 1.25))
    assert reach([0.0, 10.0], 0.5, 0.1) == pytest.approx((-1.0, 11.0))


@pytest.mark.parametrize(("scenario", "seed"), [("town04", 1003), ("slalom", 5), ("traffic", 2), ("random", 1001)])
def test_obstacles_are_drawn_at_their_true_positions(scenario: str, seed: int) -> None:
    layout = layouts(scenario, [seed])[seed]
    with closing(FourLane(scenario)) as world:
        world.reset(seed=seed)
        obstacles = [obj for obj in solid_objects(world.ego) if obj.speed == 0.0]
        assert len(layout.static_obstacles) == len(obstacles)
        assert layout.route.length_m == world.route_length_m
        for obj, drawn in zip(obstacles, layout.static_obstacles, strict=True):
            assert drawn.centre_m == pytest.approx(tuple(obj.position))
            assert np.ptp(drawn.route_m) == pytest.approx(obj.LENGTH)
            assert np.ptp(drawn.offset_m) == pytest.approx(obj.WIDTH)
            sides = np.hypot(*(drawn.corners_m - np.roll(drawn.corners_m, 1, axis=0)).T)
            assert sorted(sides) == pytest.approx(sorted([obj.LENGTH, obj.LENGTH, obj.WIDTH, obj.WIDTH]))


def test_zooms_show_each_row_of_obstacles_in_driving_order() -> None:
    layout = layouts("town04", [1000])[1000]
    met = [obj.s_m for obj in layout.static_obstacles]
    assert [s_m for s_m, _ in paths.zooms([layout])] == pytest.approx(sorted(met))
    empty = layouts("town04-clean", [1000])[1000]
    assert paths.zooms([empty]) == [], "a road with nothing on it is no picture"


def drive(layout: RoadLayout, offset_m: float) -> StepTable:
    """Along the lane at a constant offset, 1 m a step."""
    scenario = layout.scenario
    s = np.arange(scenario.ego.s_m, scenario.goal.s_m, 1.0)
    world = layout.centre.position(s, layout.route.offset_m + offset_m)
    heading = layout.centre.heading(s)
    rows = [
        Step(
            k / 60.0,
            *world[k],
            heading[k],
            5.5,
            0.0,
            layout.route.progress(s[k]),
            offset_m,
            1.0,
            throttle=0.1,
            steering=0.2,
        )
        for k in range(len(s))
    ]
    return StepTable.of(rows)


def test_a_path_is_drawn_over_the_road_at_its_offset() -> None:
    found = layouts("town04-clean", [7, 8])
    layout = found[7]
    track = Track(7, "d0", False, drive(layout, 0.75))
    svgs = {chart.caption: str(chart.svg) for chart in paths.charts(found, [track], "a test")}
    assert len(svgs) == 2
    middle_m = 0.5 * (layout.scenario.ego.s_m + layout.scenario.goal.s_m)
    zoomed = str(paths.zoom(layout, [layout], [track], middle_m, "a test"))
    (path,) = paths_of(zoomed, "path d0")
    (centre,) = paths_of(zoomed, "centre")
    middle_px = 0.5 * paths.WIDTH
    apart_px = np.interp(middle_px, *path.T) - np.interp(middle_px, *centre.T)
    assert apart_px == pytest.approx(0.75 * paths.WIDTH / paths.ZOOM_M, abs=0.5), "to scale, and right is down"
    (unrolled,) = (svg for caption, svg in svgs.items() if caption.startswith("Offset"))
    assert unrolled.count("×") == 1, "where it failed"
    (flat,) = paths_of(unrolled, "path d0")
    assert np.ptp(flat[:, 1]) == pytest.approx(0.0, abs=0.11)


def test_with_a_road_per_seed_the_map_shows_one() -> None:
    found = layouts("random", [1, 2])
    tracks = [Track(seed, "d0", True, drive(layout, 0.0)) for seed, layout in found.items()]
    captions = [chart.caption for chart in paths.charts(found, tracks, "a test")]
    assert all("seed 1 (each seed has its own road)" in caption for caption in captions if "Offset" not in caption)
    charts = paths.charts(found, tracks, "a test")
    drawn = [len(paths_of(str(chart.svg), "path d0")) for chart in charts]
    assert drawn[:2] == [1, 2]


def test_commands_are_drawn_with_the_pids() -> None:
    layout = RoadLayout(scenarios.load("straight").draw(1), 1)
    table = drive(layout, 0.0)
    svg = str(figures.charts("straight.clear.vpf.1", "d0", table).steering)
    assert len(paths_of(svg, "command d0")) == 1
    assert paths_of(svg, "shadow") == [], "nothing is drawn of what is not known"


def test_dots_have_intervals() -> None:
    found = [Dot("town04", "vpf", 0, "d0", 0.5, (0.4, 0.7)), Dot("town04", "vpf", 1, "d0", 0.6, None)]
    svg = str(interval_chart.chart(found, [Mark("town04", 0, 0.74)], "path MSE", None))
    (whisker,) = paths_of(svg, "whisker d0")
    (paper,) = paths_of(svg, "paper")
    (dot,) = re.findall(r'<circle class="mark d0" cx="([\d.]+)"', svg)
    scale = (paper[0, 0] - whisker[0, 0]) / (0.74 - 0.4)
    assert float(dot) == pytest.approx(whisker[0, 0] + 0.1 * scale, abs=0.15)
    assert len(paths_of(svg, "mark hollow d0")) == 1, "the other weather"
