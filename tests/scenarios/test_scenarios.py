"""Scenario files: the catalog is valid, and each fault of an invalid file is one clear line."""

import tomllib
import xml.etree.ElementTree as ET
from math import atan2, pi
from pathlib import Path

import numpy as np
import pytest
from malformed import PLAIN as FILE
from open_drive import point_on_lines_and_arcs, town04

from vpf_sim import scenarios
from vpf_sim.envs.road import build_road
from vpf_sim.errors import InputError
from vpf_sim.types import VehicleModel


def test_valid_file_is_loaded_with_defaults() -> None:
    scenario = scenarios.parse(FILE, "my.toml")
    assert scenario.road.length_m == 170.0
    assert (scenario.ego.lane, scenario.ego.speed_mps, scenario.goal.kind) == (2, 5.55, "reach")
    assert scenario.time_limit_s == pytest.approx(3.0 * (165.0 - 5.0) / 5.55)


def test_faulty_only_segment_is_not_reported_as_missing() -> None:
    text = 'schema = 1\n[road]\nsegments = [{kind = "line", length_m = -1}]\n[goal]\ns_m = 20.0'
    with pytest.raises(InputError) as caught:
        scenarios.parse(text, "my.toml")
    assert str(caught.value) == "my.toml: road.segments[0].length_m: expected > 0, got -1"


def test_unknown_scenario_suggests_the_nearest_name() -> None:
    with pytest.raises(InputError, match=r"^unknown scenario 'town4': did you mean 'town04'\?$"):
        scenarios.load("town4")


def test_a_scenario_is_loaded_from_a_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(FILE, "utf-8")
    assert scenarios.load(str(path)) == scenarios.parse(FILE, "mine.toml")


def test_draw_adds_a_value_in_the_interval_and_clears_vary() -> None:
    scenario = scenarios.parse(FILE, "my.toml")
    drawn = [scenario.draw(seed).bodies[0].lateral_m for seed in range(200)]
    assert min(drawn) >= -0.2
    assert max(drawn) <= 0.3
    assert max(drawn) - min(drawn) > 0.45
    assert scenario.draw(7) == scenario.draw(7)
    assert scenario.draw(7).draw(8) == scenario.draw(7)


def test_every_varied_value_has_its_own_draw() -> None:
    drawn, plain = scenarios.load("slalom").draw(3), scenarios.load("slalom")
    changes = [drawn.ego.lateral_m - plain.ego.lateral_m]
    for after, before in zip(drawn.bodies, plain.bodies, strict=True):
        changes += [after.lateral_m - before.lateral_m, after.s_m - before.s_m]
    shares = np.array(changes) / [0.3, *[0.2, 3.0] * len(plain.bodies)]  # of what the seed may change
    assert np.abs(shares).max() <= 1.0
    assert np.diff(np.sort(shares)).min() > 1e-4


def test_additional_object_does_not_change_other_draws() -> None:
    more = FILE.replace("[vary]", '[[bodies]]\nkind = "cone"\ns_m = 30.0\nlane = 1\n[vary]')
    assert scenarios.parse(more, "a").draw(3).bodies[0] == scenarios.parse(FILE, "b").draw(3).bodies[0]


def test_catalog_contains_the_documented_scenarios() -> None:
    assert {
        "town04",
        "town04-clean",
        "straight",
        "curve-left",
        "curve-right",
        "heading-30",
        "slalom",
        "gate-course",
        "gate-traffic",
    } <= set(scenarios.names())


@pytest.mark.parametrize("name", scenarios.names())
def test_every_seed_of_the_catalog_is_valid(name: str) -> None:
    scenario = scenarios.load(name)
    for seed in range(50):
        drawn = scenario.draw(seed)
        assert type(drawn).model_validate(drawn.model_dump(by_alias=True)) == drawn
        assert getattr(drawn, "vary", {}) == {}, "nothing is left to draw"


@pytest.mark.parametrize("name", ["blocked", "gate-course"])
def test_barriers_that_close_a_road_leave_no_gap_for_a_car(name: str) -> None:
    """Neither between two of them, which may stand one behind the other, nor beside the outermost."""
    scenario = scenarios.load(name)
    lane_m, deep, wide = scenario.road.lane_width_m, 0.5, 3.0
    for seed in range(200):
        row = sorted((body for body in scenario.draw(seed).bodies if body.kind == "barrier"), key=lambda b: -b.lane)
        left_m = np.array([(scenario.road.lanes - b.lane + 0.5) * lane_m + b.lateral_m - 0.5 * wide for b in row])
        gaps = np.diff([-wide, *left_m, scenario.road.lanes * lane_m]) - wide
        along = np.maximum(np.abs(np.diff([b.s_m for b in row])) - deep, 0.0)
        assert np.hypot(gaps, [0.0, *along, 0.0]).max() < VehicleModel().width_m


def road_45() -> tuple[ET.Element, float, float]:
    """Road 45 of Town04, and from the file: t of the centre of its second lane from the right, and the width."""
    roads = ET.parse(town04()).getroot().iter("road")
    road = next(road for road in roads if road.get("id") == "45")
    edge, centres = float(road.find("lanes/laneOffset").get("a")), []  # type: ignore[union-attr, arg-type]
    for lane in sorted(road.findall("lanes/laneSection/left/lane"), key=lambda lane: int(lane.get("id", 0))):
        width = float(lane.find("width").get("a"))  # type: ignore[union-attr, arg-type]
        if lane.get("type") == "driving":
            centres.append((edge + width / 2.0, width))
        edge += width
    return road, *centres[-2]  # driven towards decreasing s, the outermost lane is the rightmost


@pytest.mark.parametrize("name", ["town04", "town04-clean"])
def test_town04_has_the_lane_centre_of_road_45_to_a_centimetre(name: str) -> None:
    road, t, width = road_45()
    scenario = scenarios.load(name)
    lane = build_road(scenario, np.random.default_rng(0)).network.get_lane(("start", "end", 4 - scenario.ego.lane))
    assert scenario.road.lane_width_m == width
    places = np.linspace(float(road.get("length", 0)), 0.0, 600)
    points = np.array([point_on_lines_and_arcs(road, s, t) for s in places])
    local = np.array([lane.local_coordinates(point) for point in points])
    assert np.abs(local[:, 1]).max() < 0.01
    assert (np.diff(local[:, 0]) > 0.0).all()
    assert np.abs(local[[0, -1], 0] - [0.0, lane.length]).max() < 0.01


def test_town04_starts_ends_and_has_its_cars_where_the_paper_had_them() -> None:
    road, t, _ = road_45()
    scenario = scenarios.load("town04")
    lane = build_road(scenario, np.random.default_rng(0)).network.get_lane(("start", "end", 2))
    first, second = scenario.bodies
    expected = [(540.0, t), (340.0, t), (502.7, t - 2.09), (414.1, t + 0.91)]
    actual = [(scenario.ego.s_m, 0.0), (scenario.goal.s_m, 0.0), (first.s_m, first.lateral_m)]
    actual.append((second.s_m, second.lateral_m))
    for (s, across), place in zip(expected, actual, strict=True):
        assert np.hypot(*(lane.position(*place) - point_on_lines_and_arcs(road, s, across))) < 0.01
    assert np.hypot(*(lane.position(second.s_m, second.lateral_m) - [-188.3, 406.4])) < 0.1  # the paper's own point


def test_town04_is_driven_to_the_right_in_both_bends() -> None:
    road, t, _ = road_45()
    scenario = scenarios.load("town04")
    ahead = point_on_lines_and_arcs(road, 539.0, t) - point_on_lines_and_arcs(road, 540.0, t)
    lane = build_road(scenario, np.random.default_rng(0)).network.get_lane(("start", "end", 2))
    heading = lane.heading_at(scenario.ego.s_m + 0.5)
    assert abs((heading - atan2(ahead[1], ahead[0]) + pi) % (2.0 * pi) - pi) < 1e-3
    radii = [segment.radius_m for segment in scenario.road.segments if segment.kind == "arc"]
    assert all(radius > 0.0 for radius in radii)


def test_the_slalom_has_a_car_every_50_m_on_alternate_sides() -> None:
    bodies = scenarios.load("slalom").bodies
    assert np.diff([obj.s_m for obj in bodies]).tolist() == [50.0] * (len(bodies) - 1)
    assert [obj.lateral_m for obj in bodies] == [(-1) ** (i + 1) * 1.2 for i in range(len(bodies))]


def test_catalog_files_start_with_a_description() -> None:
    folder = Path(scenarios.__file__).parent / "catalog"
    for path in folder.glob("*.toml"):
        text = path.read_text("utf-8")
        assert text.startswith("# ")
        assert tomllib.loads(text)["schema"] == 1


@pytest.mark.parametrize("name", ["random-marks", "random-dash-cam"])
def test_a_base_may_have_a_base_itself(name: str) -> None:
    mine = scenarios.parse(f'schema = 1\nbase = "{name}"\n[random]\nlanes = 3\n', "mine.toml")
    assert isinstance(mine, scenarios.RandomScenario)
    below = scenarios.load(name)
    assert mine.random.lanes == 3
    assert (mine.random.look, mine.ego.camera) == (below.random.look, below.ego.camera)


def test_fields_that_came_later_change_a_scenarios_text_only_where_they_are_given() -> None:
    """Runs store the hash of this text, so `score` and `--resume` accept runs from before the field."""
    road = scenarios.load("straight").road
    widths = [{"s_m": 0.0, "lanes_m": [3.0] * road.lanes}]
    given = type(road).model_validate({"lanes": road.lanes, "segments": list(road.segments), "widths": widths})
    assert "widths" not in repr(road)
    assert "widths" in repr(given)


def test_abilities_are_not_part_of_what_is_driven() -> None:
    """Runs store the hash of this text; a run of a scenario is the same whatever it says of abilities."""
    named = scenarios.parse('abilities = ["follow", "crossing"]' + FILE, "my.toml")
    assert named.abilities == ("follow", "crossing")
    assert repr(named) == repr(scenarios.parse(FILE, "my.toml"))
    assert scenarios.of_table(scenarios.as_table(named), "kept").abilities == named.abilities


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ('abilities = ["follow", "fly"]', r"abilities\[1\]: expected one of keep-lane, .*, got 'fly'"),
        ('abilities = ["follow", "follow"]', "abilities: expected each once, got follow 2 times"),
        ('abilities = "follow"', "abilities: expected a list, got 'follow'"),
    ],
)
@pytest.mark.parametrize("base", ["straight", "random", "highway-v0"])
def test_a_wrong_ability_is_one_line(line: str, fault: str, base: str) -> None:
    text = f"{line}\nschema = 1\n" + (
        '[highway_env]\nid = "highway-v0"' if base == "highway-v0" else f'base = "{base}"'
    )
    with pytest.raises(InputError, match=rf"^my\.toml: {fault}$"):
        scenarios.parse(text, "my.toml")
