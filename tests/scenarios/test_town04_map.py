"""Roads of CARLA's Town04, read from its OpenDRIVE file, against an independent evaluation of the file."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from open_drive import point_on_lines_and_arcs, town04, write_scenario

import vpf_sim
from vpf_sim import scenarios
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.opendrive import road_table
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Floats

ROUTE = ("6", "45", "145")  # 63 m, 585 m and, in a junction, on


@pytest.fixture(scope="module")
def roads() -> dict[str, ET.Element]:
    return {road.get("id", ""): road for road in ET.parse(town04()).getroot().iter("road")}


def loaded(folder: Path, keys: str, goal_m: float = 12.0) -> Scenario:
    """A scenario on Town04."""
    path = write_scenario(folder, f"opendrive = '{town04()}'\n{keys}", goal_m)
    scenario = scenarios.load(str(path))
    assert isinstance(scenario, Scenario)
    return scenario


def value(polynomials: list[ET.Element], key: str, s: float) -> float:
    """The polynomial of a list that is valid at s."""
    one = [element for element in polynomials if float(element.get(key, 0)) <= s + 1e-9][-1]
    u = s - float(one.get(key, 0))
    return sum(float(one.get(letter, 0)) * u**power for power, letter in enumerate("abcd"))


def lane_centres(road: ET.Element, s: float, side: str) -> list[float]:
    """t of the centres of the driving lanes of a side, from the outermost: in right-hand traffic that is the right."""
    section = [one for one in road.findall("lanes/laneSection") if float(one.get("s", 0)) <= s][-1]
    sign, edge, centres = (1.0 if side == "left" else -1.0), value(road.findall("lanes/laneOffset"), "s", s), []
    for lane in sorted(section.findall(f"{side}/lane"), key=lambda lane: abs(int(lane.get("id", 0)))):
        width = value(lane.findall("width"), "sOffset", s - float(section.get("s", 0)))
        if lane.get("type") == "driving":
            centres.append(edge + sign * width / 2.0)
        edge += sign * width
    return centres[::-1]


def lane_points(road: ET.Element, side: str) -> Floats:
    """(N, lanes, 2) m in our axes, in the direction of the drive; only lanes that are there all along."""
    length_m = float(road.get("length", 0))
    places = np.linspace(0.0, length_m, 5 + int(length_m / 20.0))[:: 1 if side == "right" else -1]
    centres = [lane_centres(road, s, side) for s in places]
    lanes = min(map(len, centres))
    rows = zip(places, centres, strict=True)
    return np.array([[point_on_lines_and_arcs(road, s, t) for t in row[:lanes]] for s, row in rows])


def test_every_lane_of_every_road_is_where_the_map_has_it(roads: dict[str, ET.Element]) -> None:
    checked = 0
    for name, road in roads.items():
        for side, direction in (("right", "forward"), ("left", "backward")):
            points = lane_points(road, side)
            if not points.size:
                continue
            keys = {"opendrive": str(town04()), "route": [name], "direction": direction}
            made = Road.model_validate(road_table(keys, "scenario.toml"))  # some are shorter than a car
            assert (made.lanes, made.lane_width_m) == (points.shape[1], 3.5)
            line = CentreLine(made)
            for lane in range(1, made.lanes + 1):
                along, right = line.local(points[:, lane - 1])
                assert np.abs(right - made.lane_offset_m(lane)).max() < 0.01, f"road {name}, lane {lane}"
                assert (np.diff(along) > 0.0).all()
                assert np.abs(along[[0, -1]] - [0.0, line.length_m]).max() < 0.01
            checked += 1
    assert checked > len(roads)  # many have lanes both ways


def test_road_45_against_s_is_the_road_of_the_catalog(tmp_path: Path) -> None:
    made = loaded(tmp_path, 'route = ["45"]\ndirection = "backward"').road
    catalog = scenarios.load("town04")
    assert isinstance(catalog, Scenario)
    assert (made.lanes, made.lane_width_m, made.look) == (catalog.road.lanes, catalog.road.lane_width_m, made.look)
    assert made.length_m == pytest.approx(catalog.road.length_m, abs=0.01)
    s = np.linspace(0.0, catalog.road.length_m, 600)
    apart = CentreLine(made).position(s) - CentreLine(catalog.road).position(s)
    assert np.hypot(*apart.T).max() < 0.01


def test_the_marks_of_road_45_are_read(tmp_path: Path) -> None:
    """White solid outside and yellow solid beside the other carriageway; white broken lines in between."""
    look = loaded(tmp_path, 'route = ["45"]\ndirection = "backward"').road.look
    assert (look.edge_lines, look.lines) == ("both", "white")


def test_a_route_goes_through_a_junction(roads: dict[str, ET.Element], tmp_path: Path) -> None:
    made = loaded(tmp_path, f"route = {[*ROUTE]}")
    line, right_lanes = CentreLine(made.road), [lane_points(roads[name], "right")[:, 0] for name in ROUTE]
    along, right = line.local(np.concatenate(right_lanes))
    assert np.abs(right - made.road.lane_offset_m(1)).max() < 0.01
    assert (np.diff(along) > -1e-3).all()
    assert made.road.lanes == 4


def test_the_fewest_roads_between_two_are_found(tmp_path: Path) -> None:
    made = loaded(tmp_path, f'from = "{ROUTE[0]}"\nto = "{ROUTE[-1]}"')
    assert made.road == loaded(tmp_path, f"route = {[*ROUTE]}").road


def test_the_examples_of_the_page_are_valid(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "opendrive.md").read_text("utf-8")
    examples = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    for example in examples:
        assert '"Town04.xodr"' in example
        (tmp_path / "example.toml").write_text(example.replace('"Town04.xodr"', f"'{town04()}'"), "utf-8")
        assert scenarios.load(str(tmp_path / "example.toml"))
    assert examples


def test_the_pid_drives_along_three_roads(roads: dict[str, ET.Element], tmp_path: Path) -> None:
    """From 40 m before the end of the first to 20 m beyond the second."""
    first, second = (float(roads[name].get("length", 0)) for name in ("41", "6"))
    keys = f'opendrive = \'{town04()}\'\nroute = ["41", "6", "45"]\ndirection = "forward"'
    path = write_scenario(tmp_path, keys, goal_m=first + second + 20.0, ego=f"lane = 2\ns_m = {first - 40.0}")
    episode = vpf_sim.drive(str(path), driver="pid")
    assert episode.status == "success"
    assert episode.steps["lane_offset_m"].abs().max() < 0.5
