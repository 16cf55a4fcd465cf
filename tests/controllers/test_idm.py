"""highway-env's driver in the ego: privileges, and closed forms along and across the lane."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bicycle import Bicycle
from highway_env.vehicle.behavior import IDMVehicle

from vpf_sim import drivers
from vpf_sim.controllers.idm import Gains, load_gains
from vpf_sim.driver_interface import Driver, DriverSetup
from vpf_sim.envs.actor import ACTORS
from vpf_sim.envs.ego import Ego
from vpf_sim.envs.road import build_road
from vpf_sim.errors import InputError
from vpf_sim.scenarios import Scenario, parse
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, VehicleModel

ONE_LANE = (
    'schema = 1\n[road]\nlanes = 1\nsegments = [{kind = "line", length_m = 2000}]\n[ego]\nlane = 1\n[goal]\ns_m = 1900'
)
RATE_HZ = 60.0


def world(*, lead_s_m: float | None = None, lead_mps: float = 3.0) -> Any:
    """A road of one lane with the ego at 5 m, and perhaps a car ahead."""
    scenario = parse(ONE_LANE, "one lane")
    assert isinstance(scenario, Scenario)
    road = build_road(scenario, stream(0, "road"))
    if lead_s_m is not None:
        road.vehicles.append(ACTORS["car"](road, (lead_s_m, 0.0), lead_mps))
    road.vehicles.append(Ego(road, np.array([5.0, 0.0]), 0.0, 5.55))
    return road


def started(road: Any) -> Driver:
    driver = drivers.create("idm")
    setup = DriverSetup(
        Camera(), VehicleModel(), RATE_HZ, 5.55, (1900.0, 0.0), 0, np.array([[0.0, 0.0], [1.0, 0.0]]), road
    )
    driver.reset(setup)
    return driver


def drive(road: Any, time_s: float) -> Floats:
    """(n, 3) gap to the first vehicle, centre to centre, m; speed, m/s; offset from the lane's centre, m."""
    driver, ego = started(road), road.vehicles[-1]
    rows = []
    for _ in range(int(time_s * RATE_HZ)):
        seen = Bicycle(*ego.position.tolist(), ego.heading, ego.speed).observe()
        command = driver.act(seen)
        full = ego.model.full_throttle_mps2 if command.throttle > 0.0 else ego.model.full_brake_mps2
        ego.act({"acceleration": command.throttle * full, "steering": command.steering * ego.model.steering_limit_rad})
        road.act()
        road.step(1.0 / RATE_HZ)
        rows.append((road.vehicles[0].position[0] - ego.position[0], ego.speed, ego.position[1]))
    return np.array(rows)


def test_gap_behind_a_slower_car_matches_the_model() -> None:
    """In equilibrium (v / v0)^4 + (s* / s)^2 = 1, s* = s0 + v T."""
    gap_m, speed_mps, _ = drive(world(lead_s_m=40.0), 60.0)[-1]
    wanted_m = 10.0 + 3.0 * 1.5  # highway-env's defaults
    assert speed_mps == pytest.approx(3.0, abs=0.01)
    assert gap_m == pytest.approx(wanted_m / np.sqrt(1.0 - (3.0 / 5.55) ** 4), rel=0.01)


def test_settings_that_highway_envs_intersection_leaves_behind_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    before = drive(world(lead_s_m=30.0), 3.0)
    for name, value in {"DISTANCE_WANTED": 7, "COMFORT_ACC_MAX": 6, "COMFORT_ACC_MIN": -3}.items():
        monkeypatch.setattr(IDMVehicle, name, value)
    assert np.array_equal(drive(world(lead_s_m=30.0), 3.0), before)


def test_empty_road_keeps_the_reference_speed() -> None:
    assert drive(world(), 5.0)[:, 1] == pytest.approx(5.55)


def test_lateral_offset_decays_with_both_time_constants() -> None:
    """y'' + y' / T_h + y / (T_h T_y) = 0, from y0 with y' = 0: two exponentials."""
    road = world()
    road.vehicles[0].position = np.array([5.0, 0.1])
    gains = load_gains()
    fast, slow = np.roots([1.0, 1.0 / gains.heading_s, 1.0 / (gains.heading_s * gains.lateral_s)]).tolist()
    time_s = np.arange(1, 361) / RATE_HZ
    decay = (fast * np.exp(slow * time_s) - slow * np.exp(fast * time_s)) / (fast - slow)
    # The slip of the centre of mass, which the law leaves out, moves it towards the wheels a little earlier.
    assert drive(road, 6.0)[:, 2] / 0.1 == pytest.approx(decay, abs=0.12)


def test_idm_does_not_modify_the_world() -> None:
    road = world(lead_s_m=40.0)
    before = [road.vehicles[:], road.objects[:], [vars(vehicle).copy() for vehicle in road.vehicles], vars(road).copy()]
    driver = started(road)
    for _ in range(3):
        driver.act(Bicycle(5.0, 0.0).observe())
    after = [road.vehicles[:], road.objects[:], [vars(vehicle).copy() for vehicle in road.vehicles], vars(road).copy()]
    assert repr(before) == repr(after)


def test_idm_requires_and_declares_the_world() -> None:
    driver = drivers.create("idm")
    assert driver.privileged == "world"
    setup = DriverSetup(Camera(), VehicleModel(), RATE_HZ, 5.55, (1900.0, 0.0), 0, np.array([[0.0, 0.0], [1.0, 0.0]]))
    with pytest.raises(InputError, match="driver idm: expected the world in its setup, got none"):
        driver.reset(setup)


def test_gains_must_be_positive() -> None:
    with pytest.raises(ValueError, match=r"lateral_s: expected > 0, got -1\.0"):
        replace(load_gains(), lateral_s=-1.0)
    assert Gains(2.5, 0.5)
