"""The chosen motion as it is drawn and recorded."""

import numpy as np
import pytest
from made_scene import LANE_M, planner, road, scene, tracks

from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.types import VehicleModel


def plan_of(curvature_per_m: float, d_m: float, *objects: tuple[float, ...]) -> MotionPlan:
    on = road(curvature_per_m)
    made = scene(on, tracks(on, *objects), 10.0, d_m)
    pose = np.array([made.ego.x_m, made.ego.y_m, made.ego.yaw_rad])
    return MotionPlan(planner().plan(made), on, VehicleModel(), pose)


@pytest.mark.parametrize("curvature_per_m", [0.0, 1.0 / 40.0, -1.0 / 40.0])
def test_its_places_are_in_vehicle_axes(curvature_per_m: float) -> None:
    """On a free road the car keeps its lane: its rear axle drives an arc that begins in the car's direction."""
    forward, right = plan_of(curvature_per_m, 0.0).points_m().T
    assert (forward[0], right[0]) == pytest.approx((0.0, 0.0), abs=1e-3)
    driven_m = np.cumsum(np.hypot(np.diff(forward), np.diff(right)))
    from_rear_m = forward[1:6] + VehicleModel().l_r_m
    expected = 0.5 * curvature_per_m * (from_rear_m**2 - VehicleModel().l_r_m ** 2)
    np.testing.assert_allclose(right[1:6], expected, atol=0.02)
    assert driven_m[-1] == pytest.approx(5.0 * 5.5, abs=0.3)


@pytest.mark.parametrize("d_m", [-LANE_M, LANE_M])
def test_a_car_beside_its_route_comes_back_where_that_is_free(d_m: float) -> None:
    assert plan_of(0.0, d_m).shift_m == pytest.approx(-d_m, abs=0.1)
    beside_m, _, _ = plan_of(0.0, d_m, (18.0, 0.0, 0.0, 0.0, 4.5, 1.9)).motion.path_at(18.0)
    assert abs(beside_m) > 1.9 + 0.2, "a car stands there"


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_its_shift_is_to_the_side_on_which_it_passes(side: float) -> None:
    plan = plan_of(0.0, 0.0, (28.0, -0.6 * side, 0.0, 0.0, 4.5, 1.9))
    assert np.sign(plan.shift_m) == side
    assert plan.points_m()[-1, 1] == pytest.approx(plan.shift_m, abs=0.01)


def test_candidates_are_rejected_for_what_they_break() -> None:
    free = plan_of(0.0, 0.0).motion.rejected
    wall = plan_of(0.0, 0.0, *((24.0, d, 0.0, 0.0, 4.5, 3.4) for d in (-LANE_M, 0.0, LANE_M))).motion.rejected
    assert free.collision == 0 < wall.collision
    bend = plan_of(1.0 / 12.0, 0.0).motion.rejected
    assert bend.lateral_acceleration / sum(bend) > free.lateral_acceleration / sum(free)
