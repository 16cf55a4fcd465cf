"""Signals derived by physics, against motions in closed form."""

import numpy as np
import pytest

from vpf_sim.replay import derived, paths, series
from vpf_sim.types import VehicleModel

RANDOM_GAPS = np.cumsum(np.tile([0.03, 0.05, 0.04, 0.033, 0.067], 30))


def test_slope_is_exact_for_constant_acceleration_at_uneven_times() -> None:
    speed = 3.0 + 0.7 * RANDOM_GAPS + 0.2 * RANDOM_GAPS**2
    assert derived.slope(RANDOM_GAPS, speed)[20:-20] == pytest.approx((0.7 + 0.4 * RANDOM_GAPS)[20:-20], abs=5e-3)
    assert derived.slope(RANDOM_GAPS, speed) == pytest.approx(0.7 + 0.4 * RANDOM_GAPS, abs=0.02)
    assert derived.slope(np.array([0.0, 0.1]), np.array([1.0, 1.2])) == pytest.approx([2.0, 2.0])


def test_right_circle_has_positive_yaw_rate() -> None:
    """Speed and yaw rate to poses and back; the camera ahead of the axle is on a larger circle."""
    speed, rate = np.full(150, 10.0), np.full(150, 0.25)
    poses = derived.travelled(RANDOM_GAPS, speed, rate)
    turned = 0.25 * (RANDOM_GAPS - RANDOM_GAPS[0])
    assert poses == pytest.approx(
        np.stack([40.0 * np.sin(turned), 40.0 * (1 - np.cos(turned)), turned], axis=1), abs=1e-3
    )
    assert derived.speed(RANDOM_GAPS, poses)[1:-1] == pytest.approx(speed[1:-1], rel=1e-2)
    assert derived.yaw_rate(RANDOM_GAPS, poses) == pytest.approx(rate)
    camera = derived.travelled(RANDOM_GAPS, speed, rate, ahead_m=1.5)
    radius = np.hypot(camera[:, 0] + 1.5, camera[:, 1] - 40.0)
    assert radius == pytest.approx(np.full(150, np.hypot(40.0, 1.5)), abs=1e-3)


def test_steering_inverts_the_bicycle_model() -> None:
    angle = np.radians([-30.0, -2.0, 0.0, 5.0, 40.0])
    rate = 8.0 * np.tan(angle) / 2.7
    assert derived.steering(np.full(5, 8.0), rate, 2.7) == pytest.approx(angle)
    assert np.isnan(derived.steering(np.array([0.0, 0.9]), np.array([0.0, 0.1]), 2.7)).all()


def test_throttle_and_brake_have_their_own_scales() -> None:
    assert derived.throttle(np.array([3.0, 1.5, 0.0, -3.0, -9.0])) == pytest.approx([1.0, 0.5, 0.0, -0.5, -1.0])
    assert derived.throttle(np.array([1.0]), VehicleModel(full_throttle_mps2=2.0)) == pytest.approx([0.5])


def test_signals_are_interpolated_but_not_over_gaps() -> None:
    times, values = np.array([0.0, 0.1, 0.2, 1.2, 1.3]), np.array([0.0, 1.0, 2.0, 12.0, 13.0])
    requested = np.array([-0.6, -0.2, 0.05, 0.7, 1.25, 1.7, 2.0])
    found = series.at(requested, times, values)
    assert found[[1, 2, 4, 5]] == pytest.approx([0.0, 0.5, 12.5, 13.0])
    assert np.isnan(found[[0, 3, 6]]).all()
    slow = series.at(np.array([0.5, 1.5]), np.array([0.0, 1.0, 2.0]), np.array([0.0, 10.0, 20.0]))
    assert slow == pytest.approx([5.0, 15.0])  # a receiver of 1 Hz has no gap there
    assert np.isnan(series.at(requested, times, np.full(5, np.nan))).all()


def test_course_is_clockwise_from_north_and_held_at_standstill() -> None:
    times = np.arange(0.0, 20.0, 0.1)
    along = np.clip(times - 5.0, 0.0, 10.0) * 4.0  # standstill, drive, standstill
    flat = np.stack([along * np.cos(0.6), along * np.sin(0.6)], axis=1)  # north, east
    course = paths.course(times, flat)
    assert course == pytest.approx(np.full(len(times), 0.6), abs=1e-6)
    path = paths.poses(flat, course)
    assert path[-1] == pytest.approx([40.0, 0.0, 0.0], abs=1e-6)
    assert paths.poses(flat, np.zeros(len(times)))[-1, 1] > 0.0  # east of north is to the right


def test_one_degree_north_is_111_km() -> None:
    flat = paths.north_east(np.array([0.0, 1.0]), np.array([8.0, 8.0]))
    assert flat[1, 0] == pytest.approx(111_320.0, rel=1e-3)
    flat = paths.north_east(np.array([60.0, 60.0]), np.array([8.0, 9.0]))
    assert flat[1] == pytest.approx([0.0, 55_660.0], rel=1e-3)
