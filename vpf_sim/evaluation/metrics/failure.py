"""Why an episode failed, derived from its stored steps and the truth in them.

The first that applies:

    hit         another vehicle caused the collision, as nuPlan sees it
    blocked     the car stood, or crept, where nothing as wide as the car was free across the road
    false       perception: it stood, or was hit, because of a reported obstacle that is not there
    missed      perception: the obstacle that it hit was ahead and not reported, or the road that it left not seen
    late        perception: the obstacle was reported when the car could no longer stop before it
    misplaced   perception: the obstacle stuck out of what was reported, or the road's edges lay elsewhere
    control     the car was off the heading or above the speed of its plan
    planning    anything else: what mattered was perceived in time and in place, or given

None: the episode succeeded, ended by an error or an invalid frame, or its driver shows neither perception nor plan.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vpf_sim.evaluation.metrics.collision import collision_type, is_at_fault
from vpf_sim.evaluation.steps import Outcome, StepTable
from vpf_sim.types import Bools, Floats

Failure = Literal["hit", "blocked", "false", "missed", "late", "misplaced", "control", "planning"]
PERCEPTION: tuple[Failure, ...] = ("false", "missed", "late", "misplaced")

BEFORE_S = 2.0  # of a collision or of leaving the road: what was perceived then counts
STANDING_S, STANDING_MPS = 6.0, 0.5  # of the end of a drive that got stuck
BRAKING_MPS2, REACTION_S = 6.0, 0.3  # of a stop before what was reported
SIGHT_RAD = 0.25 * np.pi  # off the heading: what is farther to a side, no forward camera sees
STICKS_OUT_M = 0.4
EDGE_M = 0.5
WRONG_M = 15.0  # a false obstacle that is nearer stops the car
CAR_M = 2.3  # its width, and 0.2 m on either side
OFF_RAD, OVER_MPS = 0.15, 1.5  # deviations from the plan
MOST = 0.5  # share of the frames in which something must hold


@dataclass(frozen=True, slots=True)
class _Frames:
    """Some rows of the step table."""

    table: StepTable
    rows: Bools  # (n + 1,)

    def of(self, name: str) -> Floats:
        column: Floats = getattr(self.table, name)[self.rows]
        return column

    def mostly(self, holds: Bools) -> bool:
        """Whether something holds in most of the frames."""
        return len(holds) > 0 and float(np.mean(holds)) > MOST


def failure_of(outcome: Outcome) -> Failure | None:
    """The class of an episode's failure."""
    table = outcome.steps
    if outcome.status not in ("collision", "off_road", "stuck", "timeout") or not np.isfinite(table.throttle).any():
        return None
    perceives, plans = bool(np.isfinite(table.objects_right).any()), bool(np.isfinite(table.reference_mps).any())
    if outcome.status == "collision":
        frames = _last(table, BEFORE_S)
        found = _of_collision(frames, perceives)
    elif outcome.status == "off_road":
        frames = _last(table, BEFORE_S)
        found = _of_leaving(frames) if perceives else None
    else:
        frames = _last(table, STANDING_S)
        found = _of_standing(frames, perceives)
    if found is not None or not (perceives or plans):
        return found
    return "control" if _deviates(frames) else "planning"


def _last(table: StepTable, seconds: float) -> _Frames:
    """The frames of the end of a drive that have a command."""
    return _Frames(table, (table.time_s >= table.time_s[-1] - seconds) & np.isfinite(table.throttle))


def _of_collision(frames: _Frames, perceives: bool) -> Failure | None:
    if not is_at_fault(collision_type(frames.table), frames.table):
        return "false" if perceives and _brakes_for_nothing(frames) else "hit"
    if not perceives:
        return None
    table = frames.table
    unseen: Failure | None = "missed" if frames.mostly(np.abs(frames.of("near_bearing_rad")) < SIGHT_RAD) else None
    confirmed_m = float(frames.of("near_confirmed_m")[-1])
    if np.isnan(confirmed_m):
        return unseen
    first = int(np.argmax(table.near_confirmed_m == confirmed_m))
    if confirmed_m < _stopping_m(float(table.speed_mps[first])):
        return "late"
    sticks_out = frames.of("near_sticks_out_m")
    seen = sticks_out[np.isfinite(sticks_out)]
    if not len(seen):  # reported once, and lost
        return unseen
    return "misplaced" if frames.mostly(seen > STICKS_OUT_M) else None


def _of_leaving(frames: _Frames) -> Failure | None:
    errors = [frames.of(f"seen_{side}_m") - frames.of(f"true_{side}_m") for side in ("left", "right")]
    true = np.isfinite(frames.of("true_left_m")) & np.isfinite(frames.of("true_right_m"))
    if not true.any():
        return None
    worst = np.fmax(*np.abs(errors))[true]
    unseen, wrong = np.isnan(worst), worst > EDGE_M
    if not frames.mostly(unseen | wrong):
        return None
    return "missed" if unseen.sum() > wrong.sum() else "misplaced"


def _of_standing(frames: _Frames, perceives: bool) -> Failure | None:
    free = frames.of("free_m")
    if frames.mostly(free[np.isfinite(free)] < CAR_M):
        return "blocked"
    if not perceives:
        return None
    if _brakes_for_nothing(frames):
        return "false"
    unseen = np.isnan(frames.of("seen_left_m")) & np.isfinite(frames.of("true_left_m"))
    return "missed" if frames.mostly(unseen) else None


def _brakes_for_nothing(frames: _Frames) -> bool:
    return frames.mostly(frames.of("wrong_ahead_m") < WRONG_M)


def _deviates(frames: _Frames) -> bool:
    """Whether the car did not follow the plan: it held another heading, or drove faster without braking."""
    off = np.abs(frames.of("heading_error_rad")) > OFF_RAD
    moving = frames.of("speed_mps") > STANDING_MPS
    over = (frames.of("speed_mps") - frames.of("reference_mps") > OVER_MPS) & (frames.of("throttle") >= 0.0)
    held = (frames.of("reference_mps") > OVER_MPS) & ~moving
    return frames.mostly(off & moving) or frames.mostly(over) or frames.mostly(held)


def _stopping_m(speed_mps: float) -> float:
    return REACTION_S * speed_mps + 0.5 * speed_mps**2 / BRAKING_MPS2
