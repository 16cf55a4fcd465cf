"""Lanes of their own width that changes along the road: places, edges, endings, the route, traffic and the camera."""

import numpy as np
import pytest
from straight_road import NEUTRAL, constantly, drive
from transforms import mirrored

from vpf_sim import scenarios
from vpf_sim.envs.camera.layout import lane_shapes, outer_edges
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.world import World, build_world
from vpf_sim.errors import InputError

pytest_plugins = ["straight_road"]
# Two lanes: from 40 to 100 m the right one narrows from 4 to 2.5 m, the left one widens from 3 to 5 m.
ROAD = """
schema = 1
[road]
lanes = 2
segments = [{kind = "line", length_m = 50}, {kind = "arc", length_m = 150, radius_m = 300}]
[[road.widths]]
s_m = 40.0
lanes_m = [4.0, 3.0]
[[road.widths]]
s_m = 100.0
lanes_m = [2.5, 5.0]
"""
REST = """
[ego]
lane = 1
[goal]
s_m = 150.0
[limits]
time_s = 60.0
"""
S = np.array([0.0, 40.0, 55.0, 70.0, 100.0, 130.0])
RIGHT = np.array([4.0, 4.0, 3.625, 3.25, 2.5, 2.5])  # widths at S
LEFT = np.array([3.0, 3.0, 3.5, 4.0, 5.0, 5.0])
EDGE = 0.5 * (RIGHT + LEFT)


def scenario(text: str = ROAD + REST) -> scenarios.Scenario:
    return scenarios.parse(text, "test.toml")


def world(text: str = ROAD + REST) -> World:
    return build_world(scenario(text), 0)


def test_lanes_have_their_own_width_along_the_road() -> None:
    left, right = world().road.network.lanes_list()
    for lane, widths, middles in ((left, LEFT, -EDGE + LEFT / 2), (right, RIGHT, EDGE - RIGHT / 2)):
        assert np.allclose([lane.width_at(s) for s in S], widths)
        centre = world().road.network.centre
        assert np.allclose([lane.position(s, 0.3) for s in S], centre.position(S, middles + 0.3))
        assert np.allclose([lane.local_coordinates(lane.position(s, -0.7)) for s in S], np.stack([S, 0 * S - 0.7], 1))
        assert np.allclose(lane.positions(S, 0.3), centre.position(S, middles + 0.3))


def test_edges_and_lanes_are_those_of_the_place() -> None:
    network = world().road.network
    for s, edge, right in zip(S.tolist(), EDGE.tolist(), RIGHT.tolist(), strict=True):
        x, y = network.centre.position_at(s, 0.4)
        assert np.allclose(network.edges_at(x, y, 0.0), (-edge - 0.4, edge - 0.4))
        assert network.lane_at((s, edge - right + 0.01))[2] == 1
        assert network.lane_at((s, edge - right - 0.01))[2] == 0


def test_the_left_edge_may_be_given() -> None:
    text = ROAD.replace("lanes_m = [4.0, 3.0]", "lanes_m = [4.0, 3.0]\nleft_edge_m = -2.0")
    network = world(text + REST).road.network
    assert np.allclose(network.edges_at(*network.centre.position_at(10.0, 0.0), 0.0), (-2.0, 5.0))


def test_the_route_is_the_lanes_middle_and_as_long() -> None:
    """On a straight line the length is that of two legs of a triangle and a hypotenuse."""
    straight = ROAD.replace('{kind = "arc", length_m = 150, radius_m = 300}', '{kind = "line", length_m = 150}')
    route = world(straight + REST).route
    shift = (3.75 - 1.25) - (3.5 - 2.0)  # of the right lane's middle
    assert route.length_m == pytest.approx(35.0 + np.hypot(60.0, shift) + 50.0, abs=1e-3)
    assert route.progress(5.0) == pytest.approx(0.0)
    assert np.allclose(route.goal_m, (150.0, 2.5))
    assert np.allclose(np.linalg.norm(np.diff(route.waypoints(), axis=0), axis=1), 1.0, atol=1e-3)


def ending(lateral_m: float) -> tuple[str, float]:
    """How a drive straight ahead ends, and where."""
    straight = ROAD.replace('{kind = "arc", length_m = 150, radius_m = 300}', '{kind = "line", length_m = 150}')
    narrow = straight.replace("lanes_m = [2.5, 5.0]", "lanes_m = [2.5, 2.5]")
    env = FourLane(scenario(narrow + REST.replace("lane = 1", f"lane = 1\nlateral_m = {lateral_m}\nspeed_mps = 10.0")))
    steps = drive(env, constantly(NEUTRAL))
    return steps[-1][4]["status"], float(env.unwrapped.ego.position[0])


@pytest.mark.usefixtures("blind")
def test_a_car_leaves_the_road_where_it_narrows() -> None:
    """Its right side is 2.5 m right of the centre, where the edge comes in from 3.5 to 2.5 m between 40 and 100 m."""
    status, x_m = ending(lateral_m=2.7 - 1.5 - 0.5 * 1.8)
    assert status == "off_road"
    half_length_m = 2.3
    assert x_m + half_length_m == pytest.approx(40.0 + 60.0 * (3.5 - (2.7 - 0.2)), abs=half_length_m + 1.0)


def test_traffic_follows_its_lane() -> None:
    body = '[[bodies]]\nkind = "car"\ns_m = 30.0\nlane = 1\nlateral_m = 0.2\nspeed_mps = 15.0\n'
    made = world(ROAD + REST + body)
    (actor,) = [one for one in made.road.vehicles if one is not made.ego]
    places = scenario().road.lane_places
    assert places is not None
    for step in range(300):
        made.advance(step, 60.0)
        assert actor.place[1] == pytest.approx(float(places.middle(1, actor.place[0])) + 0.2, abs=1e-9)
    assert actor.place[0] > 100.0


def test_the_camera_draws_lanes_as_wide_as_they_are() -> None:
    made = world()
    centre = made.road.network.centre
    for shape, outer in zip(lane_shapes(made.road), (-1.0, 1.0), strict=True):
        points = shape.left_m if outer < 0.0 else shape.right_m
        on = (shape.s_m >= 0.0) & (shape.s_m <= 200.0)
        s, lateral = centre.local(points[on])
        assert np.abs(lateral - outer * np.interp(s, S, EDGE)).max() < 1e-6
        assert {40.0, 100.0} <= set(shape.s_m.tolist())
    assert len(outer_edges(lane_shapes(made.road))) == 2


def test_a_mirrored_road_has_the_lanes_on_the_other_side() -> None:
    before = scenario()
    after = mirrored(before)
    for s in S.tolist():
        assert after.road.lane_offset_m(2, s) == pytest.approx(-before.road.lane_offset_m(1, s))
    assert mirrored(after).road.widths == before.road.widths


def test_an_object_beyond_a_narrow_place_is_refused() -> None:
    """The left lane's middle is 2 m from the centre where the road is 7 m wide: half a truck is beyond its edge."""
    body = '[[bodies]]\nkind = "truck"\ns_m = 20.0\nlane = 1\nlateral_m = 1.2\n'
    with pytest.raises(InputError, match=r"lateral_m: obstacle off the road: .* between -3.5 and 3.5 m"):
        scenario(ROAD + REST + body)
