"""Where tracks will be, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from made_scene import LANE_M, road, tracks

from vpf_sim.scene import predict
from vpf_sim.scene.lanes import LaneLine, LanePlace

TIMES_S, STRAIGHT = np.arange(0.0, 5.0, 0.5), road()


def test_a_car_in_a_bend_stays_in_its_lane() -> None:
    bend = road(1.0 / 50.0)
    seen = predict(bend, tracks(bend, (10.0, 2.0, 0.0, 6.0, 4.5, 1.9)), TIMES_S)
    radius_m = np.hypot(seen.x_m[0], seen.y_m[0] - 50.0)
    np.testing.assert_allclose(radius_m, 48.0, atol=0.01)
    driven_m = 48.0 * (seen.heading_rad[0] - seen.heading_rad[0, 0])
    np.testing.assert_allclose(driven_m, 6.0 * TIMES_S, atol=0.05)


def test_who_changes_lanes_stops_in_the_next_lane() -> None:
    turn = np.arcsin(1.0 / 6.0)
    seen = predict(STRAIGHT, tracks(STRAIGHT, (10.0, 0.5, turn, 6.0, 4.5, 1.9)), TIMES_S)
    np.testing.assert_allclose(seen.y_m[0], np.minimum(0.5 + TIMES_S, LANE_M), atol=1e-9)


@pytest.mark.parametrize("heading_rad", [np.pi / 2.0, -np.pi / 2.0])
def test_who_crosses_goes_on(heading_rad: float) -> None:
    seen = predict(STRAIGHT, tracks(STRAIGHT, (20.0, 0.0, heading_rad, 1.4, 0.5, 0.5)), TIMES_S)
    np.testing.assert_allclose(seen.x_m[0], 20.0, atol=1e-9)
    np.testing.assert_allclose(seen.y_m[0], np.sign(heading_rad) * 1.4 * TIMES_S, atol=1e-9)


def test_a_turning_car_beside_the_road_drives_on_its_circle() -> None:
    made = tracks(STRAIGHT, (20.0, 30.0, 0.0, 5.0, 4.5, 1.9))
    made.yaw_rate_radps[:] = 0.25  # a radius of 20 m
    seen = predict(STRAIGHT, made, TIMES_S)
    np.testing.assert_allclose(np.hypot(seen.x_m[0] - 20.0, seen.y_m[0] - 50.0), 20.0, atol=1e-9)


def test_oncoming_traffic_drives_against_s() -> None:
    seen = predict(STRAIGHT, tracks(STRAIGHT, (80.0, -LANE_M, np.pi, 8.0, 4.5, 1.9)), TIMES_S)
    np.testing.assert_allclose(seen.x_m[0], 80.0 - 8.0 * TIMES_S, atol=1e-9)


def test_oncoming_traffic_goes_straight_on_where_the_own_road_bends_away() -> None:
    bend = road(1.0 / 30.0)
    no_lane = (bend.station_m > 20.0) & (bend.station_m < 30.0)  # left of the own lane, as in a junction
    left = np.where(no_lane, -LANE_M / 2.0, bend.left_m)
    seen = predict(replace(bend, left_m=left), tracks(bend, (35.0, -LANE_M, np.pi, 8.0, 4.5, 1.9)), TIMES_S)
    turned = np.abs(seen.heading_rad[0, -1] - seen.heading_rad[0, 0])
    assert turned < 8.0 / 30.0 < 8.0 * TIMES_S[-1] / 30.0
    np.testing.assert_allclose(np.hypot(np.diff(seen.x_m[0]), np.diff(seen.y_m[0])), 4.0, rtol=0.15)


def test_the_uncertainty_grows_with_that_of_the_speed() -> None:
    made = tracks(STRAIGHT, (80.0, 0.0, 0.0, 8.0, 4.5, 1.9))
    made.covariance[0] = np.diag([0.04, 0.01, 0.25, 0.0])
    seen = predict(STRAIGHT, made, TIMES_S)
    np.testing.assert_allclose(seen.along_sigma_m[0], np.sqrt(0.04 + 0.25 * TIMES_S**2))
    np.testing.assert_allclose(seen.across_sigma_m[0], 0.1)


def test_who_drives_along_the_road_keeps_its_lane_and_who_crosses_may_go_anywhere() -> None:
    along = tracks(STRAIGHT, (80.0, LANE_M, 0.0, 5.0, 4.5, 1.9))
    crosses = tracks(STRAIGHT, (80.0, LANE_M, 0.5 * np.pi, 5.0, 4.5, 1.9))
    for made in (along, crosses):
        made.covariance[0] = np.diag([1.0, 1.0, 1.0, 1.0])
    assert predict(STRAIGHT, along, TIMES_S).across_sigma_m.max() < 0.25 * LANE_M
    assert predict(STRAIGHT, crosses, TIMES_S).across_sigma_m.max() > LANE_M


def test_a_car_in_a_known_lane_follows_it_and_comes_to_its_middle() -> None:
    """A quarter of a circle of 20 m beside the road, entered 1 m right of the lane's middle."""
    angle = np.linspace(0.0, np.pi / 2.0, 91)
    lane = LaneLine(20.0 * angle, 20.0 * np.sin(angle), 50.0 - 20.0 * np.cos(angle), angle)
    made = tracks(STRAIGHT, (0.0, 31.0, 0.0, 5.0, 4.5, 1.9))
    seen = predict(STRAIGHT, replace(made, lanes=(LanePlace(lane, 0.0, 1.0),)), TIMES_S)
    radius_m = np.hypot(seen.x_m[0], seen.y_m[0] - 50.0)
    assert radius_m[0] == pytest.approx(19.0)
    np.testing.assert_allclose(radius_m[6:], 20.0, atol=0.05)
    np.testing.assert_allclose(seen.heading_rad[0], 0.25 * TIMES_S, atol=1e-6)
    assert np.hypot(*np.diff([seen.x_m[0, -2:], seen.y_m[0, -2:]]).ravel()) == pytest.approx(2.5, abs=0.02)


def test_a_car_that_stands_in_a_known_lane_stays() -> None:
    lane = LaneLine(np.array([0.0, 50.0]), np.array([0.0, 50.0]), np.zeros(2), np.zeros(2))
    made = tracks(STRAIGHT, (10.0, 0.4, 0.3, 0.0, 4.5, 1.9))
    seen = predict(STRAIGHT, replace(made, lanes=(LanePlace(lane, 10.0, 0.4),)), TIMES_S)
    np.testing.assert_allclose([seen.x_m[0], seen.y_m[0]], [[10.0] * 10, [0.4] * 10])


def test_a_vehicle_that_was_lost_from_sight_keeps_its_lane_and_a_pedestrian_may_be_anywhere() -> None:
    """Both perhaps stand by now: their velocity is unknown, and so is their place, within 2 m."""
    vehicle, pedestrian = (tracks(STRAIGHT, (80.0, LANE_M, 0.0, 0.0, *size)) for size in ((4.5, 1.9), (0.5, 0.5)))
    for made in (vehicle, pedestrian):
        made.covariance[0] = np.diag([4.0, 4.0, 0.0, 0.0])
    assert predict(STRAIGHT, vehicle, TIMES_S).across_sigma_m.max() < 0.25 * LANE_M
    assert predict(STRAIGHT, pedestrian, TIMES_S).across_sigma_m.min() == pytest.approx(2.0)
