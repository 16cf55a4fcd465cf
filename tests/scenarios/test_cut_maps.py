"""Maps whose faults lie off the route, or are too small to notice: the route is found all the same."""

from pathlib import Path

import numpy as np
import open_drive as xodr
import pytest

from vpf_sim import scenarios
from vpf_sim.errors import InputError

LINE = "<line/>"
ONE = xodr.section(xodr.lane(-1))
ROUTES = ('route = ["A", "on", "C"]', 'from = "A"\nto = "C"')


def straight(name: str, x: float, links: str = "", lanes: str = ONE, heading: float = 0.0) -> str:
    """A road of 50 m from a place on the x axis."""
    return xodr.road(name, xodr.geometry(LINE, 50.0, pose=(x, 0.0, heading)), lanes, links)


def connection(name: str, links: str = '<laneLink from="-1" to="-1"/>') -> str:
    return f'<connection incomingRoad="A" connectingRoad="{name}" contactPoint="start">{links}</connection>'


def junction(*connections: str, more: str = "") -> str:
    return f'<junction id="J" {more}>{"".join(connections)}</junction>'


MAIN = (
    straight("A", 0.0, xodr.linked("successor", "J", kind="junction")),
    straight("on", 50.0, xodr.linked("predecessor", "A", "end") + xodr.linked("successor", "C")),
    straight("C", 100.0, xodr.linked("predecessor", "J", kind="junction")),
)
BOTH = junction(connection("on"), connection("side"))
OFF_ROUTE = {
    "a road that is not there": straight("side", 50.0, xodr.linked("successor", "99")),
    "minus one": straight("side", 50.0, xodr.linked("successor", "-1")),
    "an empty link": straight("side", 50.0, "<successor/>"),
    "no road": "",
    "a junction that is not there": straight("side", 50.0, xodr.linked("successor", "K", kind="junction")),
    "no kind of link": straight("side", 50.0, '<successor elementId="99"/>'),
    "no sections": straight("side", 50.0, lanes=""),
    "no number": straight("side", 50.0).replace('length="50.0"', 'length="long"'),
    "no lane's id": straight("side", 50.0).replace('id="-1"', 'id="right"'),
}


@pytest.mark.parametrize("keys", ROUTES)
@pytest.mark.parametrize("side", OFF_ROUTE.values(), ids=OFF_ROUTE)
def test_faults_of_a_side_road_do_not_matter(side: str, keys: str, tmp_path: Path) -> None:
    made = xodr.loaded(tmp_path, keys, *MAIN, side, BOTH)
    assert (made.road.lanes, made.road.length_m) == (1, 150.0)


@pytest.mark.parametrize("keys", ROUTES)
def test_lane_links_to_a_side_road_do_not_matter(keys: str, tmp_path: Path) -> None:
    links = connection("side", '<laneLink from="one" to="two"/>')
    made = xodr.loaded(tmp_path, keys, *MAIN, OFF_ROUTE["minus one"], junction(connection("on"), links))
    assert made.road.length_m == 150.0


def test_a_fault_on_the_only_way_is_named(tmp_path: Path) -> None:
    faulty = MAIN[1].replace('length="50.0"', 'length="long"')
    with pytest.raises(InputError, match=r"got 'C'; left out: .*road on: planView.geometry\[0\].length: .*'long'"):
        xodr.loaded(tmp_path, ROUTES[1], MAIN[0], faulty, MAIN[2], junction(connection("on")))


def test_a_junction_without_connections_ends_the_route(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="leads to, one of none, got 'on'"):
        xodr.loaded(tmp_path, ROUTES[0], *MAIN, junction())


def test_faults_of_lanes_that_are_not_driven_do_not_matter(tmp_path: Path) -> None:
    """On the other side, and beyond the outermost lane that is driven."""
    other = xodr.lane(1, width='a="wide"', inside='<link><successor id="none"/></link>')
    beyond = xodr.lane(-2, "sidewalk").replace("<width", "<border")
    road = straight("A", 0.0, lanes=xodr.section(other, xodr.lane(-1), beyond))
    made = xodr.loaded(tmp_path, 'route = ["A"]\ndirection = "forward"', road)
    assert (made.road.lanes, made.road.length_m) == (1, 50.0)


@pytest.mark.parametrize("link", ["<successor/>", '<successor id=""/>', '<successor id="-7"/>'])
def test_a_lanes_empty_link_is_none(link: str, tmp_path: Path) -> None:
    lanes = xodr.section(xodr.lane(-1, inside=f"<link>{link}</link>"))
    roads = straight("A", 0.0, xodr.linked("successor", "B"), lanes), straight("B", 50.0)
    assert xodr.loaded(tmp_path, 'route = ["A", "B"]', *roads).road.length_m == 100.0


@pytest.mark.parametrize("link", ['<successor elementId="B"/>', '<successor elementType="road" elementId="B"/>'])
def test_a_link_without_contact_point_touches_the_end_that_leads_back(link: str, tmp_path: Path) -> None:
    """B is drawn towards A, so its end touches that of A."""
    b = straight("B", 100.0, xodr.linked("successor", "A", "end"), xodr.section(xodr.lane(1)), np.pi)
    assert xodr.loaded(tmp_path, 'route = ["A", "B"]', straight("A", 0.0, link), b).road.length_m == 100.0


def direct(pairs: str, incoming: str = "A", to: str = "B", contact: str = 'contactPoint="start"') -> str:
    """A direct junction (OpenDRIVE 1.7): its two roads touch."""
    return junction(f'<connection incomingRoad="{incoming}" linkedRoad="{to}" {contact}>{pairs}</connection>')


THREE, TWO = (xodr.section(*(xodr.lane(-i) for i in range(1, n + 1))) for n in (3, 2))
TO_TWO = '<laneLink from="-1" to="-1"/><laneLink from="-2" to="-2"/>'
AT_END, AT_START = (xodr.linked(end, "J", kind="junction") for end in ("successor", "predecessor"))


@pytest.mark.parametrize("keys", ['route = ["A", "B"]', 'from = "A"\nto = "B"'])
@pytest.mark.parametrize("contact", ['contactPoint="start"', ""])
def test_a_direct_junction_leads_on(contact: str, keys: str, tmp_path: Path) -> None:
    """An exit: two of three lanes go on."""
    roads = straight("A", 0.0, AT_END, THREE), straight("B", 50.0, AT_START, TWO)
    made = xodr.loaded(tmp_path, keys, *roads, direct(TO_TWO, contact=contact))
    assert (made.road.lanes, made.road.length_m) == (2, 100.0)


def test_a_direct_junction_can_be_driven_from_the_linked_road(tmp_path: Path) -> None:
    """A merge is an exit the other way round: the road with more lanes is named as the incoming one."""
    roads = straight("A", 0.0, AT_END, TWO), straight("B", 50.0, AT_START, THREE)
    made = xodr.loaded(tmp_path, 'route = ["A", "B"]', *roads, direct(TO_TWO, "B", "A", 'contactPoint="end"'))
    assert (made.road.lanes, made.road.length_m) == (2, 100.0)


@pytest.mark.parametrize("word", ["true", "TRUE", "1"])
@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_sections_of_one_side_are_not_those_of_the_other(direction: str, word: str, tmp_path: Path) -> None:
    """The left side begins anew at 20 m, with a second lane that is left out; the right side goes on."""
    begin = xodr.section(xodr.lane(1), xodr.lane(-1))
    on = xodr.lane(1, inside='<link><predecessor id="1"/></link>')
    again = xodr.section(xodr.lane(2), on, s=20.0).replace(" s=", f' singleSide="{word}" s=')
    made = xodr.loaded(tmp_path, f'route = ["A"]\ndirection = "{direction}"', straight("A", 0.0, lanes=begin + again))
    assert (made.road.lanes, made.road.length_m) == (1, 50.0)


@pytest.mark.parametrize("s", [2e-6, 0.004])
def test_a_first_section_that_is_too_short_to_notice_is_merged(s: float, tmp_path: Path) -> None:
    """It has another offset and width; the lanes go on by its links."""
    linked = xodr.lane(-2, width='a="1.5"', inside='<link><successor id="-1"/></link>')
    lanes = f'<laneOffset s="0" a="9"/><laneOffset s="{s}" a="0"/>{xodr.section(xodr.lane(-1), linked)}'
    made = xodr.loaded(tmp_path, 'route = ["A"]', straight("A", 0.0, lanes=lanes + xodr.section(xodr.lane(-1), s=s)))
    assert (made.road.lanes, made.road.lane_width_m, made.road.start_m) == (1, 3.5, (0.0, 1.75))


@pytest.mark.parametrize("s", [50.0, 50.000001, 49.999])
def test_a_last_section_without_a_length_is_merged(s: float, tmp_path: Path) -> None:
    lanes = ONE + xodr.section(xodr.lane(-1, width='a="1.5"'), s=s)
    made = xodr.loaded(tmp_path, 'route = ["A"]', straight("A", 0.0, lanes=lanes))
    assert (made.road.lane_width_m, made.road.length_m) == (3.5, 50.0)


BEGINNINGS = {
    "a comment": b"<!-- made by hand -->\n",
    "a mark and a comment": b"\xef\xbb\xbf<!-- a -->",
    "empty lines": b"\n\n",
    "an instruction": b'<?xml-stylesheet href="a.xsl"?><!-- a --> <!-- b -->',
}


@pytest.mark.parametrize("before", BEGINNINGS.values(), ids=BEGINNINGS)
def test_what_comes_before_the_xml_declaration_is_passed_over(before: bytes, tmp_path: Path) -> None:
    path = xodr.write_map(tmp_path, straight("A", 0.0))
    path.write_bytes(before + path.read_bytes())
    assert scenarios.load(str(xodr.write_scenario(tmp_path, 'route = ["A"]')))


def test_a_comment_before_the_declaration_of_utf_16_is_passed_over(tmp_path: Path) -> None:
    path = xodr.write_map(tmp_path, straight("A", 0.0))
    text = path.read_text("utf-8").replace("'1.0'", "'1.0' encoding='utf-16'")
    path.write_bytes(f"<!-- a -->{text}".encode("utf-16"))
    assert scenarios.load(str(xodr.write_scenario(tmp_path, 'route = ["A"]')))


def test_a_document_type_without_entities_is_read(tmp_path: Path) -> None:
    path = xodr.write_map(tmp_path, straight("A", 0.0))
    path.write_text(path.read_text("utf-8").replace("?>", '?><!DOCTYPE OpenDRIVE SYSTEM "a.dtd">'), "utf-8")
    assert scenarios.load(str(xodr.write_scenario(tmp_path, 'route = ["A"]')))
