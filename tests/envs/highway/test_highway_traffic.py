"""highway-env's traffic: the same cars as in highway-env, the same in every process, and none where none is wanted."""

import subprocess
import sys
from collections.abc import Callable

import gymnasium
import numpy as np
import pytest
from highway_env.vehicle.behavior import AggressiveVehicle, IDMVehicle
from highway_worlds import ROADS, empty, original, scenario, world

from vpf_sim.envs.camera import Rig
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.world import build_world
from vpf_sim.types import Camera

SMALL = Rig(camera=Camera(96, 72))
DRIVES = """
import numpy as np
from vpf_sim.envs.four_lane import FourLane
for name in ("two-way-v0", "intersection-v1", "two-way-v0"):
    env = FourLane(name, frames=False, rate_hz=20.0)
    env.reset(seed=2)
    for _ in range(60):
        env.advance(np.array([0.2, 0.0]))
    print("".join(vehicle.position.tobytes().hex() for vehicle in env.road.vehicles))
"""


@pytest.mark.parametrize("name", ROADS)
def test_the_traffic_is_highway_envs_own(name: str) -> None:
    theirs, ours = original(name, 4), world(name, 4)
    expected = [vehicle for vehicle in theirs.road.vehicles if vehicle is not theirs.vehicle]
    found = [vehicle for vehicle in ours.road.vehicles if vehicle is not ours.ego]
    assert [type(vehicle) for vehicle in found] == [type(vehicle) for vehicle in expected]
    for one, other in zip(found, expected, strict=True):
        assert one.position == pytest.approx(other.position)
        assert one.speed == pytest.approx(other.speed)
    assert len(ours.road.objects) == len(theirs.road.objects)


@pytest.mark.parametrize("name", ROADS[::2])
def test_the_same_seed_gives_the_same_frames_whatever_was_driven_before(name: str) -> None:
    def frames() -> list[np.ndarray]:
        env = FourLane(name, "rain", rig=SMALL, rate_hz=20.0)
        observed, info = env.reset(seed=5)
        found = [observed["image"]]
        for _ in range(4):
            observed, _, _, _, info = env.step(np.array([0.2, 0.0]))
            assert env.observation_space.contains(observed)
            found.append(observed["image"])
        assert info["status"] == "running"
        return found

    first = frames()
    build_world(scenario("intersection-v1"), 1)
    assert all(map(np.array_equal, first, frames()))
    assert len({frame.tobytes() for frame in first}) == len(first), "they move"


def test_a_drive_is_the_same_first_in_its_process_and_after_others() -> None:
    """highway-env's intersection sets parameters of all its cars; the next drive must not inherit them."""

    done = subprocess.run([sys.executable, "-c", DRIVES], capture_output=True, text=True, check=True)
    first, _, after = done.stdout.split()
    assert first == after


def test_the_intersections_parameters_stay_with_its_own_cars(monkeypatch: pytest.MonkeyPatch) -> None:
    """highway-env sets them on the class of its cars, such as a jam distance of 7 m."""
    monkeypatch.setattr(IDMVehicle, "DISTANCE_WANTED", 11)
    here = world("intersection-v1")
    assert IDMVehicle.DISTANCE_WANTED == 11
    others = [vehicle for vehicle in here.road.vehicles if vehicle is not here.ego]
    assert {vehicle.DISTANCE_WANTED for vehicle in others} == {7}


@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_an_intersection_that_the_user_makes_changes_nothing(when: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It sets three parameters on the class of its cars, which `two-way-v0` and `intersection-v1` use as well."""

    def states(name: str, disturb: Callable[[], object]) -> list[tuple[float, ...]]:
        disturb() if when == "before" else None
        env = FourLane(name, frames=False, rate_hz=20.0)
        env.reset(seed=2)
        disturb() if when == "meanwhile" else None
        for _ in range(60):
            env.advance(np.array([0.2, 0.0]))
        return [(*vehicle.position.tolist(), vehicle.speed) for vehicle in env.road.vehicles]

    names = ("two-way-v0", "intersection-v1")
    alone = [states(name, lambda: None) for name in names]
    for name in ("DISTANCE_WANTED", "COMFORT_ACC_MAX", "COMFORT_ACC_MIN"):  # to be as before after this test
        monkeypatch.setattr(IDMVehicle, name, getattr(IDMVehicle, name))
    assert [states(name, lambda: gymnasium.make("intersection-v1").reset(seed=0)) for name in names] == alone
    assert IDMVehicle.DISTANCE_WANTED == 7, "the user's own environments keep what they have set"


def test_cars_come_to_the_intersection_and_leave_it() -> None:
    env = FourLane(scenario("intersection-v1", spawn_probability=1.0), frames=False, rate_hz=20.0)
    env.reset(seed=0)
    first = set(map(id, env.road.vehicles))
    kept = list(env.road.vehicles)  # so that no other car gets the same id
    for _ in range(20 * 15):
        env.advance(np.array([-1.0, 0.0]))
    now = set(map(id, env.road.vehicles))
    assert now - first, "some have come"
    assert first - now, "some have left"
    assert env.ego in env.road.vehicles
    assert len(kept) == len(first)


@pytest.mark.parametrize("name", ["merge-v0", "intersection-v1", "racetrack-v0"])
def test_without_traffic_the_road_is_empty_and_the_start_the_same(name: str) -> None:
    alone, full = build_world(empty(name), 3), world(name, 3)
    assert alone.road.vehicles == [alone.ego]
    assert alone.road.objects == []
    assert alone.ego.position == pytest.approx(full.ego.position)
    assert alone.route.goal_m == pytest.approx(full.route.goal_m)


def test_the_class_of_the_other_cars_is_an_option() -> None:
    here = world("two-way-v0", other_vehicles_type="highway_env.vehicle.behavior.AggressiveVehicle")
    assert {type(vehicle) for vehicle in here.road.vehicles if vehicle is not here.ego} == {AggressiveVehicle}


def test_objects_have_a_place_on_the_route_only_near_it() -> None:
    here = world("two-way-v0", 0)
    for vehicle in here.road.vehicles:
        ahead_m = vehicle.position[0] - here.ego.position[0]
        if abs(ahead_m) < 90.0:
            assert vehicle.place == pytest.approx((ahead_m, vehicle.position[1] - here.ego.position[1]), abs=1e-6)
        elif ahead_m > 110.0:
            assert np.isnan(vehicle.place).all()


def test_the_ego_ahead_of_cars_that_yield_is_predicted_as_it_moves() -> None:
    """highway-env's cars predict it at constant speed and steering: an arc, as the ego's own step is."""
    ego = build_world(empty("intersection-v1"), 0).ego
    ego.steering_rad = 0.2
    ego.act({"acceleration": 0.0, "steering": 0.2})
    positions, headings = ego.predict_trajectory_constant_speed(np.array([0.5, 1.0]))
    for position, heading in zip(positions, headings, strict=True):
        for _ in range(30):
            ego.step(1.0 / 60.0)
        assert ego.position == pytest.approx(position, abs=1e-9)
        assert ego.heading == pytest.approx(heading, abs=1e-9)
