"""The gradient-tracking controller on motions planned in space and time, in closed loop with a kinematic bicycle."""

from math import asin, cos, sin

import numpy as np
import pytest
from bicycle import Bicycle
from made_scene import LANE_M, planner, road, scene, tracks

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.planning.spacetime.motion import Motion
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.planning.spacetime.tracking import reference
from vpf_sim.scene import Road
from vpf_sim.types import VehicleModel

VEHICLE = VehicleModel()
FRONT_M = 0.5 * VEHICLE.length_m  # from the middle


def driven(on: Road, motion: Motion, car: Bicycle, duration_s: float) -> np.ndarray:
    """(N, 5) by step: the rear axle's deviation from the path and s behind the plan, m, the speed's error, m/s, and
    the front's place, m."""
    control, rows = Gtsmc(load_gains("motion"), VEHICLE, 60.0), []
    for _ in range(round(60.0 * duration_s)):
        seen = car.observe()
        s, d = rear_place(on, car)
        behind_m, slower_mps = motion.s_at(seen.time_s) - s, motion.speed_at(seen.time_s) - car.speed_mps
        front = car.x_m + FRONT_M * cos(car.yaw_rad), car.y_m + FRONT_M * sin(car.yaw_rad)
        rows.append((d - motion.path_at(s)[0], behind_m, slower_mps, *front))
        car.step(control.command(seen, reference(motion, on, seen, place(on, car.x_m, car.y_m), VEHICLE)))
    return np.array(rows)


def place(on: Road, x_m: float, y_m: float) -> tuple[float, float]:
    s, d = on.place_at(np.array([x_m]), np.array([y_m]), np.array([x_m]))
    return float(s[0]), float(d[0])


def rear_place(on: Road, car: Bicycle) -> tuple[float, float]:
    return place(on, car.x_m - VEHICLE.l_r_m * cos(car.yaw_rad), car.y_m - VEHICLE.l_r_m * sin(car.yaw_rad))


def planned(on: Road, objects: tuple[tuple[float, ...], ...], speed_mps: float, reference_mps: float) -> Motion:
    return planner().plan(scene(on, tracks(on, *objects), 0.0, 0.0, speed_mps, reference_mps))


@pytest.mark.parametrize("speed_mps", [3.0, 5.5, 12.0, 25.0])
def test_a_motion_around_an_obstacle_is_followed(speed_mps: float) -> None:
    on = road()
    motion = planned(on, ((3.5 * speed_mps + 4.0, 0.4, 0.0, 0.0, 4.5, 1.9),), speed_mps, speed_mps)
    assert abs(motion.path.end_m[0]) > 1.0
    off, behind, *_ = driven(on, motion, Bicycle(speed_mps=speed_mps), 3.5).T
    assert np.abs(off).max() < 0.12
    assert np.abs(behind).max() < 0.5


@pytest.mark.parametrize("speed_mps", [0.5, 2.0, 5.5])
def test_the_front_is_where_the_motion_says_while_the_wheels_turn(speed_mps: float) -> None:
    """In a sharp turn the wheels need half a second to turn, and the body's middle does not drive where it points."""
    on = road()
    motion = planned(on, ((9.4 + speed_mps, 0.5, 0.0, 0.0, 4.5, 1.9),), speed_mps, 5.5)
    plan = motions(on, motion.start, motion.path, motion.profile, VEHICLE)
    x, y, heading = (plan.in_time(values)[0, 0, :12] for values in plan.poses)
    front = plan.origin_m[0] + x + FRONT_M * np.cos(heading), plan.origin_m[1] + y + FRONT_M * np.sin(heading)
    assert np.ptp(front[1]) > 1.0
    *_, x_m, y_m = driven(on, motion, Bicycle(speed_mps=speed_mps), 3.0).T
    np.testing.assert_allclose(np.interp(front[0], x_m, y_m), front[1], atol=0.12)


@pytest.mark.parametrize("speed_mps", [3.0, 8.0, 25.0])
def test_a_deviation_decays_without_overshoot(speed_mps: float) -> None:
    on = road()
    off, *_ = driven(on, planned(on, (), speed_mps, speed_mps), Bicycle(y_m=0.4, speed_mps=speed_mps), 5.0).T
    assert abs(off[-1]) < 0.03
    assert off.min() > -0.08


@pytest.mark.parametrize("radius_m", [15.0, -15.0])
def test_it_stays_on_a_circle(radius_m: float) -> None:
    on = road(1.0 / radius_m)
    motion = planned(on, (), 5.0, 5.0)
    slip = asin(VEHICLE.l_r_m / radius_m)
    car = Bicycle(speed_mps=5.0, yaw_rad=-slip, yaw_rate_radps=5.0 / radius_m)
    assert np.abs(driven(on, motion, car, 4.0)[180:, 0]).max() < 0.05  # the wheels were straight


def test_the_planned_stop_is_kept_and_the_car_held() -> None:
    on = road()
    wall = tuple((10.5, d, 0.0, 0.0, 4.5, 3.4) for d in (-LANE_M, 0.0, LANE_M))
    motion = planned(on, wall, 5.5, 5.5)
    assert motion.speed_at(4.9) == 0.0
    car = Bicycle()
    _, behind, slower, *_ = driven(on, motion, car, 5.0).T
    assert car.speed_mps == 0.0
    assert np.abs(behind).max() < 0.3
    assert np.abs(slower).max() < 0.5
    held = Gtsmc(load_gains("motion"), VEHICLE, 60.0).command(
        car.observe(), reference(motion, on, car.observe(), place(on, car.x_m, car.y_m), VEHICLE)
    )
    assert held.throttle < 0.0
