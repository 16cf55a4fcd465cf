"""Collisions classified, by table and on the road."""

from math import pi, radians

import pytest

from vpf_sim.evaluation.metrics import collision
from vpf_sim.evaluation.metrics.collision import collision_type, is_at_fault
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.truth import surroundings


def ended(
    speed_mps: float, other_mps: float, bearing_deg: float = 5.0, bumper_m: float = 0.0, in_lane: bool = True
) -> StepTable:
    """Two rows, the second with a contact."""
    near = {"near_bearing_rad": radians(bearing_deg), "near_bumper_m": bumper_m, "near_speed_mps": other_mps}
    return StepTable.of(
        [Step(t, 0.0, 0.0, 0.0, speed_mps, 0.0, 0.0, 0.0, 0.0, in_lane=float(in_lane), **near) for t in (1.0, 1.1)]
    )


@pytest.mark.parametrize(
    ("table", "kind", "at_fault"),
    [
        (ended(0.05, 3.0), "stopped_ego", False),
        (ended(0.0, 0.0, in_lane=False), "stopped_ego", False),
        (ended(0.06, 0.0), "stopped_track", True),
        (ended(5.0, 0.05, bearing_deg=160.0), "stopped_track", True),
        (ended(5.0, 6.0, bearing_deg=151.0), "active_rear", False),
        (ended(5.0, 6.0, bearing_deg=-151.0, in_lane=False), "active_rear", False),
        (ended(5.0, 3.0), "active_front", True),
        (ended(5.0, 3.0, bumper_m=0.8), "active_front", True),
        (ended(5.0, 3.0, bearing_deg=149.0, bumper_m=0.82), "active_lateral", False),
        (ended(5.0, 3.0, bearing_deg=90.0, bumper_m=2.0), "active_lateral", False),
        (ended(5.0, 3.0, bearing_deg=90.0, bumper_m=2.0, in_lane=False), "active_lateral", True),
    ],
)
def test_each_collision_type_and_its_fault(table: StepTable, kind: str, at_fault: bool) -> None:
    assert collision_type(table) == kind
    assert is_at_fault(kind, table) is at_fault


def test_the_angles_are_nuplans() -> None:
    assert pi / 6.0 == pytest.approx(surroundings.AHEAD_RAD)
    assert 5.0 * pi / 6.0 == pytest.approx(surroundings.BEHIND_RAD)
    assert surroundings.BEHIND_RAD == collision.BEHIND_RAD
