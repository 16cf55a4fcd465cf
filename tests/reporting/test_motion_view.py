"""The motion of a planner in space and time, drawn into a frame of a driver without perception."""

import numpy as np
import pytest
from made_scene import LANE_M, road, scene, tracks

from vpf_sim.geometry import project
from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.planning.spacetime.planner import SpacetimePlanner
from vpf_sim.reporting import overlay
from vpf_sim.reporting.plan_view import reasons
from vpf_sim.types import Camera, Force, Plan, Reference, VehicleModel

GREY = 90


def plan_of(*objects: tuple[float, ...]) -> Plan:
    on = road()
    made = scene(on, tracks(on, *objects))
    motion = SpacetimePlanner(settings.load(), VehicleModel()).plan(made)
    return Plan(
        None, Force(*np.zeros((4, 2))), Reference(0.0, 5.5), MotionPlan(motion, on, VehicleModel(), np.zeros(3))
    )


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_way_is_drawn_where_it_leads(side: float) -> None:
    """Past a parked car in the middle of the road, which is nearer to one side."""
    camera = Camera()
    frame = np.full((camera.height_px, camera.width_px, 3), GREY, np.uint8)
    plan = plan_of((22.0, -0.6 * side, 0.0, 0.0, 4.5, 1.9))
    assert isinstance(plan.extra, MotionPlan)
    beside_m = plan.extra.motion.path_at(18.0)[0]
    assert np.sign(beside_m) == side
    change = overlay.draw(frame, plan, camera).astype(int) - GREY
    x, y = (round(value) for value in project(camera, np.array([18.0, beside_m, 0.0])))
    other, _ = (round(value) for value in project(camera, np.array([18.0, -beside_m, 0.0])))
    assert change[y, x, 1] > 10
    assert not change[y, other].any()


def test_the_reasons_are_named_most_first() -> None:
    """Of cars that drive at a walking pace: motions towards what stands are not compared so far."""
    plan = plan_of(*((14.0, d, 0.0, 0.5, 4.5, 3.4) for d in (-LANE_M, 0.0, LANE_M))).extra
    assert isinstance(plan, MotionPlan)
    counts = plan.motion.rejected._asdict()
    words = reasons(plan)
    assert words[0] == f"collision {max(counts.values())}"
    numbers = [int(word.split()[-1]) for word in words]
    assert numbers == sorted(numbers, reverse=True)
    assert len(words) == sum(count > 0 for count in counts.values())
