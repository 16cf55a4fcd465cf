"""Roads from segments: closed forms, and position and local coordinates as inverses."""

import numpy as np
import pytest
from highway_env.road.lane import LineType
from scipy.integrate import quad
from scipy.special import fresnel

from vpf_sim import scenarios
from vpf_sim.envs.road import Carriageway, build_road, centre_line
from vpf_sim.scenarios.parts import Arc, Clothoid, Line, Road

BENDS = Road(
    heading_deg=200.0,
    start_m=(300.0, -40.0),
    segments=(
        Line(kind="line", length_m=30.0),
        Clothoid(kind="clothoid", length_m=40.0, end_radius_m=60.0),
        Arc(kind="arc", length_m=130.0, radius_m=60.0),
        Clothoid(kind="clothoid", length_m=80.0, end_radius_m=-45.0),
        Clothoid(kind="clothoid", length_m=35.0),
    ),
)
DRAWN = {name: scenarios.load(name).draw(0) for name in scenarios.names()}
OF_THE_CATALOG = {name: scenario for name, scenario in DRAWN.items() if isinstance(scenario, scenarios.Scenario)}
ROADS = [scenario.road for scenario in OF_THE_CATALOG.values()]


def places(road: Road) -> tuple[np.ndarray, np.ndarray]:
    """(s, lateral) along the road and beyond its ends, and at every joint."""
    rng = np.random.default_rng(5)
    joints = np.cumsum([0.0] + [segment.length_m for segment in road.segments])
    s = np.concatenate([rng.uniform(-40.0, road.length_m + 40.0, 500), joints, joints + 1e-9])
    return s, rng.uniform(-20.0, 20.0, len(s))


@pytest.mark.parametrize("road", [BENDS, *ROADS])
def test_position_and_local_are_inverse_to_each_other(road: Road) -> None:
    centre = centre_line(road)
    s, lateral = places(road)
    back_s, back_lateral = centre.local(centre.position(s, lateral))
    assert np.abs(back_s - s).max() < 1e-9
    assert np.abs(back_lateral - lateral).max() < 1e-9


@pytest.mark.parametrize("name", OF_THE_CATALOG)
def test_position_and_local_coordinates_of_lanes_are_inverse_to_each_other(name: str) -> None:
    scenario = OF_THE_CATALOG[name]
    s, lateral = places(scenario.road)
    for lane in build_road(scenario, np.random.default_rng(0)).network.lanes_list():
        back = np.array([lane.local_coordinates(lane.position(*place)) for place in zip(s, lateral, strict=True)])
        assert np.abs(back - np.stack([s, lateral], axis=1)).max() < 1e-9


@pytest.mark.parametrize("road", [BENDS, *ROADS])
def test_scalar_and_array_queries_agree(road: Road) -> None:
    centre = centre_line(road)
    s, lateral = places(road)
    points = [centre.position_at(*place) for place in zip(s, lateral, strict=True)]
    assert np.abs(centre.position(s, lateral) - points).max() < 1e-12
    assert np.abs(centre.heading(s) - [centre.heading_at(place) for place in s]).max() < 1e-12
    assert np.abs(centre.curvature(s) - [centre.curvature_at(place) for place in s]).max() < 1e-15


def test_a_clothoid_is_the_fresnel_integrals() -> None:
    length, radius = 50.0, 80.0
    road = Road(segments=(Clothoid(kind="clothoid", length_m=length, end_radius_m=radius),))
    s = np.linspace(0.0, length, 101)
    scale = np.sqrt(np.pi * radius * length)  # curvature s / (radius length): heading s^2 / (2 radius length)
    sine, cosine = fresnel(s / scale)
    assert np.abs(centre_line(road).position(s) - scale * np.stack([cosine, sine], axis=-1)).max() < 1e-12


def test_a_clothoid_between_opposite_bends_is_the_integral_of_its_heading() -> None:
    centre = centre_line(BENDS)
    start, end = 200.0, 280.0  # the fourth segment, from R 60 right to R 45 left
    turn, turn_rate = 1.0 / 60.0, (-1.0 / 45.0 - 1.0 / 60.0) / 80.0
    heading = centre.heading_at(start)

    def at(u: float) -> float:
        return heading + turn * u + turn_rate * u**2 / 2.0

    along = quad(lambda u: np.cos(at(u)), 0.0, end - start, epsabs=1e-13)[0]
    across = quad(lambda u: np.sin(at(u)), 0.0, end - start, epsabs=1e-13)[0]
    assert np.abs(centre.position(end) - centre.position(start) - [along, across]).max() < 1e-11


def test_arc_keeps_its_radius_and_turns_right_if_positive() -> None:
    road = Road(segments=(Arc(kind="arc", length_m=500.0, radius_m=100.0),))
    centre = centre_line(road)
    points = centre.position(np.linspace(0.0, 500.0, 200), 5.0)
    assert np.abs(np.hypot(points[:, 0], points[:, 1] - 100.0) - 95.0).max() < 1e-11
    assert centre.heading_at(50.0) == pytest.approx(0.5)
    s, lateral = centre.local(points)  # beyond half a turn, where an angle wraps
    assert np.abs(s - np.linspace(0.0, 500.0, 200)).max() < 1e-9
    assert np.abs(lateral - 5.0).max() < 1e-9


@pytest.mark.parametrize("road", [BENDS, *ROADS])
def test_line_is_parametrised_by_arc_length_without_jumps(road: Road) -> None:
    centre = centre_line(road)
    s = np.linspace(-10.0, road.length_m + 10.0, 40_001)
    step = s[1] - s[0]
    chords = np.hypot(*np.diff(centre.position(s), axis=0).T)
    assert np.abs(chords - step).max() < 1e-6
    assert np.abs(np.diff(centre.heading(s))).max() < step / 40.0


def test_local_coordinates_do_not_depend_on_earlier_queries() -> None:
    centre = centre_line(BENDS)
    x, y = centre.position_at(150.0, 3.0)
    before = centre.local_at(x, y)
    for s in np.linspace(-30.0, 350.0, 50):
        centre.local_at(*centre.position_at(s, 6.0))
    assert centre.local_at(x, y) == before


def test_lanes_are_counted_from_the_left_with_solid_lines_at_the_edges() -> None:
    scenario = scenarios.load("straight")
    lanes = build_road(scenario, np.random.default_rng(0)).network.lanes_list()
    assert [lane.position(10.0, 0.0).tolist() for lane in lanes] == [[10.0, y] for y in (-5.25, -1.75, 1.75, 5.25)]
    solid, dashed = LineType.CONTINUOUS_LINE, LineType.STRIPED
    assert [lane.line_types for lane in lanes] == [[solid, dashed], [dashed] * 2, [dashed] * 2, [dashed, solid]]
    assert all(lane.width_at(10.0) == 3.5 and lane.length == 240.0 for lane in lanes)


def test_the_lane_of_a_position_is_the_one_it_lies_on() -> None:
    network = Carriageway(BENDS)
    for index, lane in enumerate(network.lanes_list()):
        for lateral in (-1.7, 0.0, 1.7):
            assert network.get_closest_lane_index(lane.position(200.0, lateral))[2] == index
    assert network.get_closest_lane_index(np.array(network.centre.position_at(100.0, -30.0)))[2] == 0
    assert network.get_closest_lane_index(np.array(network.centre.position_at(100.0, 30.0)))[2] == 3


def test_scalar_and_array_queries_of_lanes_agree() -> None:
    lane = Carriageway(BENDS).lanes_list()[3]
    s = np.linspace(-5.0, 320.0, 30)
    assert np.abs(lane.positions(s, 0.5) - [lane.position(place, 0.5) for place in s]).max() < 1e-12
    assert np.abs(lane.headings(s) - [lane.heading_at(place) for place in s]).max() < 1e-12
