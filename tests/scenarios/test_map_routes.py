"""Routes through OpenDRIVE maps: connected roads, junctions, directions, lanes that end and begin, marks."""

import tomllib
from pathlib import Path

import numpy as np
import open_drive as xodr
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.errors import InputError
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

START = (0.0, 0.0, 0.4)
BEND = xodr.of_curvature(lambda s: np.full(s.shape, 0.01), 60.0, START)
ON = xodr.of_curvature(lambda s: np.zeros(s.shape), 50.0, BEND.end)
ARC, LINE = '<arc curvature="0.01"/>', "<line/>"
ONE_WAY = xodr.section(xodr.lane(-1), xodr.lane(-2))
PAINTED = '<roadMark sOffset="0" type="{}" color="{}"/>'


def fault(folder: Path, keys: str, *elements: str) -> str:
    """What is said of a route that is refused."""
    with pytest.raises(InputError) as caught:
        xodr.loaded(folder, keys, *elements)
    return str(caught.value).replace(str(folder), "F").replace("\\", "/")


def first(links: str, lanes: str = ONE_WAY) -> str:
    """The road A: a bend to the left."""
    return xodr.road("A", xodr.geometry(ARC, 60.0, pose=START), lanes, links)


def second(links: str = "", lanes: str = ONE_WAY, name: str = "B", more: str = "") -> str:
    """A straight road where A ends, along its own s."""
    return xodr.road(name, xodr.geometry(LINE, 50.0, pose=BEND.end), lanes, links, more)


def right_of(curve: xodr.Curve, t: float) -> Floats:
    return curve.shifted(lambda s: np.full(s.shape, -t))[::200]


def assert_on(scenario: Scenario, lane: int, *truth: Floats) -> None:
    """The lane's centre runs through points of all roads, in order."""
    line = CentreLine(scenario.road)
    along, right = line.local(np.concatenate(truth))
    assert np.abs(right - scenario.road.lane_offset_m(lane)).max() < 0.01
    assert (np.diff(along) > -1e-3).all()
    assert np.abs(along[[0, -1]] - [0.0, line.length_m]).max() < 0.01


def test_two_connected_roads_are_one(tmp_path: Path) -> None:
    made = xodr.loaded(tmp_path, 'route = ["A", "B"]', first(xodr.linked("successor", "B")), second())
    assert_on(made, 1, right_of(BEND, 5.25), right_of(ON, 5.25))
    assert [segment.kind for segment in made.road.segments] == ["arc", "line"]


def test_a_road_is_driven_against_its_s_if_it_is_connected_at_its_end(tmp_path: Path) -> None:
    """B is drawn from its far end, so that its lanes on the left lead away from A."""
    x, y, heading = ON.end
    geometry = xodr.geometry(LINE, 50.0, pose=(x, y, heading + np.pi))
    back = xodr.road("B", geometry, xodr.section(xodr.lane(2), xodr.lane(1)))
    made = xodr.loaded(tmp_path, 'route = ["A", "B"]', first(xodr.linked("successor", "B", "end")), back)
    assert_on(made, 1, right_of(BEND, 5.25), right_of(ON, 5.25))


def junction(*connections: tuple[str, str]) -> str:
    """A junction that roads enter from A: a road and the pairs of lanes."""
    inside = "".join(
        f'<connection id="{i}" incomingRoad="A" connectingRoad="{name}" contactPoint="start">{links}</connection>'
        for i, (name, links) in enumerate(connections)
    )
    return f'<junction id="J">{inside}</junction>'


CROSSING = (
    first(xodr.linked("successor", "J", kind="junction")),
    junction(("left", '<laneLink from="-1" to="-1"/>'), ("on", '<laneLink from="-2" to="-1"/>')),
    xodr.road("left", xodr.geometry('<arc curvature="0.05"/>', 20.0, pose=BEND.end), xodr.section(xodr.lane(-1))),
    xodr.road(
        "on",
        xodr.geometry(LINE, 50.0, pose=BEND.end),
        f'<laneOffset s="0" a="-3.5"/>{xodr.section(xodr.lane(-1))}',
        xodr.linked("successor", "C"),
    ),
    xodr.road(
        "C",
        xodr.geometry(LINE, 30.0, pose=ON.end),
        xodr.section(xodr.lane(-1), xodr.lane(-2, inside='<link><predecessor id="-1"/></link>')),
    ),
)


def test_a_junction_leads_on_by_its_lane_links(tmp_path: Path) -> None:
    """The lane that goes straight on is the right one of A, the only one in the junction, and the right one of C."""
    made = xodr.loaded(tmp_path, 'route = ["A", "on", "C"]', *CROSSING)
    assert made.road.lanes == 1
    beyond = xodr.of_curvature(lambda s: np.zeros(s.shape), 30.0, ON.end)
    assert_on(made, 1, right_of(BEND, 5.25), right_of(ON, 5.25), right_of(beyond, 5.25))


def test_a_junction_can_be_left_by_another_lane(tmp_path: Path) -> None:
    made = xodr.loaded(tmp_path, 'route = ["A", "left"]', *CROSSING)
    away = xodr.of_curvature(lambda s: np.full(s.shape, 0.05), 20.0, BEND.end)
    assert_on(made, 1, right_of(BEND, 1.75), right_of(away, 1.75))


def test_the_route_between_two_roads_is_found(tmp_path: Path) -> None:
    expected = xodr.loaded(tmp_path, 'route = ["A", "on", "C"]', *CROSSING)
    assert xodr.loaded(tmp_path, 'from = "A"\nto = "C"', *CROSSING) == expected


def test_a_road_that_no_lane_leads_to_is_refused(tmp_path: Path) -> None:
    assert fault(tmp_path, 'from = "C"\nto = "A"', *CROSSING) == (
        "F/scenario.toml: road.to: expected a road that a lane leads to from road C, without lane changes, got 'A'"
    )


def test_roads_that_are_not_connected_are_refused(tmp_path: Path) -> None:
    assert fault(tmp_path, 'route = ["A", "C"]', *CROSSING) == (
        "F/scenario.toml: road.route[1]: expected a road that road A leads to, one of left, on, got 'C'"
    )
    assert fault(tmp_path, 'route = ["C", "A"]', *CROSSING).endswith("leads to, one of none, got 'A'")


def test_a_lane_that_ends_on_the_way_is_left_out(tmp_path: Path) -> None:
    """A has three lanes; its links name those of B, which has two: the right one ends."""
    lanes = [
        xodr.lane(-1, inside='<link><successor id="-1"/></link>'),
        xodr.lane(-2, inside='<link><successor id="-2"/></link>'),
        xodr.lane(-3),
    ]
    made = xodr.loaded(
        tmp_path, 'route = ["A", "B"]', first(xodr.linked("successor", "B"), xodr.section(*lanes)), second()
    )
    assert made.road.lanes == 2
    assert_on(made, 1, right_of(BEND, 5.25), right_of(ON, 5.25))


def test_lanes_without_links_are_counted_from_the_right(tmp_path: Path) -> None:
    """A third lane begins at the left, beside the reference line, from which the others are shifted."""
    wider = f'<laneOffset s="0" a="3.5"/>{xodr.section(*(xodr.lane(-i) for i in (1, 2, 3)))}'
    made = xodr.loaded(tmp_path, 'route = ["A", "B"]', first(xodr.linked("successor", "B")), second(lanes=wider))
    assert made.road.lanes == 2
    assert_on(made, 1, right_of(BEND, 5.25), right_of(ON, 5.25))


def test_a_lane_that_opens_is_left_out(tmp_path: Path) -> None:
    """An exit widens from 0 to 3.5 m to the right of two lanes."""
    exit_ = xodr.lane(-3, "exit", 'a="0" b="0.07"')
    made = xodr.loaded(tmp_path, 'route = ["B"]', second(lanes=xodr.section(xodr.lane(-1), xodr.lane(-2), exit_)))
    assert made.road.lanes == 2
    assert_on(made, 1, right_of(ON, 5.25))


def test_a_direction_is_asked_for_where_both_are_possible(tmp_path: Path) -> None:
    both = second(lanes=xodr.section(xodr.lane(1), xodr.lane(-1)))
    assert fault(tmp_path, 'route = ["B"]', both) == (
        "F/scenario.toml: road.direction: expected forward or backward, as the route can be driven both ways, got none"
    )
    ahead = xodr.loaded(tmp_path, 'route = ["B"]\ndirection = "forward"', both)
    assert_on(ahead, 1, right_of(ON, 1.75))
    back = xodr.loaded(tmp_path, 'route = ["B"]\ndirection = "backward"', both)
    assert_on(back, 1, right_of(ON, -1.75)[::-1])
    assert fault(tmp_path, 'route = ["B"]\ndirection = "backward"', second()) == (
        "F/scenario.toml: road.direction: expected forward, as road B has no driving lanes the other way, got backward"
    )


def test_in_left_hand_traffic_lanes_on_the_left_lead_along_s(tmp_path: Path) -> None:
    lanes = xodr.section(xodr.lane(1), xodr.lane(2))
    made = xodr.loaded(tmp_path, 'route = ["B"]', second(lanes=lanes, more='rule="LHT"'))
    assert made.road.lanes == 2
    assert_on(made, 1, right_of(ON, -1.75))
    assert_on(made, 2, right_of(ON, -5.25))


def painted(number: int, kind: str, color: str = "white") -> str:
    """A lane with a mark on its border away from the reference line."""
    return xodr.lane(number, inside=PAINTED.format(kind, color))


@pytest.mark.parametrize(
    ("left", "inside", "right", "edges", "colour"),
    [
        (("solid", "white"), ("broken", "white"), ("solid", "white"), "both", "white"),
        (("solid", "yellow"), ("broken", "yellow"), ("solid", "white"), "both", "yellow"),
        (("solid solid", "yellow"), ("broken", "white"), ("none", "white"), "left", "white"),
        (("broken", "white"), ("broken", "white"), ("solid", "white"), "right", "white"),
        (("none", "white"), ("none", "white"), ("curb", "white"), "none", "white"),
    ],
)
def test_marks_tell_the_edge_lines_and_their_colour(
    left: tuple[str, str], inside: tuple[str, str], right: tuple[str, str], edges: str, colour: str, tmp_path: Path
) -> None:
    ahead = xodr.section(painted(0, *left), painted(-1, *inside), painted(-2, *right))
    look = xodr.loaded(tmp_path, 'route = ["B"]', second(lanes=ahead)).road.look
    assert (look.edge_lines, look.lines) == (edges, colour)
    back = xodr.section(painted(0, *left), painted(1, *inside), painted(2, *right))
    assert xodr.loaded(tmp_path, 'route = ["B"]', second(lanes=back)).road.look == look


def test_a_scenarios_look_goes_before_the_marks(tmp_path: Path) -> None:
    lanes = xodr.section(painted(0, "none"), painted(-1, "solid"))
    made = xodr.loaded(tmp_path, 'route = ["B"]\nlook = {edge_lines = "left", verge = "sand"}', second(lanes=lanes))
    assert (made.road.look.edge_lines, made.road.look.verge) == ("left", "sand")


def test_a_loaded_scenario_needs_no_map(tmp_path: Path) -> None:
    made = xodr.loaded(tmp_path, 'route = ["B"]', second())
    (tmp_path / "map.xodr").unlink()
    assert Scenario.model_validate(made.model_dump(by_alias=True)) == made


def test_a_map_lies_over_a_scenario_of_the_catalog(tmp_path: Path) -> None:
    """The road is the map's, all else that of the base."""
    xodr.write_map(tmp_path, second())
    path = xodr.write_scenario(tmp_path, 'route = ["B"]')
    content = tomllib.loads(path.read_text("utf-8"))
    path.write_text(f'base = "straight"\n{path.read_text("utf-8")}', "utf-8")
    made = scenarios.load(str(path))
    assert isinstance(made, Scenario)
    assert (made.road.lanes, made.road.length_m, made.goal.s_m) == (2, 50.0, content["goal"]["s_m"])
