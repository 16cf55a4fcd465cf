"""Faults of OpenDRIVE maps and of the keys that name them: one line with file, place, expected and actual."""

from pathlib import Path

import open_drive as xodr
import pytest

from vpf_sim import scenarios
from vpf_sim.errors import InputError

LANES = xodr.section(xodr.lane(-1), xodr.lane(-2))
ROAD = xodr.road("45", xodr.geometry("<line/>", 60.0), LANES)
NUMBER = "expected a number up to 1e+09"
BOMB = (
    "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]>"
    "<OpenDRIVE>&b;</OpenDRIVE>"
)


def message(folder: Path, keys: str = 'route = ["45"]', text: str | bytes | None = None) -> str:
    """What is said of a scenario; `text` replaces the map."""
    path = xodr.write_map(folder, ROAD)
    if text is not None:
        path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(InputError) as caught:
        scenarios.load(str(xodr.write_scenario(folder, keys)))
    return str(caught.value).replace(str(folder), "F").replace("\\", "/")


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (
            'opendrive = "none.xodr"\nroute = ["45"]',
            "road.opendrive: expected a readable OpenDRIVE file, got F/none.xodr: No such file or directory",
        ),
        ('route = ["54"]', "road.route[0]: unknown road of F/map.xodr '54': did you mean '45'?"),
        ('route = ["x"]', "road.route[0]: unknown road of F/map.xodr 'x': known: 45"),
        ('from = "45"\nto = "46"', "road.to: unknown road of F/map.xodr '46': did you mean '45'?"),
        ('from = "45"', "road.route: expected the ids of one or more roads, or from and to, got none"),
        ("route = []", "road.route: expected the ids of one or more roads, or from and to, got none"),
        ('route = ["45"]\nto = "45"', "road.route: expected either route or from and to, got both"),
        ("route = [45]", "road.route[0]: expected a string, got 45"),
        ('route = ["45"]\nlanes = 4', "road.lanes: unknown key, known: opendrive, route, from, to, direction, look"),
        (
            'route = ["45"]\nlook = {verge = "grss"}',
            "road.look.verge: expected one of grass, sand, snow, paved, got 'grss': did you mean 'grass'?",
        ),
        (
            'route = ["45"]\ndirection = "back"',
            "road.direction: expected one of forward, backward, got 'back': did you mean 'backward'?",
        ),
    ],
)
def test_a_fault_of_a_scenarios_keys_is_one_line(keys: str, line: str, tmp_path: Path) -> None:
    assert message(tmp_path, keys) == f"F/scenario.toml: {line}"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("road 45", "expected XML, got: syntax error: line 1, column 0"),
        (b"\x89PNG\r\n\x1a\n\0\0", "expected XML, got: not well-formed (invalid token): line 1, column 0"),
        ("<?xml version='1.0' encoding='nonsense'?><OpenDRIVE/>", "expected XML, got: unknown encoding: nonsense"),
        ("<osm/>", "expected the root element OpenDRIVE, got 'osm'"),
        (BOMB, "expected XML without entities of its own, got <!ENTITY"),
        (
            BOMB.replace("1.0'", "1.0' encoding='utf-16'").encode("utf-16"),
            "expected XML without entities of its own, got <!ENTITY",
        ),
    ],
)
def test_a_file_that_is_no_map_is_refused(text: str | bytes, line: str, tmp_path: Path) -> None:
    assert message(tmp_path, text=text) == f"F/map.xodr: {line}"


@pytest.mark.parametrize(
    ("road", "line"),
    [
        (ROAD.replace('hdg="0.0"', 'hdg="north"'), f"planView.geometry[0].hdg: {NUMBER}, got 'north'"),
        (ROAD.replace('hdg="0.0"', 'hdg="nan"'), f"planView.geometry[0].hdg: {NUMBER}, got 'nan'"),
        (ROAD.replace('hdg="0.0"', 'hdg="1e300"'), f"planView.geometry[0].hdg: {NUMBER}, got '1e300'"),
        (
            ROAD.replace('s="0.0" x', 's="1e9" x'),
            "planView: expected geometries with s that grows from 0 to 20000 m at most, got [1000000000.0]",
        ),
        (
            ROAD.replace("<line/>", '<spiral curvStart="0" curvEnd="5"/>'),
            "planView.geometry[0].spiral: expected a turn of up to 100 rad, got curvatures of 0 and 5 1/m",
        ),
        (
            ROAD.replace("<line/>", '<paramPoly3 aU="0" bU="6" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0"/>'),
            "planView.geometry[0].paramPoly3: expected a curve of its geometry's length 60 m, got 6 m",
        ),
        (ROAD.replace('hdg="0.0"', ""), f"planView.geometry[0].hdg: {NUMBER}, got none"),
        (
            ROAD.replace("<line/>", "<bezier/>"),
            "planView.geometry[0]: expected one of line, arc, spiral, poly3, paramPoly3, got 'bezier'",
        ),
        (
            ROAD.replace("<line/>", ""),
            "planView.geometry[0]: expected one of line, arc, spiral, poly3, paramPoly3, got none",
        ),
        (ROAD.replace("<line/>", "<arc/>"), f"planView.geometry[0].arc.curvature: {NUMBER}, got none"),
        (
            ROAD.replace('length="60.0"', 'length="0"'),
            "planView: expected one or more geometries with a length, got none",
        ),
        (ROAD.replace("driving", "sidewalk"), "lanes: expected a driving lane along the whole road, got none"),
        (ROAD.replace(LANES, ""), "lanes: expected sections with s that grows from 0 to the road's length 60, got []"),
        (ROAD.replace('id="-2"', 'id="two"'), "lanes.laneSection[0].lane.id: expected an integer, got 'two'"),
        (ROAD.replace("<width a", "<border a"), "lanes.laneSection[0].lane -1: expected widths, got borders"),
        (
            ROAD.replace("<line/>", '<arc curvature="-0.3"/>'),
            "planView: expected bends wider than the lanes' distance from the reference line, got a radius of 3.33 m",
        ),
        (
            ROAD.replace("<line/>", '<arc curvature="-0.15"/>'),
            "planView: expected bends wider than the road inside them, 3.5 m, got a radius of 3.17 m",
        ),
    ],
)
def test_a_fault_of_a_road_is_one_line(road: str, line: str, tmp_path: Path) -> None:
    text = f"<OpenDRIVE>{road}</OpenDRIVE>"
    assert message(tmp_path, text=text) == f"F/map.xodr: road 45: {line}"


def test_a_gap_between_geometries_is_refused(tmp_path: Path) -> None:
    """The second line begins 12 cm beside the end of the first: no line is within 5 cm of both."""
    geometries = xodr.geometry("<line/>", 60.0) + xodr.geometry("<line/>", 60.0, 60.0, (60.0, 0.12, 0.0))
    text = f"<OpenDRIVE>{xodr.road('45', geometries, LANES)}</OpenDRIVE>"
    assert message(tmp_path, text=text) == (
        "F/map.xodr: road 45: planView: expected a line that goes on within 0.05 m, got 0.120 m at x = 60.00, y = -3.38"
    )


def test_a_road_that_goes_on_far_away_is_refused(tmp_path: Path) -> None:
    """In a bend, which must not grow to reach it."""
    far = xodr.geometry("<line/>", 60.0, 60.0, (1e9, 0.0, 0.0))
    road = xodr.road("45", xodr.geometry("<line/>", 60.0) + far.replace("<line/>", '<arc curvature="0.01"/>'), LANES)
    said = message(tmp_path, text=f"<OpenDRIVE>{road}</OpenDRIVE>")
    assert said.startswith("F/map.xodr: road 45: planView: expected a line that goes on within 0.05 m, got ")


def test_a_corner_is_refused(tmp_path: Path) -> None:
    """Of 57 deg: a bend within 5 cm of both lines has a radius of 0.8 m."""
    geometries = xodr.geometry("<line/>", 60.0) + xodr.geometry("<line/>", 60.0, 60.0, (60.0, 0.0, 1.0))
    said = message(tmp_path, text=f"<OpenDRIVE>{xodr.road('45', geometries, LANES)}</OpenDRIVE>")
    assert said.startswith("F/map.xodr: road 45: planView: expected a line that goes on within 0.05 m, got ")


def test_a_map_with_a_namespace_is_read(tmp_path: Path) -> None:
    path = xodr.write_map(tmp_path, ROAD)
    path.write_text(
        path.read_text("utf-8").replace("<OpenDRIVE>", '<OpenDRIVE xmlns="http://example.org/odr">'), "utf-8"
    )
    assert scenarios.load(str(xodr.write_scenario(tmp_path, 'route = ["45"]')))


def test_a_changed_map_is_read_again(tmp_path: Path) -> None:
    xodr.write_map(tmp_path, ROAD)
    path = xodr.write_scenario(tmp_path, 'route = ["45"]')
    before = scenarios.load(str(path))
    xodr.write_map(tmp_path, ROAD.replace("60.0", "160.0"))
    assert scenarios.load(str(path)) != before
