"""Where a motion has the body, against the geometry of a car at a place of a bend."""

from dataclasses import replace
from math import atan, cos, sin, tan

import numpy as np
import pytest
from made_scene import EDGE_M, road

from vpf_sim.geometry import wrap_angles
from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.limits import room_m
from vpf_sim.planning.spacetime.motions import Motions, motions, path_curvature, path_second, rear_axle, rear_speed
from vpf_sim.scene import Road
from vpf_sim.types import VehicleModel

CAR = VehicleModel()
S_M = 20.0
BENDS = pytest.mark.parametrize("radius_m", [16.0, -16.0, 60.0, 1e9])
PLACES = pytest.mark.parametrize(("d_m", "course_rad"), [(0.0, 0.0), (5.0, 0.0), (-5.0, 0.0), (3.0, 0.3), (-3.0, -0.5)])


def standing(on: Road, d_m: float, course_rad: float) -> Motions:
    """A car that stands with its rear axle at (20 m, d) and turned by the course from the road there."""
    slope = tan(course_rad) * (1.0 - on.direction_at(S_M)[1] * d_m)
    start = PathState(S_M, d_m, slope, 0.0, 0.0, 0.0)
    path = Paths(np.array([S_M]), np.array([10.0]), np.array([[d_m, 10.0 * slope, 0.0, 0.0, 0.0, 0.0]]))
    return motions(on, start, path, Profiles(*np.zeros((3, 1, 3))), CAR)


def points(on: Road, d_m: float, course_rad: float) -> np.ndarray:
    """(5, 2) m in the world: the middle and the four corners of that car."""
    x, y, heading = (float(value) for value in on.world(np.array(S_M), np.array(d_m)))
    yaw = heading + course_rad
    half = np.array([[0.0, 0.0], *([a, b] for a in (-2.25, 2.25) for b in (-0.95, 0.95))])
    forward, right = (half + np.array([CAR.l_r_m, 0.0])).T
    return np.stack([x + forward * cos(yaw) - right * sin(yaw), y + forward * sin(yaw) + right * cos(yaw)], axis=-1)


@BENDS
@PLACES
def test_the_body_is_where_its_rear_axle_says(radius_m: float, d_m: float, course_rad: float) -> None:
    on = road(1.0 / radius_m)
    found, (middle, *corners) = standing(on, d_m, course_rad), points(on, d_m, course_rad)
    x, y = (value[0, 0] for value in (found.x_m, found.y_m))
    assert (x + found.origin_m[0], y + found.origin_m[1]) == pytest.approx(tuple(middle), abs=1e-3)
    _, d = on.place_at(*np.array([middle, *corners]).T, np.full(5, S_M))
    assert found.d_m[0, 0] == pytest.approx(d[0], abs=0.01)
    assert found.leftmost_m[0, 0] == pytest.approx(d[1:].min(), abs=0.1)
    assert found.rightmost_m[0, 0] == pytest.approx(d[1:].max(), abs=0.1)
    assert room_m(found, 0.0)[0, 0] == pytest.approx(min(d[1:].min() + EDGE_M, EDGE_M - d[1:].max()), abs=0.1)


@BENDS
@PLACES
def test_the_rear_axle_is_found_from_the_middle(radius_m: float, d_m: float, course_rad: float) -> None:
    on = road(1.0 / radius_m)
    middle = points(on, d_m, course_rad)[0]
    s, d = on.place_at(middle[:1], middle[1:], np.array([S_M]))
    yaw = on.direction_at(S_M)[0] + course_rad
    assert rear_axle(on, float(s[0]), float(d[0]), yaw, CAR) == pytest.approx((S_M, d_m, course_rad), abs=0.02)


def swerves(on: Road, speed_mps: float) -> tuple[Motions, Paths, np.ndarray]:
    """Two paths, 3 m to either side within some lengths, each driven fast and slowly; and (M, T) s."""
    start, length_m = PathState(S_M, 0.0, 0.0, 0.0, speed_mps, 0.0), max(8.0, 1.4 * speed_mps)
    coefficients = np.array([[0.0, 0.0, 0.0, 10.0 * side, -15.0 * side, 6.0 * side] for side in (-3.0, 3.0)])
    paths = Paths(np.full(2, S_M), np.full(2, length_m), coefficients)
    speeds = np.array([[speed_mps], [0.3 * speed_mps]]) * np.ones(26)
    travelled = speeds * np.arange(0.0, 5.1, 0.2)
    found = motions(on, start, paths, Profiles(travelled, speeds, 0.0 * speeds), CAR)
    return found, paths, S_M + travelled


@pytest.mark.parametrize(
    ("radius_m", "speed_mps"), [(16.0, 0.2), (16.0, 5.5), (-16.0, 5.5), (80.0, 14.0), (200.0, 25.0), (1e9, 25.0)]
)
def test_between_its_places_a_path_is_where_it_should_be(radius_m: float, speed_mps: float) -> None:
    """The rear axle is at d(s), and the middle before it in the direction in which the rear axle moves."""
    found, paths, s = swerves(road(1.0 / radius_m), speed_mps)
    x, y, heading = (found.in_time(values) for values in found.poses)

    def rear(s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Around the road's centre."""
        away_m, angle = radius_m - paths.at(s_m[None])[0], s_m / radius_m
        return away_m * np.sin(angle), radius_m - away_m * np.cos(angle)

    (rear_x, rear_y), (behind_x, behind_y), (before_x, before_y) = rear(s), rear(s - 0.01), rear(s + 0.01)
    course = np.arctan2(before_y - behind_y, before_x - behind_x)
    off_m = np.hypot(
        x + found.origin_m[0] - rear_x - CAR.l_r_m * np.cos(course),
        y + found.origin_m[1] - rear_y - CAR.l_r_m * np.sin(course),
    )
    assert off_m.max() < 0.03
    assert np.abs(wrap_angles(heading - course)).max() < 0.01


def test_a_mean_in_time_and_single_motions_are_those_of_all_times() -> None:
    found, _, _ = swerves(road(1.0 / 60.0), 5.5)
    in_time = found.in_time(found.d_m)
    np.testing.assert_allclose(found.mean(found.d_m), in_time.mean(axis=2), atol=1e-5)
    np.testing.assert_allclose(
        found.mean(found.d_m, found.speed_mps), (in_time * found.speed_mps).mean(axis=2), atol=1e-4
    )
    np.testing.assert_allclose(found.last(found.d_m), in_time[..., -1], atol=1e-6)
    path, profile = np.array([1, 0, 0]), np.array([0, 1, 0])
    np.testing.assert_allclose(found.along(found.d_m, path, profile), in_time[path, profile], atol=1e-6)


def test_the_edges_are_those_beside_the_middle() -> None:
    on = road()
    narrower = replace(on, left_m=np.where(on.station_m < S_M + 0.5, on.left_m, on.left_m + 1.0))
    assert standing(narrower, 0.0, 0.0).left_m[0] == pytest.approx(-EDGE_M + 1.0)


@pytest.mark.parametrize(("turn", "own_per_m", "road_per_m", "d_m"), [(0.0, 0.1, 0.06, 5.0), (0.4, -0.2, -0.05, -3.0)])
def test_a_path_begins_with_the_curvature_of_the_car(
    turn: float, own_per_m: float, road_per_m: float, d_m: float
) -> None:
    stretch = 1.0 - road_per_m * d_m
    second = path_second(turn, own_per_m, road_per_m, stretch)
    assert path_curvature(turn, second, road_per_m, stretch) == pytest.approx(own_per_m)


@pytest.mark.parametrize("steering_rad", [0.0, 0.3, -0.6])
def test_the_rear_axle_is_slower_than_the_middle_in_a_turn(steering_rad: float) -> None:
    """On a circle all points turn at one rate, and the rear axle's radius is wheelbase / tan(steering)."""
    if not steering_rad:
        assert rear_speed(5.0, 0.0, CAR) == 5.0
        return
    slip = atan(CAR.l_r_m / CAR.wheelbase_m * tan(steering_rad))
    yaw_rate = 5.0 * sin(slip) / CAR.l_r_m
    assert rear_speed(5.0, yaw_rate, CAR) == pytest.approx(yaw_rate * CAR.wheelbase_m / tan(steering_rad))


def test_curvature_is_limited_at_the_rear_axle() -> None:
    """The limit is within the wheels' own: tan(steering) / wheelbase."""
    assert settings.load().limits.curvature_per_m < tan(CAR.steering_limit_rad) / CAR.wheelbase_m
