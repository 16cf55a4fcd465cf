"""Symbols on the road, other lines, and shadows across it."""

import cv2
import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera.ground.content import shadow_batches
from vpf_sim.envs.camera.ground.hatching import hatching
from vpf_sim.envs.camera.ground.paint import LINE, painted
from vpf_sim.envs.camera.ground.road_marks import road_marks
from vpf_sim.envs.camera.ground.words import LETTERS, WORD_M, WORDS, word
from vpf_sim.envs.camera.layout import lane_shapes, lines, outer_edges, stripes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.weather import PRESETS
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

ROAD = """
base = "straight"
schema = 1
[road.look]
"""


STRAIGHT = """
schema = 1
[road]
segments = [{{kind = "line", length_m = 200}}]
[ego]
lane = {lane}
[goal]
s_m = 150.0
[road.look]
"""


def frame(look: str, weather: str = "ClearSunset", seed: int = 4) -> Image:
    """The first frame on a straight road; sensor noise and grain are the same for every look."""
    env = FourLane(scenarios.parse(ROAD + look, "look.toml"), weather)
    return np.asarray(env.reset(seed=seed)[0]["image"])


@pytest.mark.parametrize("seed", range(4))
def test_symbols_lie_within_their_lanes(seed: int) -> None:
    env = FourLane("town04", frames=False)
    env.reset(seed=0)
    shapes = lane_shapes(env.road)
    polygons = road_marks(shapes, np.random.default_rng(seed))
    _, lateral_m = env.road.network.centre.local(polygons)
    lanes = np.floor((lateral_m + env.road.network.half_width_m) / 3.5 - 1e-6 * np.sign(lateral_m))
    assert np.abs(lateral_m).max() <= env.road.network.half_width_m + 0.01
    middle = lateral_m.mean(axis=1, keepdims=True)
    assert (np.abs(lateral_m - middle) <= 1.75 + 0.01).all()
    assert len(np.unique(lanes)) >= 4


@pytest.mark.parametrize("seed", range(4))
def test_arrows_and_stop_lines_face_those_who_drive_in_the_lane(seed: int) -> None:
    env = FourLane("oncoming", frames=False)
    env.reset(seed=0)
    symbols = road_marks(lane_shapes(env.road), np.random.default_rng(seed))
    along, across = env.road.network.centre.local(symbols)
    long_m, wide_m = np.ptp(along, axis=1), np.ptp(across, axis=1)
    for forward in (1.0, -1.0):  # the right lane is the ego's
        in_lane = np.sign(across.mean(axis=1)) == forward
        tips = along[
            in_lane & np.isclose(long_m, 1.8, atol=0.1) & np.isclose(wide_m, 0.8, atol=0.02)
        ]  # heads of arrows straight on
        assert len(tips) > 0
        assert np.sign(tips[:, 2] - tips[:, 0]).tolist() == [forward] * len(tips)
        stops = along[in_lane & (wide_m > 3.0)].mean(axis=1)
        bars = along[in_lane & np.isclose(long_m, 3.0, atol=0.1) & np.isclose(wide_m, 0.5, atol=0.02)].mean(axis=1)
        nearest = bars[np.abs(stops[:, None] - bars).argmin(axis=1)]
        assert len(stops) > 0
        assert forward * (nearest - stops) == pytest.approx(1.5 + 0.25 + 1.5, abs=0.01)


def test_a_bus_lane_alone_on_its_road_has_no_broad_line() -> None:
    road = scenarios.parse('base = "straight"\nschema = 1\n[road]\nlanes = 1\n[ego]\nlane = 1\n', "one.toml")
    env = FourLane(road, frames=False)
    env.reset(seed=0)
    plain, bus = (
        sum(np.count_nonzero(batch.values == LINE) for batch in painted(lane_shapes(env.road), 0, look) if batch.thin)
        for look in (RoadAppearance(), RoadAppearance(bus_lane=True))
    )
    assert plain == bus


@pytest.mark.parametrize("seed", range(3))
def test_hatched_areas_narrow_the_outermost_lanes(seed: int) -> None:
    env = FourLane("straight", frames=False)
    env.reset(seed=0)
    polygons = hatching(outer_edges(lane_shapes(env.road)), np.random.default_rng(seed), 3.5)
    along, across = env.road.network.centre.local(polygons)
    inwards = env.road.network.half_width_m - np.abs(across)
    assert inwards.min() > -0.01
    assert inwards.max() == pytest.approx(1.2 + 0.15, abs=0.01)
    for side in (-1.0, 1.0):
        here = np.sign(across.mean(axis=1)) == side
        ends = np.sort(along[here].max(axis=1))
        assert 30.0 < np.diff(ends).max() < 90.0, "free road between the areas"
        bars = here & (np.ptp(inwards, axis=1) > 1.15)
        assert np.count_nonzero(bars) > 20
        assert np.ptp(along[bars], axis=1) == pytest.approx(0.4 + np.ptp(inwards[bars], axis=1), abs=0.01), "45 deg"


@pytest.mark.parametrize(("lane_m", "areas_m"), [(2.1, 0.0), (2.5, 0.5), (4.0, 1.35)])
def test_hatching_leaves_two_metres_of_a_lane(lane_m: float, areas_m: float) -> None:
    """Also of the only lane of a road, which has them on both sides, one after the other."""
    road = f'base = "straight"\nschema = 1\n[road]\nlanes = 1\nlane_width_m = {lane_m}\n[ego]\nlane = 1\n[vary]\n'
    env = FourLane(scenarios.parse(f'{road}"ego.lateral_m" = [0.0, 0.0]\n', "road.toml"), frames=False)
    env.reset(seed=0)
    polygons = hatching(outer_edges(lane_shapes(env.road)), np.random.default_rng(3), lane_m)
    along, across = env.road.network.centre.local(polygons)
    assert 0.5 * lane_m - np.abs(across).min(initial=0.5 * lane_m) == pytest.approx(areas_m, abs=0.01)
    for s in np.arange(0.0, 200.0, 1.0):
        here = (along.min(axis=1) <= s) & (along.max(axis=1) >= s)
        assert len(set(np.sign(across[here].mean(axis=1)))) <= 1, "on one side at a time"


def test_hatching_is_seen_within_the_lane() -> None:
    env = FourLane("straight", frames=False)
    env.reset(seed=4)
    polygons = hatching(outer_edges(lane_shapes(env.road)), stream(4, "hatching"), 3.5)
    along, across = env.road.network.centre.local(polygons)
    bars = (np.ptp(across, axis=1) > 1.15) & (across.mean(axis=1) > 0.0)
    start = along[bars & (along.min(axis=1) > 20.0)].min()
    look = f"[ego]\nlane = 1\ns_m = {start - 15.0}\n[road.look]\nhatching = "
    plain, hatched = (frame_of(look + value).astype(int) for value in ("false", "true"))
    change = (hatched - plain).max(axis=2)
    assert (change[:239] == 0).all()
    assert (change[240:, 320:] > 40).sum() > 2_000
    assert (change[300:, :300] > 40).sum() == 0


def frame_of(keys: str) -> Image:
    """The first frame on a straight road of four lanes, without sensor noise."""
    scenario = scenarios.parse(f'base = "straight"\nschema = 1\n{keys}', "look.toml")
    env = FourLane(scenario, "clear", rig=Rig(noise_sd=0.0))
    return np.asarray(env.reset(seed=4)[0]["image"])


def test_marks_brighten_the_lanes_alone() -> None:
    plain, marked = (frame(f"marks = {value}", "clear").astype(int) for value in ("false", "true"))
    change = (marked - plain).max(axis=2)
    assert (change[:239] == 0).all()
    assert 200 < (change[240:] > 40).sum() < 60_000


@pytest.mark.parametrize("text", WORDS)
def test_words_read_from_left_to_right_and_are_as_long_as_they_should_be(text: str) -> None:
    strokes = np.array(list(word(text)))
    assert np.ptp(strokes[..., 0]) == pytest.approx(WORD_M, abs=0.25)
    assert abs(strokes[..., 1].min() + strokes[..., 1].max()) < 0.25
    assert np.ptp(strokes[..., 1]) < 3.0
    letters = np.split(strokes, np.cumsum([len(LETTERS[letter]) for letter in text])[:-1])
    middles = [float(letter[..., 1].mean()) for letter in letters]
    assert middles == sorted(middles)


def test_overlapping_strokes_are_painted_through() -> None:
    """Polygons of one strip are filled together, and what two of them cover is left out."""
    env = FourLane(scenarios.parse(ROAD + "bus_lane = true", "look.toml"), frames=False)
    env.reset(seed=0)
    batches = painted(lane_shapes(env.road), 0, env.road.network.appearance)
    (symbols,) = [batch for batch in batches if batch.polygons_m.shape[1] == 4 and (batch.values == LINE - 8).all()]
    assert len(set(symbols.strips)) == len(symbols.values) > 50


@pytest.mark.parametrize("seed", range(5))
def test_a_bus_lane_has_no_symbols_but_bus_and_crossings(seed: int) -> None:
    env = FourLane("town04", frames=False)
    env.reset(seed=0)
    shapes = lane_shapes(env.road)
    along, across = env.road.network.centre.local(road_marks(shapes, np.random.default_rng(seed), shapes[-1:]))
    in_lane = across.mean(axis=1) > 3.5
    crossing = (np.ptp(along, axis=1) > 2.9) | (np.ptp(across, axis=1) > 3.4)
    starts = (along[in_lane & ~crossing].min(axis=1) - shapes[-1].s_m[0]) % 40.0
    assert len(starts) > 100
    assert ((starts < 2.5) | (starts > 39.8)).all()


TOWN = {
    "bus_lane": (1, [-1.75], []),
    "tram_rails": (4, [-0.75, 0.75], [-1.2, 0.0, 1.2]),
    "kerbs": (1, [1.75 + 0.575], [0.0]),
}


@pytest.mark.parametrize("key", TOWN)
def test_parts_of_a_street_are_bright_where_they_lie(key: str) -> None:
    lane, bright_m, as_before_m = TOWN[key]
    plain, street = (levels(f"{key} = {value}", lane, [*bright_m, *as_before_m]) for value in ("false", "true"))
    assert (street - plain)[: len(bright_m)].min() > 12.0
    assert np.abs(street - plain)[len(bright_m) :].max(initial=0.0) < 4.0


def levels(look: str, lane: int, laterals_m: list[float]) -> Floats:
    """Mean grey levels 8 to 20 m ahead, at lateral positions right of the middle of a lane on a straight road."""
    env = FourLane(scenarios.parse(f"{STRAIGHT.format(lane=lane)}{look}", "look.toml"), "clear")
    picture = cv2.cvtColor(env.reset(seed=4)[0]["image"], cv2.COLOR_RGB2GRAY)
    ahead_m, camera = np.linspace(8.0, 20.0, 400), env.rig.camera
    column = camera.cx_px + camera.fx_px * np.array(laterals_m)[:, None] / ahead_m
    row = np.broadcast_to(camera.cy_px + camera.fy_px * camera.height_m / ahead_m, column.shape)
    found = cv2.remap(picture.astype(np.float32), column.astype(np.float32), row.astype(np.float32), cv2.INTER_LINEAR)
    return np.asarray(found.mean(axis=1), float)


def test_a_double_line_has_a_gap_as_wide_as_its_lines() -> None:
    road = scenarios.parse('base = "oncoming"\nschema = 1\n[road.look]\ndouble_lines = true', "look.toml")
    env = FourLane(road, frames=False)
    env.reset(seed=0)
    across_m = np.arange(-0.4, 0.4, 0.01)
    s, lateral = np.broadcast_arrays(np.linspace(20.0, 40.0, 50)[:, None], across_m)
    points = env.road.network.centre.position(s.ravel(), lateral.ravel()).astype(np.float32)
    strips = [batch for batch in painted(lane_shapes(env.road), 0, env.road.network.appearance) if batch.thin]
    white = [polygon for batch in strips for polygon in batch.polygons_m[batch.values == LINE].astype(np.float32)]
    inside = [any(cv2.pointPolygonTest(p, point, False) >= 0 for p in white) for point in points.tolist()]
    share = np.array(inside).reshape(s.shape).mean(axis=0)
    lines_at = np.abs(np.abs(across_m) - 0.15) < 0.06
    assert share[lines_at].min() == 1.0
    assert share[np.abs(across_m) < 0.06].max() == 0.0


def test_stripes_have_their_lengths() -> None:
    env = FourLane("straight", frames=False)
    env.reset(seed=0)
    (line, *_) = [line for line in lines(lane_shapes(env.road)) if line.striped]
    spans = stripes(line, 6.0, 12.0)
    assert np.allclose(spans[:, 1] - spans[:, 0], 6.0)
    assert np.allclose(np.diff(spans[:, 0]), 18.0)


def test_studs_lie_in_the_middle_of_the_gaps() -> None:
    env = FourLane("straight", frames=False)
    env.reset(seed=0)
    shapes = lane_shapes(env.road)
    plain, studded = (painted(shapes, 0, RoadAppearance(studs=studs)) for studs in (False, True))
    bright = [
        {tuple(place) for batch in one for place in batch.polygons_m[batch.values > 190].mean(axis=1)}
        for one in (plain, studded)
    ]
    studs = np.array(sorted(bright[1] - bright[0]))
    middles = np.concatenate([stripes(line, 3.0, 6.0)[:, 1] + 3.0 for line in lines(shapes) if line.striped])
    middles = middles[middles < shapes[0].s_m[-1]]
    assert len(studs) == len(middles) > 100
    along, _ = env.road.network.centre.local(studs)
    assert np.sort(along) == pytest.approx(np.sort(middles), abs=0.01)


def test_grain_scales_the_texture_of_the_road() -> None:
    """Without grain only the paint and the road's wear are left."""
    rough = {
        grain: frame(f"grain = {grain}", "clear")[330:470, 250:390].std(axis=(0, 1)).mean() for grain in (0.0, 0.5, 1.0)
    }
    assert rough[0.0] < 0.5 * rough[1.0]
    assert rough[0.0] < rough[0.5] < rough[1.0]


def test_yellow_lines_are_yellow_and_asphalt_stays_grey() -> None:
    white, yellow = (frame(f'lines = "{colour}"', "clear").astype(int) for colour in ("white", "yellow"))
    painted = white[300:].min(axis=2) > 190
    assert painted.sum() > 200
    assert (yellow[300:][painted][:, 2] < yellow[300:][painted][:, 0] - 60).mean() > 0.9
    asphalt = white[300:].max(axis=2) < 120
    assert np.abs(yellow - white)[300:][asphalt].mean() < 1.0


def test_shadows_darken_the_road_as_much_as_the_light_says() -> None:
    light = Light.of(PRESETS["ClearSunset"])
    ratios = []
    for seed in range(4, 10):
        lit, shaded = (frame(f"shadows = {value}", seed=seed) for value in ("false", "true"))
        grey, dark = (cv2.blur(picture, (9, 9)).astype(float)[260:].mean(axis=2) for picture in (lit, shaded))
        inside = dark < 0.5 * (1.0 + light.shadow) * grey
        ratios += (dark / grey)[cv2.erode(inside.astype(np.uint8), np.ones((15, 15))) > 0].tolist()
        assert (lit[:239] == shaded[:239]).mean() > 0.98
    assert len(ratios) > 500
    assert np.median(ratios) == pytest.approx(light.shadow, abs=0.04)


def test_an_overcast_sky_casts_no_shadows() -> None:
    assert np.array_equal(frame("shadows = true", "rain"), frame("shadows = false", "rain"))


def test_overlapping_shadows_are_filled_one_by_one() -> None:
    square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    (batch,) = shadow_batches([square, square + 1.0])
    assert len(np.unique(batch.strips)) == 2
