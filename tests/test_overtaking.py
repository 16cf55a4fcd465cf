"""Where the field leads past bodies that move: when they count, on which side, and how near."""

from dataclasses import replace

import numpy as np
import pytest

from vpf_sim.planning import variant
from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.planning.lane_field import LaneField
from vpf_sim.planning.reach import Reach
from vpf_sim.types import VehicleModel

ROBUST = variant.load("robust").valley
assert ROBUST is not None
CAR, SPEED_MPS = VehicleModel(), 5.55
LANE = Lane(0.0, 5.25, -8.75, 0.0, 0.0)


def field() -> LaneField:
    return LaneField(ROBUST.field, CAR, SPEED_MPS, Reach(ROBUST.reach, CAR))


def obstacle(along_m: float, y_m: float, speed_mps: float) -> LaneObstacles:
    return LaneObstacles(*(np.array([value]) for value in (along_m, y_m - 0.9, y_m + 0.9, speed_mps)))


def together(*bodies: LaneObstacles) -> LaneObstacles:
    return LaneObstacles(*(np.concatenate([getattr(one, n) for one in bodies]) for n in LaneObstacles.__slots__))


def test_straight_behind_a_body_that_moves_no_side_is_decided_yet() -> None:
    """It is told late, a hand's breadth to the left of our middle, where another leaves no room to its right."""
    bumper_m = 0.5 * CAR.length_m
    lead, right = obstacle(bumper_m + 6.8, -0.15, 3.1), obstacle(bumper_m + 2.0, 3.2, 3.9)
    watch = field()
    watch._last_m = 0.0
    assert watch.update(LANE, together(lead, right)).minimum_m < -2.0
    watch._last_m = 1.0
    beside = replace(LANE, y_m=1.0)
    assert watch.update(beside, together(lead, right)).minimum_m > 0.5


def test_what_is_met_later_does_not_push_the_path_to_what_is_being_passed() -> None:
    """A car beside us on the left; one almost as fast far ahead to the right, so that both cannot be kept clear of."""
    beside, far = obstacle(1.0, -1.0, 3.0), obstacle(17.0, 2.6, 4.2)
    wanted = field().update(replace(LANE, y_m=1.6), beside).minimum_m
    watch = field()
    watch._last_m = 1.6
    assert watch.update(replace(LANE, y_m=1.6), together(beside, far)).minimum_m == pytest.approx(wanted, abs=0.1)


def test_a_path_is_not_brought_nearer_to_a_body_that_is_being_passed_than_is_wanted() -> None:
    passed = obstacle(2.0, -1.0, 3.0)
    clear = -0.1 + 0.5 * CAR.width_m + ROBUST.field.clearance_m
    assert field().kept_beside(passed, 2.0, 0.3) == pytest.approx(clear)
    assert field().kept_beside(passed, 2.0, 1.8) == 1.8
    assert field().kept_beside(passed, 1.2, 0.3) == 1.2
    assert field().kept_beside(obstacle(9.0, -1.0, 3.0), 2.0, 0.3) == 0.3
    mirrored = obstacle(2.0, 1.0, 3.0)
    assert field().kept_beside(mirrored, -2.0, -0.3) == pytest.approx(-clear)
