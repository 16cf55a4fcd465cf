"""The faster road has the states of highway-env's own road, to the last bit."""

from collections.abc import Iterator
from itertools import islice
from math import sin
from typing import Any

import numpy as np
import pytest
from highway_env.road.lane import StraightLane
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.behavior import IDMVehicle
from highway_worlds import ROADS, original, world

from vpf_sim.envs.highway.indexed_road import speed_up
from vpf_sim.envs.highway.lane_table import LaneTable

RATE_HZ = 60.0
State = list[tuple[Any, ...]]


def states(name: str, seed: int, is_original: bool, **config: Any) -> Iterator[State]:
    """All that moves, tick by tick, on our road or on highway-env's own."""
    here = world(name, seed, **config)
    if is_original:
        here.road.__class__ = type(original(name, seed).road)
    for tick in range(10**6):
        here.ego.act({"acceleration": 1.0 + sin(tick / 40.0), "steering": 0.02 * sin(tick / 25.0)})
        here.advance(tick, RATE_HZ)
        yield [state(vehicle) for vehicle in here.road.vehicles]


def state(vehicle: Any) -> tuple[Any, ...]:
    names = ("heading", "speed", "crashed", "lane_index", "target_lane_index", "target_speed", "timer", "action")
    return vehicle.position.tobytes(), *(getattr(vehicle, name, None) for name in names)


def assert_equal(name: str, seed: int, seconds: float, **config: Any) -> list[State]:
    """That both roads have the same states; returns them."""
    seen = []
    both = zip(states(name, seed, False, **config), states(name, seed, True, **config), strict=True)
    for tick, (found, expected) in enumerate(islice(both, round(seconds * RATE_HZ))):
        assert found == expected, f"{name}, seed {seed}, tick {tick}"
        seen.append(found)
    return seen


@pytest.mark.parametrize("name", ROADS)
def test_all_states_are_highway_envs(name: str) -> None:
    assert_equal(name, 0, 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ROADS)
def test_all_states_are_highway_envs_over_many_seeds(name: str) -> None:
    for seed in range(20):
        assert_equal(name, seed, 20.0)


def test_lane_changes_and_contacts_are_highway_envs() -> None:
    seen = [car for tick in assert_equal("highway-v0", 4, 6.0) for car in tick]
    assert any(lane != target for *_, lane, target, _, _, _ in seen if target), "some car changes lane"
    assert any(crashed for _, _, _, crashed, *_ in seen), "the ego hits a car"


@pytest.mark.parametrize(
    "config",
    [
        {"neighbour_vehicles_connected_lanes": True},
        {"other_vehicles_type": "highway_env.vehicle.behavior.AggressiveVehicle"},
    ],
)
def test_options_of_the_traffic_keep_its_states(config: dict[str, Any]) -> None:
    assert_equal("intersection-v1", 2, 2.0, **config)
    assert_equal("merge-v0", 2, 2.0, **config)


def test_roads_that_others_make_are_left_alone() -> None:
    before = dict(vars(Road)), dict(vars(IDMVehicle))
    world("highway-v0", 1)
    assert (dict(vars(Road)), dict(vars(IDMVehicle))) == before
    assert type(original("highway-v0", 1).road) is Road


@pytest.mark.parametrize("connected", [False, True])
def test_neighbours_at_equal_places_are_those_of_highway_env(connected: bool) -> None:
    """Cars side by side on a lane have equal places on it; which of them is found must not differ."""
    network = RoadNetwork()
    for start, end in (("a", "b"), ("b", "c")):
        for lane in range(2):
            x, y = (0.0 if start == "a" else 60.0), 4.0 * lane
            network.add_lane(start, end, StraightLane([x, y], [x + 60.0, y], width=8.0))
    road = Road(network, neighbour_vehicles_connected_lanes=connected)
    places = [(10.0, 0.0), (10.0, 1.0), (30.0, 0.0), (30.0, 2.0), (30.0, 1.0), (59.0, 3.0), (62.0, 0.0), (62.0, 1.0)]
    road.vehicles = [IDMVehicle(road, place, speed=20.0) for place in places]
    lanes = [(*ends, lane) for ends in (("a", "b"), ("b", "c")) for lane in range(2)]
    cars = road.vehicles
    expected = [road.neighbour_vehicles(car, lane) for car in cars for lane in lanes]
    found: list[Any] = []
    speed_up(road)
    ask = lambda self: found.extend(road.neighbour_vehicles(self, lane) for lane in lanes)  # noqa: E731
    for car in cars:
        car.change_lane_policy = ask.__get__(car)  # called while the index holds
        car.timer = 2.0 * car.LANE_CHANGE_DELAY
    road.act()
    assert found == expected
    assert any(None not in pair for pair in expected)


@pytest.mark.parametrize("name", ROADS)
def test_the_table_of_lanes_has_highway_envs_numbers(name: str) -> None:
    network = original(name, 0).road.network
    table, draw = LaneTable(network), np.random.default_rng(0)
    lanes = network.lanes_list()
    at = draw.integers(len(lanes), size=40)
    points = np.array([lanes[k].position(draw.uniform(-9.0, lanes[k].length + 9.0), draw.normal()) for k in at])
    headings = draw.uniform(-9.0, 9.0, len(points))
    s, lateral = table.coordinates(points)
    on = table.are_on(s, lateral, 1.0)
    for number, lane in enumerate(lanes):
        expected = [lane.local_coordinates(point) for point in points]
        assert list(zip(s[number].tolist(), lateral[number].tolist(), strict=True)) == expected
        assert on[number].tolist() == [bool(lane.on_lane(point, margin=1.0)) for point in points]
        assert table.headings(s)[number].tolist() == [lane.heading_at(one) for one in s[number].tolist()]
    nearest = table.nearest(points, headings).tolist()
    expected = [network.get_closest_lane_index(*one) for one in zip(points, headings, strict=True)]
    assert [table.indexes[lane] for lane in nearest] == expected
