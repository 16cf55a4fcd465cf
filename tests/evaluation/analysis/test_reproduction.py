"""The paper's table, definitions and claims on synthetic drives whose values follow by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vpf_sim.evaluation.analysis import paper_claims, reproduction
from vpf_sim.evaluation.analysis.reproduction import CELLS, Drive
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import unscored
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.types import Floats

RATE_HZ = 60.0
ERRORS_M2 = dict(zip(CELLS, (0.3, 0.6, 0.4, 0.9), strict=True))


def table(steering: Floats, pid: Floats, yaw_rate: Floats | float = 0.0, beside_m: float = 0.0) -> StepTable:
    """A straight drive along x, `beside_m` to the right of y = 0, at 5 m/s."""
    n = len(steering)
    time = np.arange(n + 1) / RATE_HZ
    empty = {name: np.zeros(n + 1) for name in Step._fields}
    columns = empty | {
        "time_s": time,
        "x_m": 5.0 * time,
        "y_m": np.full(n + 1, beside_m),
        "speed_mps": np.full(n + 1, 5.0),
        "yaw_rate_radps": np.broadcast_to(yaw_rate, n + 1),
        "route_m": 5.0 * time,
        "in_lane": np.ones(n + 1),
        "steering": np.append(steering, np.nan),
        "pid_steering": np.append(pid, np.nan),
        "paired_steering": np.append(pid, np.nan),
    }
    return StepTable(np.column_stack([columns[name] for name in Step._fields]))


def drive(cell: tuple[str, str], good: bool = True, **more: Any) -> Drive:
    own = more.pop("table", table(np.zeros(120), np.zeros(120)))
    scores = {"path_mse_m2": ERRORS_M2[cell], "min_clearance_m": 0.4, **more}
    record = unscored(Job(*cell, "vpf-paper", 0), "success" if good else "collision")
    return Drive(*cell, record.model_copy(update={"scores": scores}), own, own)


def test_accuracies_of_a_constant_difference() -> None:
    pid = np.tile([0.5, -0.5], 60)
    found = reproduction.accuracies(table(pid + 0.2, pid), "steering", "shadow")
    assert found["range"] == pytest.approx(0.9)
    assert found["difference"] == pytest.approx(0.8)
    assert found["rms"] == pytest.approx(0.8)
    assert found["span"] == pytest.approx(0.8)
    assert (found["tolerance"], found["sign"]) == (0.0, 1.0)
    assert found["correlation"] == pytest.approx(1.0)


def test_equal_commands_score_one_and_opposite_commands_share_no_sign() -> None:
    pid = np.tile([0.5, -0.5], 60)
    assert all(
        value == pytest.approx(1.0) for value in reproduction.accuracies(table(pid, pid), "steering", "paired").values()
    )
    assert reproduction.accuracies(table(-pid, pid), "steering", "shadow")["sign"] == 0.0


def test_span_has_no_value_where_the_pid_never_moved() -> None:
    found = reproduction.accuracies(table(np.full(120, 0.2), np.full(120, 0.5)), "steering", "shadow")
    assert found["span"] is None
    assert found["range"] == pytest.approx(0.85)
    still = drive(CELLS[0], table=table(np.full(120, 0.2), np.full(120, 0.5)))
    rows = reproduction.cells([replace(still, scenario=scenario, weather=weather) for scenario, weather in CELLS])
    (row,) = [row for row in reproduction.definitions(rows) if (row.protocol, row.definition) == ("shadow", "span")]
    assert row.steering == reproduction.AgainstPrint([None] * 4, None, None)


def test_path_errors_against_the_pid_by_nearest_point_and_by_time() -> None:
    own = drive(CELLS[0], table=table(np.zeros(120), np.zeros(120), beside_m=2.0))
    late = table(np.zeros(120), np.zeros(120))
    rows = late.rows.copy()
    rows[:, Step._fields.index("x_m")] -= 1.0  # the PID's car is 1 m behind
    errors = reproduction.path_errors(replace(own, pid=StepTable(rows)))
    assert errors["lane centre"] == ERRORS_M2[CELLS[0]]
    assert errors["PID at the same time"] == pytest.approx(5.0)
    assert errors["PID's path"] == pytest.approx(4.0, abs=0.1)


def test_jerkiness_is_the_yaw_acceleration_without_the_relays_ripple() -> None:
    n, rising = 240, np.linspace(0.0, 0.4, 241)  # 0.1 rad/s2 over 4 s
    ripple = 0.05 * (-1.0) ** np.arange(n + 1)
    calm, restless = (
        reproduction.jerkiness(table(np.zeros(n), np.zeros(n), rate)) for rate in (rising, rising + ripple)
    )
    assert calm == pytest.approx(0.1, rel=0.01)
    assert restless == pytest.approx(calm, rel=0.05)


def claims_hold(drives: list[Drive]) -> dict[str, bool | None]:
    rows = reproduction.cells(drives)
    return {one.claim: one.holds for one in paper_claims.claims(rows, drives, 5.0)}


def test_claims_hold_by_what_was_measured() -> None:
    holds = claims_hold([drive(cell) for cell in CELLS])
    assert holds["The vehicle reaches its destination in all four conditions (here: in nine drives of ten)."]
    assert holds["The mean squared error of the path is below 1 on average."]
    assert holds["The error grows with obstacles and in rain."] is False, "0.6 m2 is not below 0.4 m2"
    assert holds["Its path is jerkier in rain."] is False, "all are the same"
    assert holds["It takes less computation than learning."] is None


def test_jerkier_drives_with_obstacles_and_in_rain_confirm_the_claims() -> None:
    def turning(size: float) -> StepTable:
        return table(np.zeros(240), np.zeros(240), size * np.sin(np.arange(241) / 30.0))

    sizes = dict(zip(CELLS, (0.1, 0.2, 0.2, 0.4), strict=True))
    holds = claims_hold([drive(cell, table=turning(size)) for cell, size in sizes.items()])
    assert holds["Its path is jerkier with obstacles."]
    assert holds["Its path is jerkier in rain."]


def test_a_cell_without_success_refutes_reaching_the_goal_and_leaves_other_claims_undecided() -> None:
    holds = claims_hold([drive(cell, good=cell != CELLS[-1]) for cell in CELLS])
    assert holds["The vehicle reaches its destination in all four conditions (here: in nine drives of ten)."] is False
    assert holds["The error grows with obstacles and in rain."] is None
    assert holds["The accuracies fall in the order of the table."] is None


def test_the_claim_names_definitions_whose_order_matches_the_paper() -> None:
    """Steering and throttle that differ from the PID as the paper's accuracies do, by 1 - mean |d|."""
    drives = []
    for cell in CELLS:
        paper = reproduction.PAPER[cell]
        one = table(np.full(120, 1.0 - paper["steering"]), np.zeros(120))
        columns = {"throttle": np.full(121, 1.0 - paper["throttle"]), "pid_throttle": np.zeros(121)}
        drives.append(drive(cell, table=one.replaced(columns)))
    rows = reproduction.cells(drives)
    (shadow,) = [
        row for row in reproduction.definitions(rows) if (row.protocol, row.definition) == ("shadow", "difference")
    ]
    for signal in (shadow.throttle, shadow.steering):
        assert signal.off == pytest.approx(0.0, abs=1e-9)
        assert signal.same_order
    assert claims_hold(drives)["The accuracies fall in the order of the table."]
