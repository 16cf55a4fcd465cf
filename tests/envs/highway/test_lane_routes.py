"""Routes through highway-env's lane networks, compared with the lanes and egos of highway-env itself."""

import numpy as np
import pytest
from highway_worlds import ROADS, original, scenario, world

from vpf_sim import scenarios
from vpf_sim.envs.highway.path import turn_at
from vpf_sim.envs.route import BEYOND_GOAL_M
from vpf_sim.envs.world import build_world
from vpf_sim.geometry import unwrapped

SHARPEST_PER_M = 1.0 / 9.0  # curvature of highway-env's tightest lane, a right turn at the intersection
RINGING = 1.25  # where a straight meets an arc, the spline bends more than the arc


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("name", ROADS)
def test_the_route_is_continuous_and_as_smooth_as_a_lane(name: str, seed: int) -> None:
    route = world(name, seed).route
    points = route.waypoints()
    steps = np.diff(points, axis=0)
    assert np.hypot(*steps.T) == pytest.approx(1.0, abs=0.01), "1 m apart"
    turns = np.diff(unwrapped(np.arctan2(*steps.T[::-1])))
    assert np.abs(turns).max() < RINGING * SHARPEST_PER_M
    assert len(points) == pytest.approx(route.length_m + BEYOND_GOAL_M, abs=1.0)


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("name", ROADS)
def test_the_route_lies_within_lanes_and_mostly_on_their_centres(name: str, seed: int) -> None:
    lanes = original(name, seed).road.network.lanes_list()
    here = world(name, seed)
    points = here.route.centre.position(np.arange(0.0, here.route.length_m, 1.0))
    outside = [point for point in points if not any(lane.on_lane(point) for lane in lanes)]
    assert len(outside) <= (12 if name == "roundabout-v0" else 0), "its entries and exits end 5 m short of the ring"
    assert all(any(lane.on_lane(point, margin=1.2) for lane in lanes) for point in outside)
    if name != "exit-v0":  # it changes lanes over most of its length
        aside_m = [[abs(lane.local_coordinates(point)[1]) for lane in lanes if lane.on_lane(point)] for point in points]
        assert np.median([min(found, default=np.inf) for found in aside_m]) < 0.01


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize("name", ROADS)
def test_the_ego_starts_where_highway_envs_does(name: str, seed: int) -> None:
    theirs, ours = original(name, seed).vehicle, world(name, seed).ego
    assert ours.position == pytest.approx(theirs.position)
    assert (ours.heading, ours.speed) == pytest.approx((theirs.heading, theirs.speed))
    assert ours.place[0] == pytest.approx(0.0, abs=0.01), "at the route's start"


def test_the_route_leads_to_highway_envs_destination() -> None:
    """The exit ramp, the roundabout's north exit, and the other side of the U-turn."""
    for name, node in (("exit-v0", "exit"), ("roundabout-v0", "nxr"), ("u-turn-v0", "d")):
        here = world(name)
        network = original(name, 0).road.network
        heading = here.route.centre.heading_at(here.route.length_m)
        assert network.get_closest_lane_index(np.array(here.route.goal_m), heading)[1] == node


@pytest.mark.parametrize(("destination", "turn"), [("o1", "left"), ("o2", "straight"), ("o3", "right")])
def test_the_route_names_the_turn_at_the_intersection(destination: str, turn: str) -> None:
    route = world("intersection-v1", destination=destination).route
    named = [route.turn(float(s)) for s in np.arange(0.0, route.length_m)]
    assert set(named) == {"lane", turn}
    heading = route.centre.heading_at(route.length_m) - route.centre.heading_at(0.0)
    turned = (heading + np.pi) % (2.0 * np.pi) - np.pi
    assert turned == pytest.approx({"left": -np.pi / 2.0, "straight": 0.0, "right": np.pi / 2.0}[turn], abs=0.02)
    assert named[-1] == "lane", "past the junction"


def test_turns_are_named_by_their_direction_and_only_where_roads_part() -> None:
    roundabout, exit_road = original("roundabout-v0", 0).road.network, original("exit-v0", 0).road.network
    assert turn_at(roundabout, ("se", "ex", 1), ("ex", "ee", 1)) == "straight", "on around it"
    assert turn_at(roundabout, ("se", "ex", 1), ("ex", "exs", 0)) == "right", "off it"
    assert turn_at(roundabout, ("ses", "se", 0), ("se", "ex", 1)) == "lane", "the only way"
    assert turn_at(exit_road, ("1", "2", 6), ("2", "exit", 0)) == "right"
    assert turn_at(exit_road, ("1", "2", 5), ("2", "3", 5)) == "straight"


def test_a_lap_of_the_racetrack_comes_back_to_its_start() -> None:
    here = build_world(scenario("racetrack-v0"), 0)
    away_m = np.hypot(*(here.route.centre.position(np.arange(200.0, 380.0)) - here.route.waypoints()[0]).T)
    assert away_m.min() < 1.0


def test_a_destination_that_is_drawn_follows_from_the_seed() -> None:
    goals = [world("intersection-v1", seed, destination="random").route.goal_m for seed in (0, 1, 2, 3, 0)]
    assert goals[0] == goals[-1]
    arms = {(round(x / 40.0), round(y / 40.0)) for x, y in goals}
    assert len(arms) > 1, "several arms of the junction"


def test_a_goal_in_a_junction_is_a_line_across_the_lane() -> None:
    text = 'schema = 1\n[highway_env]\nid = "intersection-v1"\n[goal]\nroute_m = 45.0\n'
    route = build_world(scenarios.parse(text, "mine.toml").draw(0), 0).route
    assert route.is_at_goal((45.0, 1.9))
    assert not route.is_at_goal((45.0, 2.1))
