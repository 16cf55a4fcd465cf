"""What is true of a place on highway-env's lanes: edges, lanes, off road, and the goal's cross-section."""

from math import isnan
from types import SimpleNamespace

import numpy as np
import pytest
from highway_worlds import world

from vpf_sim.envs.contacts import corners


@pytest.mark.parametrize(("lanes", "lane"), [(2, 0), (3, 1), (5, 4)])
def test_edges_of_a_straight_road_are_those_of_its_lanes(lanes: int, lane: int) -> None:
    """highway-env's lanes are 4 m wide; lane 0 is the leftmost."""
    here = world("highway-v0", lanes_count=lanes, initial_lane_id=lane, vehicles_count=0)
    x, y = here.ego.position.tolist()
    left, right = here.road.network.edges_at(x, y + 0.5, 0.0)
    assert (left, right) == pytest.approx((-4.0 * (lane + 0.5) - 0.5, 4.0 * (lanes - lane - 0.5) - 0.5))


def test_lanes_in_the_other_direction_belong_to_the_carriageway() -> None:
    network = world("intersection-v1").road.network
    assert network.edges_at(2.0, 60.0, -np.pi / 2.0) == pytest.approx((-6.0, 2.0)), "on the arm, in its right lane"


def test_a_junction_has_no_edges() -> None:
    network = world("intersection-v1").road.network
    assert all(map(isnan, network.edges_at(2.0, 2.0, -np.pi / 2.0)))


def test_a_car_is_off_the_road_where_its_centre_is_on_no_lane() -> None:
    here = world("merge-v0")
    network, (x, y) = here.road.network, here.ego.position.tolist()
    for right_m, off in ((1.9, False), (2.1, True), (-5.9, False), (-6.1, True)):  # its lane is the right one of two
        place = network.place_at(x, y + right_m)
        assert network.is_off_road(SimpleNamespace(position=np.array([x, y + right_m]), place=place)) is off


def test_corners_beyond_the_lanes_are_outside_and_between_two_lanes_in_none() -> None:
    here = world("merge-v0")
    for right_m, expected in ((0.0, (False, True)), (-2.0, (False, False)), (1.5, (True, False))):
        here.ego.position[1] += right_m
        assert here.road.network.lane_use(corners(here.ego), 0.0) == expected
        here.ego.position[1] -= right_m


def test_the_goal_is_its_own_roads_cross_section() -> None:
    """Beside the exit ramp the main road goes on: who stays on it has not arrived."""
    route = world("exit-v0").route
    assert route.is_at_goal((route.length_m + 1.0, 0.0))
    assert route.is_at_goal((route.length_m + 1.0, 1.9))
    assert not route.is_at_goal((route.length_m + 1.0, -15.0))
    assert not route.is_at_goal((route.length_m - 1.0, 0.0))


def test_where_two_roads_do_not_meet_the_route_between_them_is_road() -> None:
    """The roundabout's entry ends short of its ring."""
    here = world("roundabout-v0")
    for s in np.arange(0.0, here.route.length_m, 0.5):
        ego = SimpleNamespace(position=np.array(here.route.centre.position_at(float(s), 0.0)), place=(float(s), 0.0))
        assert not here.road.network.is_off_road(ego)
