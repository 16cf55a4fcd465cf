"""Maps whose lanes differ in width, or change it along the road, and whose geometries leave small gaps."""

from pathlib import Path

import numpy as np
import open_drive as xodr
import pytest

from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.road import Carriageway
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

START = (3.0, -2.0, 0.4)
LENGTH_M = 80.0
BEND = xodr.of_curvature(lambda s: np.full(s.shape, 0.005), LENGTH_M, START)
ARC = xodr.geometry('<arc curvature="0.005"/>', LENGTH_M, pose=START)
CLOSE_M = 0.03  # of a border: widths within 1 cm, steps and slopes spread


def assert_borders(made: Scenario, *left_m: Floats) -> None:
    """The lanes' borders from the left, as distances left of the reference line at each of its fine steps."""
    line, places = CentreLine(made.road), made.road.lane_places
    assert places is not None
    for number, t in enumerate(left_m):
        every = slice(100, -100, 200)
        along, right = line.local(BEND.shifted(lambda s, t=t: t + 0.0 * s)[every])
        assert np.abs(right - places.borders(along)[number]).max() < CLOSE_M


def test_lanes_have_their_own_width(tmp_path: Path) -> None:
    lanes = xodr.section(
        xodr.lane(-1, width='a="3.0"'), xodr.lane(-2, width='a="3.75"'), xodr.lane(-3, width='a="2.5"')
    )
    made = xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", ARC, lanes))
    zero = np.zeros(BEND.s.shape)
    assert_borders(made, zero, zero - 3.0, zero - 6.75, zero - 9.25)
    assert len(made.road.widths) == 2


@pytest.mark.parametrize("offset", [0.0, 1.2])
@pytest.mark.parametrize("coefficients", [(3.0, 0.02, 0.0, 0.0), (4.5, 0.0, -1.5e-3, 1.25e-5), (3.5, -0.06, 1e-3, 0.0)])
def test_a_width_changes_along_the_road(
    coefficients: tuple[float, float, float, float], offset: float, tmp_path: Path
) -> None:
    """The inner lane's width is a polynomial; both lanes and the offset move the outer one."""
    a, b, c, d = coefficients
    lanes = xodr.section(xodr.lane(-1, width=f'a="{a}" b="{b}" c="{c}" d="{d}"'), xodr.lane(-2, width='a="3.2"'))
    made = xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", ARC, f'<laneOffset s="0" a="{offset}"/>{lanes}'))
    inner = offset - (a + BEND.s * (b + BEND.s * (c + BEND.s * d)))
    assert_borders(made, np.full(BEND.s.shape, offset), inner, inner - 3.2)


ZIGZAG = '<laneOffset s="0" a="0" b="0.15"/><laneOffset s="20" a="3" b="-0.15"/><laneOffset s="50" a="-1.5"/>'


def zigzag(s: Floats) -> Floats:
    """The offset of ZIGZAG: its corners have 8 and 17 deg."""
    return np.interp(s, [0.0, 20.0, 50.0], [0.0, 3.0, -1.5])


@pytest.mark.parametrize(("keys", "side"), [("", -1.0), ('\ndirection = "backward"', 1.0)])
def test_lanes_whose_offset_has_corners_lie_beside_the_reference_line(keys: str, side: float, tmp_path: Path) -> None:
    """Both lanes have the same width everywhere, but no line along them is smooth."""
    lanes = xodr.section(xodr.lane(int(side)), xodr.lane(int(2 * side)))
    made = xodr.loaded(tmp_path, f'route = ["A"]{keys}', xodr.road("A", ARC, ZIGZAG + lanes))
    offset = zigzag(BEND.s)
    assert_borders(made, offset, offset + 3.5 * side, offset + 7.0 * side)


def test_the_line_goes_on_where_the_next_road_has_its_reference_line_elsewhere(tmp_path: Path) -> None:
    """The second road's reference line lies 2 m to the left; the lanes go on, in corners."""
    lanes, pose = xodr.section(xodr.lane(-1)), (60.0, 2.0, 0.0)
    first = xodr.road("A", xodr.geometry("<line/>", 60.0), ZIGZAG + lanes, xodr.linked("successor", "B"))
    second = xodr.road(
        "B",
        xodr.geometry("<line/>", 40.0, pose=pose),
        '<laneOffset s="0" a="-3.5" b="0.1"/>' + lanes,
        xodr.linked("predecessor", "A", "end"),
    )
    places = (made := xodr.loaded(tmp_path, 'route = ["A", "B"]', first, second)).road.lane_places
    assert places is not None
    along, right = CentreLine(made.road).local([[x, 0.0] for x in (30.0, 55.0, 70.0, 95.0)])
    assert np.abs(right).max() < 2.0
    left_m = np.array([1.5, -1.5, -0.5, 2.0])  # of the map's x axis
    assert right - places.borders(along)[0] == pytest.approx(left_m, abs=CLOSE_M)


def test_a_wide_place_far_from_a_tight_bend_is_no_fault(tmp_path: Path) -> None:
    """Lanes of 9 m on a straight, and of 3.5 m in a bend of 6 m."""
    bend = xodr.of_curvature(lambda s: np.full(s.shape, -1.0 / 6.0), 6.0, (60.0, 0.0, 0.0))
    geometries = xodr.geometry("<line/>", 60.0) + xodr.geometry(
        f'<arc curvature="{-1 / 6}"/>', 6.0, 60.0, (60.0, 0.0, 0.0)
    )
    lanes = xodr.section(xodr.lane(-1, width='a="9"')) + xodr.section(xodr.lane(-1), s=40.0)
    made = xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", geometries, lanes))
    along, right = CentreLine(made.road).local(bend.shifted(lambda s: -1.75 + 0.0 * s)[100:-100:2000])
    places = made.road.lane_places
    assert places is not None
    assert np.abs(right - places.middle(1, along)).max() < CLOSE_M


def test_against_s_the_order_of_lanes_is_that_of_the_drive(tmp_path: Path) -> None:
    lanes = xodr.section(xodr.lane(2, width='a="2.8"'), xodr.lane(1, width='a="3.0" b="0.01"'), xodr.lane(-1))
    made = xodr.loaded(tmp_path, 'route = ["A"]\ndirection = "backward"', xodr.road("A", ARC, lanes))
    zero = np.zeros(BEND.s.shape)
    assert_borders(made, zero, zero + 3.0 + 0.01 * BEND.s, zero + 5.8 + 0.01 * BEND.s)


def test_in_left_hand_traffic_the_inner_edge_is_the_right_one(tmp_path: Path) -> None:
    lanes = xodr.section(xodr.lane(2, width='a="2.8"'), xodr.lane(1, width='a="3.0" b="0.01"'))
    made = xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", ARC, lanes, more='rule="LHT"'))
    zero = np.zeros(BEND.s.shape)
    assert_borders(made, zero + 5.8 + 0.01 * BEND.s, zero + 3.0 + 0.01 * BEND.s, zero)


def test_a_step_of_the_width_is_spread(tmp_path: Path) -> None:
    """At 40 m a section with a wider lane begins; a metre before and after, the widths are the map's."""
    lanes = xodr.section(xodr.lane(-1, width='a="3.0"')) + xodr.section(xodr.lane(-1, width='a="3.4"'), s=40.0)
    network = Carriageway(xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", ARC, lanes)).road)
    (lane,) = network.lanes_list()
    assert [lane.width_at(s) for s in (5.0, 39.0, 41.0, 75.0)] == pytest.approx([3.0, 3.0, 3.4, 3.4], abs=0.02)


def test_a_turn_lane_that_opens_is_left_out(tmp_path: Path) -> None:
    """Its width is 0, and by rounding less, before it opens; the lane beside it keeps its own width."""
    opens = xodr.lane(-2, width='a="-0.001" b="0.05"')
    made = xodr.loaded(
        tmp_path, 'route = ["A"]', xodr.road("A", ARC, xodr.section(xodr.lane(-1, width='a="3.1"'), opens))
    )
    assert (made.road.lanes, made.road.lane_width_m, made.road.widths) == (1, 3.1, ())


@pytest.mark.parametrize(("aside_m", "kink_deg"), [(0.045, 0.0), (0.0, 1.0), (-0.03, 0.0)])
def test_small_gaps_and_kinks_are_bridged(aside_m: float, kink_deg: float, tmp_path: Path) -> None:
    second = xodr.geometry("<line/>", 60.0, 60.0, (60.0, aside_m, float(np.radians(kink_deg))))
    road = xodr.road("A", xodr.geometry("<line/>", 60.0) + second, xodr.section(xodr.lane(-1)))
    line = CentreLine(xodr.loaded(tmp_path, 'route = ["A"]', road).road)
    end = np.array([60.0, aside_m]) + 60.0 * np.array([np.cos(np.radians(kink_deg)), np.sin(np.radians(kink_deg))])
    along, right = line.local([[30.0, 0.0], (end * [1.0, -1.0]).tolist()])
    assert np.abs(right + 1.75).max() < 0.055
    assert along[1] == pytest.approx(120.0, abs=0.05)


@pytest.mark.parametrize("kink_deg", [-1.0, 1.0, 2.5])
def test_a_kink_is_bridged_for_lanes_far_from_the_reference_line(kink_deg: float, tmp_path: Path) -> None:
    """Its two straights leave a gap, or overlap, along the lanes: 5 m aside 0.09 m for 1 deg."""
    turn = float(np.radians(kink_deg))
    geometries = xodr.geometry("<line/>", 60.0) + xodr.geometry("<line/>", 60.0, 60.0, (60.0, 0.0, turn))
    lanes = f'<laneOffset s="0" a="-3.5"/>{xodr.section(xodr.lane(-1))}'
    line = CentreLine(xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", geometries, lanes)).road)
    end = 60.0 + 60.0 * np.exp(1j * turn)
    _, right = line.local([[30.0, 0.0], [end.real, -end.imag]])
    assert np.abs(right + 5.25).max() < 0.055


def test_of_a_gap_of_8_cm_the_line_is_within_5_cm_of_both_sides(tmp_path: Path) -> None:
    second = xodr.geometry("<line/>", 60.0, 60.0, (60.0, 0.08, 0.0))
    road = xodr.road("A", xodr.geometry("<line/>", 60.0) + second, xodr.section(xodr.lane(-1)))
    made = xodr.loaded(tmp_path, 'route = ["A"]', road)
    along, right = CentreLine(made.road).local([[x, 0.0] for x in (10.0, 59.9, 60.1, 110.0)])
    places = made.road.lane_places
    middle = right if places is None else right - places.middle(1, along)  # of the map's x axis
    assert middle == pytest.approx([-1.75, -1.75, -1.67, -1.67], abs=0.052)
    assert middle[[0, 3]] == pytest.approx([-1.75, -1.67], abs=0.01)


def test_short_geometries_that_jump_to_and_fro_become_one_bend(tmp_path: Path) -> None:
    """Ninety arcs of 0.5 m, each up to 4 cm beside a bend of 25 m: a line through all is too tight for the lanes."""
    jumps, text = np.random.default_rng(4).uniform(-0.04, 0.04, 90), ""
    for i, jump in enumerate(jumps):
        turn = 0.02 * i
        x, y = (25.0 - jump) * np.sin(turn), 25.0 - (25.0 - jump) * np.cos(turn)
        text += xodr.geometry('<arc curvature="0.04"/>', 0.5, 0.5 * i, (float(x), float(y), turn))
    made = xodr.loaded(tmp_path, 'route = ["A"]', xodr.road("A", text, xodr.section(xodr.lane(-1), xodr.lane(-2))))
    bend = xodr.of_curvature(lambda s: np.full(s.shape, 0.04), 45.0, (0.0, 0.0, 0.0))
    along, right = CentreLine(made.road).local(
        bend.shifted(lambda s: -1.75 + 0.0 * s)[100:-100:500]
    )  # of lane 2 from the right
    places = made.road.lane_places
    assert places is not None
    assert np.abs(right - places.middle(2, along)).max() < 0.05
    radii_m = [abs(radius) for one in made.road.segments if (radius := getattr(one, "end_radius_m", None))]
    assert min(radii_m) > 8.0
