"""Paired comparisons: which cells, which seeds, which sign."""

from typing import Any

import numpy as np
import pytest

from vpf_sim.evaluation.analysis.comparisons import compare
from vpf_sim.evaluation.analysis.statistics import paired_difference, paired_shares
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, unscored
from vpf_sim.evaluation.sweeps.plan import Plan

WEATHERS, DRIVERS = ("clear", "rain"), ("pid", "vpf")


def record(status: str, mse: float | None, score: float = 1.0) -> Record:
    """A record of any episode, whose names do not matter."""
    scores = {
        "path_mse_m2": mse,
        **dict.fromkeys(("route_completion", "driving_score_2_0", "driving_score_2_1"), score),
    }
    accuracy = {"accuracy.shadow.throttle.range": 0.8, "accuracy.shadow.steering.range": None}
    return unscored(Job("a", "rain", "pid", 0), status).model_copy(update={"scores": {**scores, **accuracy}})


def compared(records: dict[str, Record], weathers: Any = WEATHERS, drivers: Any = DRIVERS) -> dict[str, Any]:
    """Comparisons of a grid of 5 seeds by "weather driver - other"."""
    found = compare(Plan(("a",), weathers, drivers, "0:5").jobs(), records)
    return {f"{one.cell.weather} {one.cell.driver} - {one.minus}": one.as_json() for one in found}


def test_rain_is_compared_with_clear_and_drivers_with_the_pid() -> None:
    assert [*compared({})] == ["clear vpf - pid", "rain pid - clear", "rain vpf - clear", "rain vpf - pid"]
    assert {row["of"] for name, row in compared({}).items() if name.endswith("clear")} == {"weather"}


def test_drivers_are_compared_with_each_other_in_their_order() -> None:
    names = [*compared({}, ("fog",), ("pid", "b", "a"))]
    assert sorted(names) == ["fog a - pid", "fog b - a", "fog b - pid"]


def test_without_clear_weather_the_first_is_the_reference() -> None:
    assert [*compared({}, ("fog", "dusk", "snow"), ("pid",))] == ["dusk pid - fog", "snow pid - fog"]


def test_scores_are_compared_where_both_succeeded_and_success_where_both_were_planned() -> None:
    rain, clear = [1.5, 1.25, 1.5, 9.0], [1.0, 1.0, 0.5, 0.0]
    statuses = ["success", "success", "success", "collision"]
    records = {f"a.rain.pid.{seed}": record(statuses[seed], rain[seed], 0.5) for seed in range(4)}
    records |= {f"a.clear.pid.{seed}": record("success", clear[seed]) for seed in range(4)}
    row = compared(records, drivers=("pid",))["rain pid - clear"]
    mse = paired_difference(np.array(rain[:3]), np.array(clear[:3]))
    assert mse is not None
    assert mse.interval is not None
    assert row["path_mse_m2"] == {
        "difference": pytest.approx(1.75 / 3.0),
        "interval": list(mse.interval),
        "p": 0.25,
        "pairs": 3,
    }
    success = paired_shares(np.array([True] * 3 + [False] * 2), np.array([True] * 4 + [False]))
    assert success.interval is not None
    assert row["success_rate"] == {**success._asdict(), "interval": list(success.interval)}
    assert row["success_rate"]["difference"] == pytest.approx(-0.2), "of five planned"
    assert (row["driving_score_2_1"]["difference"], row["driving_score_2_1"]["pairs"]) == (-0.5, 4)
    assert row["min_clearance_m"] is None
    assert row["accuracy.shadow.throttle.range"]["difference"] == 0.0
    assert row["accuracy.shadow.steering.range"] is None


def test_a_run_without_records_has_no_differences() -> None:
    row = compared({})["rain vpf - pid"]
    assert row["path_mse_m2"] is None
    assert row["success_rate"]["difference"] == 0.0
    assert row["success_rate"]["pairs"] == 5
