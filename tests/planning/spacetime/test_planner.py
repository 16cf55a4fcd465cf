"""Plans in scenes of which the right motion is known."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from made_scene import EDGE_M, LANE_M, driven, planner, road, scene, tracks

from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.candidates import Paths, Profiles
from vpf_sim.planning.spacetime.motion import Motion
from vpf_sim.scene import Road, Tracks
from vpf_sim.types import VehicleModel

CAR = (4.5, 1.9)


def planned(on: Road, seen: Tracks, s_m: float = 0.0, d_m: float = 0.0, speed_mps: float = 5.5) -> Motion:
    return planner().plan(scene(on, seen, s_m, d_m, speed_mps))


def driven_m(motion: Motion, time_s: float) -> float:
    return motion.s_at(time_s) - motion.start.s_m


def test_on_a_free_road_it_keeps_lane_and_speed() -> None:
    motion = planned(road(), tracks(road()))
    assert motion.path.end_m[0] == pytest.approx(0.0, abs=0.01)
    np.testing.assert_allclose(motion.profile.speed_mps, 5.5, atol=0.01)
    assert not motion.is_rejected


@pytest.mark.parametrize("reference_mps", [0.2, 1.0, 20.0])
def test_any_reference_speed_is_driven(reference_mps: float) -> None:
    on = road()
    *_, last = driven(scene(on, tracks(on), speed_mps=0.0, reference_mps=reference_mps), planner(), 150)
    assert last.ego.speed_mps == pytest.approx(reference_mps, rel=0.05)


@pytest.mark.parametrize("d_m", [-0.6, 0.6])
def test_it_passes_a_parked_car_on_the_wider_side(d_m: float) -> None:
    on = road()
    motion = planned(on, tracks(on, (18.0, d_m, 0.0, 0.0, *CAR)))
    beside_m, _, _ = motion.path_at(18.0)
    assert np.sign(beside_m) == -np.sign(d_m)
    assert abs(beside_m - d_m) > 1.9 + 0.2
    assert motion.speed_at(3.0) > 4.0
    assert motion.rejected.collision > 0


@pytest.mark.parametrize("d_m", [-0.6, 0.6])
def test_it_leaves_its_lane_late_for_a_parked_car(d_m: float) -> None:
    """The way to the side takes some 10 m, so half of the 26 m are still driven in the lane's middle."""
    on = road()
    motion = planned(on, tracks(on, (30.0, d_m, 0.0, 0.0, *CAR)))
    assert abs(motion.path_at(13.0)[0]) < 0.2
    assert abs(motion.path_at(30.0)[0] - d_m) > 1.9 + 0.2


def test_it_passes_a_parked_car_at_a_distance_that_a_driver_would_keep() -> None:
    """Half a metre to one metre, neither along the wall of the road nor along the car."""
    on = road()
    egos = [now.ego for now in driven(scene(on, tracks(on, (30.0, 0.6, 0.0, 0.0, *CAR))), planner(), 60)]
    assert 0.35 < min(0.6 - ego.d_m - 1.9 for ego in egos if abs(ego.s_m - 30.0) < 4.5) < 1.0


def test_it_stops_before_a_blocked_road() -> None:
    on = road()
    wall = tracks(on, *((16.0, d, 0.0, 0.0, *CAR) for d in (-LANE_M, 0.0, LANE_M, -1.7, 1.7)))
    motion = planned(on, wall)
    assert driven_m(motion, 5.0) < 16.0 - 2.25 - 2.25 - 0.3


def test_it_lets_a_pedestrian_cross() -> None:
    """Who drives on meets the pedestrian at s = 14: the road is as wide as the lane, so only time is left."""
    on = road()
    narrow = replace(on, **{name: getattr(on, name) / 3.0 for name in ("left_m", "right_m", "own_left_m")})
    motion = planned(narrow, tracks(narrow, (14.0, -2.4, pi / 2.0, 1.2, 0.5, 0.5)))
    crossed_s = (2.4 + 0.95 + 0.25) / 1.2
    assert driven_m(motion, crossed_s) < 14.0 - 2.25 - 0.25


def test_it_does_not_change_into_a_lane_in_which_somebody_comes_from_behind() -> None:
    on = road()
    beside = ((6.0, d, 0.0, 0.0, *CAR) for d in (0.0, LANE_M))  # parked before the car and on its right
    fast = (-14.0, -LANE_M, 0.0, 12.0, *CAR)
    motion = planned(on, tracks(on, *((s + 9.0, d, *rest) for s, d, *rest in beside), fast), speed_mps=4.0)
    assert motion.path_at(motion.s_at(2.0))[0] > -LANE_M + 1.9, "it is overtaken from 1.2 to 2.3 s"


def test_it_keeps_out_of_oncoming_lanes() -> None:
    """It passes a parked car on the narrower side."""
    on = road(oncoming_lanes=1)
    motion = planned(on, tracks(on, (18.0, 0.6, 0.0, 0.0, *CAR)))
    assert motion.path_at(18.0)[0] > 0.6 + 1.9


def test_a_bend_is_driven_within_the_lateral_limit() -> None:
    """A car that is asked to drive at 14 m/s, which would be 16 m/s^2."""
    on = road(1.0 / 12.0)
    motion = planner().plan(scene(on, tracks(on), reference_mps=14.0))
    lateral_mps2 = motion.speed_at(5.0) ** 2 / (12.0 - motion.path.end_m[0])
    assert lateral_mps2 < 1.05 * settings.load().limits.lateral_mps2


def test_a_car_that_stopped_in_a_swerve_drives_on_beside_the_edge() -> None:
    """Its last path leads on towards the edge, but a car that stands may turn its wheels."""
    on, plans, d_m = road(), planner(), EDGE_M - 1.1
    first = plans.plan(scene(on, tracks(on), 0.0, d_m, 0.0))
    swerve = Paths(np.array([-3.0]), np.array([6.0]), np.array([[d_m - 0.5, 0.0, 2.0, 0.0, 0.0, 0.0]]))
    stands = Profiles(*np.zeros((3, 1, len(first.times_s))))
    plans.motion = replace(first, path=swerve, profile=stands)
    assert plans.plan(scene(on, tracks(on), 0.0, d_m, 0.0)).speed_at(4.0) > 3.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("speed_mps", [0.0, 0.5, 1.0])
def test_it_keeps_to_the_side_of_its_last_plan_where_both_are_alike(side: float, speed_mps: float) -> None:
    """A parked car in the middle is measured some centimetres farther left, then farther right."""
    on, plans = road(), planner()
    for error_m in (0.05, -0.05, -0.05):
        motion = plans.plan(scene(on, tracks(on, (12.0, side * error_m, 0.0, 0.0, *CAR)), speed_mps=speed_mps))
        assert np.sign(motion.path.end_m[0]) == -side


def test_the_next_plan_goes_on_from_the_last() -> None:
    on, plans = road(), planner()
    seen = tracks(on, (18.0, 0.6, 0.0, 0.0, *CAR))
    first = plans.plan(scene(on, seen))
    rear_m = 1.0 - VehicleModel().l_r_m
    d_m, slope, _ = first.path_at(rear_m)
    second = plans.plan(scene(on, seen, 1.0, d_m + 0.05, 5.4))
    assert (second.start.d_m, second.start.slope) == pytest.approx((d_m, slope))
    assert second.path.end_m[0] == pytest.approx(first.path.end_m[0], abs=0.6)


def test_a_centimetre_that_is_lacking_beside_an_obstacle_costs_little() -> None:
    """0.2 m are wanted. Were the cost to jump there, plans would end at each change of an obstacle's seen width."""
    on = road()
    enough, lacking = (
        planned(on, tracks(on, (0.5, 1.9 + room_m, 0.0, 0.0, *CAR)), speed_mps=0.0).cost for room_m in (0.205, 0.195)
    )
    assert enough < lacking < 1.3 * enough


@pytest.mark.parametrize("speed_mps", [0.0, 2.0, 4.0, 6.0])
@pytest.mark.parametrize("reference_mps", [5.5, 14.0, 30.0])
def test_a_slow_car_turns_its_wheels_in_time_whatever_its_reference_speed(
    speed_mps: float, reference_mps: float
) -> None:
    """The curvature of the chosen path on a straight road, y'' / (1 + y'^2)^1.5."""
    on, limit = road(), settings.load().limits
    for ahead_m in (6.0, 9.0, 14.0, 20.0):
        seen = tracks(on, (ahead_m, 0.4, 0.0, 0.0, *CAR))
        motion = planner().plan(scene(on, seen, speed_mps=speed_mps, reference_mps=reference_mps))
        times_s = np.arange(0.0, 5.01, 0.2)
        _, slope, second = motion.path.at(np.array([motion.s_at(time_s) for time_s in times_s.tolist()])[None])
        curvature = second[0] / (1.0 + slope[0] ** 2) ** 1.5
        if not motion.is_rejected:
            assert np.abs(curvature).max() < 1.02 * limit.curvature_per_m
            assert np.abs(np.diff(curvature)).max() / 0.2 < 1.15 * limit.curvature_rate_per_ms  # still below REJECTED
