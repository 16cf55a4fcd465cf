"""Why episodes failed: synthetic records of known causes."""

from collections.abc import Callable

import numpy as np
import pytest

from vpf_sim.evaluation.metrics.failure import Failure, failure_of
from vpf_sim.evaluation.steps import Outcome, Step, StepTable
from vpf_sim.types import Floats

RATE_HZ, DRIVEN_S, SPEED_MPS = 10.0, 8.0, 5.5
N = round(RATE_HZ * DRIVEN_S) + 1
TIME_S = np.arange(N) / RATE_HZ
Change = dict[str, Floats | float]
TO_GO_M = SPEED_MPS * (TIME_S[-1] - TIME_S)  # until the end
STOPPED = np.where(TIME_S < 2.0, SPEED_MPS, 0.0)


def drive(**columns: Floats | float) -> StepTable:
    """A drive at a steady speed onto a standing object that is perceived in time, in place, and driven at."""
    steps = [
        Step(
            time, SPEED_MPS * time, 0.0, 0.0, SPEED_MPS, 0.0, SPEED_MPS * time, 0.0, to_go, throttle=0.1, steering=0.0,
            objects_right=1.0, objects_wrong=0.0, seen_left_m=-5.0, seen_right_m=5.0, true_left_m=-5.0,
            true_right_m=5.0, near_bearing_rad=0.0, near_bumper_m=to_go, near_speed_mps=0.0, near_confirmed_m=20.0,
            near_sticks_out_m=0.0, reference_mps=SPEED_MPS, heading_error_rad=0.0,
        )
        for time, to_go in zip(TIME_S.tolist(), TO_GO_M.tolist(), strict=True)
    ]  # fmt: skip
    table = StepTable.of(steps)
    table = table.replaced({name: np.broadcast_to(np.asarray(values, float), (N,)) for name, values in columns.items()})
    return table.replaced({name: np.append(getattr(table, name)[:-1], np.nan) for name in OF_A_COMMAND})


def classed(status: str, **columns: Floats | float) -> Failure | None:
    return failure_of(Outcome(status, drive(**columns), "car" if status == "collision" else None, None))


OF_A_COMMAND = (  # the last row has none, nor a perception
    *("throttle", "steering", "objects_right", "objects_wrong", "seen_left_m", "seen_right_m", "wrong_ahead_m"),
    *("near_confirmed_m", "near_sticks_out_m", "reference_mps", "heading_error_rad"),
)
UNPERCEIVED: Change = dict.fromkeys(
    ("objects_right", "objects_wrong", "seen_left_m", "seen_right_m", "near_confirmed_m", "near_sticks_out_m"), np.nan
)


def late_edges(wrong_s: float, unseen_s: float) -> Change:
    """Edges that are wrong when the last two seconds begin, then not seen, then right."""
    into_s = TIME_S - (DRIVEN_S - 2.0) + 0.01
    stages = [into_s < wrong_s, into_s < wrong_s + unseen_s]
    return {
        "seen_left_m": np.select(stages, [-3.8, np.nan], -5.0),
        "seen_right_m": np.select(stages, [6.2, np.nan], 5.0),
    }


UNPLANNED: Change = {"reference_mps": np.nan, "heading_error_rad": np.nan}
STANDING: Change = {"speed_mps": STOPPED, "reference_mps": 0.0, "free_m": np.where(STOPPED > 0.0, np.nan, 6.0)}


@pytest.mark.parametrize(
    ("failure", "change"),
    [
        ("planning", {}),
        ("missed", {"near_confirmed_m": np.nan, "near_sticks_out_m": np.nan}),
        ("missed", {"near_sticks_out_m": np.nan}),  # lost again
        ("planning", {"near_confirmed_m": np.nan, "near_sticks_out_m": np.nan, "near_bearing_rad": -1.2}),  # beside it
        ("planning", {"near_sticks_out_m": np.nan, "near_bearing_rad": 0.9}),  # passed, and turned into
        ("missed", {"near_confirmed_m": np.nan, "near_bearing_rad": np.where(TO_GO_M < 5.0, 0.9, 0.6)}),
        ("planning", {"near_confirmed_m": np.nan, "near_bearing_rad": np.where(TO_GO_M < 3.0, -0.6, -1.5)}),
        ("late", {"near_confirmed_m": np.where(TO_GO_M < 3.0, 3.0, np.nan)}),
        ("planning", {"near_confirmed_m": np.where(TO_GO_M < 6.0, 6.0, np.nan)}),  # 4.2 m are needed
        ("misplaced", {"near_sticks_out_m": 0.6}),
        ("planning", {"near_sticks_out_m": 0.2}),
        ("control", {"heading_error_rad": -0.3}),
        ("control", {"reference_mps": 2.0, "throttle": 0.0}),
        ("planning", {"reference_mps": 2.0, "throttle": -1.0}),  # it brakes: the plan came too late
        ("hit", {"speed_mps": np.where(TIME_S < 7.9, SPEED_MPS, 0.0), "near_speed_mps": 4.0}),
        ("hit", {"near_bearing_rad": np.pi, "near_speed_mps": 8.0}),
        ("false", {"near_bearing_rad": np.pi, "near_speed_mps": 8.0, "wrong_ahead_m": 6.0}),
        ("hit", {"near_bearing_rad": np.pi, "near_speed_mps": 8.0, "wrong_ahead_m": 40.0}),
        ("planning", UNPERCEIVED),  # of a driver that is given the world
        ("control", {**UNPERCEIVED, "heading_error_rad": 0.3}),
        (None, {**UNPERCEIVED, **UNPLANNED}),
    ],
)
def test_collisions(failure: Failure | None, change: Change) -> None:
    assert classed("collision", **change) == failure


@pytest.mark.parametrize(
    ("failure", "change"),
    [
        ("planning", {}),
        ("missed", {"seen_left_m": np.nan, "seen_right_m": np.nan}),
        ("misplaced", {"seen_right_m": 6.2}),
        ("planning", {"seen_right_m": 5.3}),
        ("control", {"heading_error_rad": 0.4}),
        ("planning", {"seen_right_m": np.where(TIME_S < 5.0, 6.2, 5.0)}),  # long before
        ("misplaced", late_edges(wrong_s=0.6, unseen_s=0.5)),
        ("missed", late_edges(wrong_s=0.5, unseen_s=0.6)),
        ("planning", late_edges(wrong_s=0.4, unseen_s=0.5)),
        (None, {**UNPERCEIVED, **UNPLANNED}),
    ],
)
def test_leaving_the_road(failure: Failure | None, change: Change) -> None:
    assert classed("off_road", **change) == failure


@pytest.mark.parametrize("status", ["stuck", "timeout"])
@pytest.mark.parametrize(
    ("failure", "change"),
    [
        ("planning", {}),
        ("blocked", {"free_m": np.where(STOPPED > 0.0, np.nan, 2.0)}),
        ("false", {"wrong_ahead_m": np.where(STOPPED > 0.0, np.nan, 4.0)}),
        ("planning", {"wrong_ahead_m": np.where(TIME_S < 3.0, 4.0, np.nan)}),
        ("missed", {"seen_left_m": np.nan, "seen_right_m": np.nan}),
        ("control", {"reference_mps": 3.0}),
        ("blocked", {**UNPERCEIVED, **UNPLANNED, "free_m": np.where(STOPPED > 0.0, np.nan, 1.0)}),
        (None, {**UNPERCEIVED, **UNPLANNED}),
    ],
)
def test_standing(status: str, failure: Failure | None, change: Change) -> None:
    assert classed(status, **{**STANDING, **change}) == failure


@pytest.mark.parametrize("status", ["success", "error", "invalid_frame"])
def test_others_have_no_class(status: str) -> None:
    assert classed(status) is None


@pytest.mark.parametrize("rows", [slice(0), slice(-1, None)])
def test_an_episode_without_a_command_has_no_class(rows: slice) -> None:
    assert failure_of(Outcome("stuck", StepTable(drive().rows[rows]), None, None)) is None


def test_steps_of_earlier_versions_tell_what_they_can() -> None:
    """Without the later columns, of a driver that perceives."""
    later: dict[str, Callable[[], float] | float] = dict.fromkeys(
        ("near_confirmed_m", "near_sticks_out_m", "wrong_ahead_m", "free_m", "reference_mps", "heading_error_rad"),
        np.nan,
    )
    assert classed("off_road", **{**later, "seen_right_m": 6.2}) == "misplaced"  # type: ignore[arg-type]
