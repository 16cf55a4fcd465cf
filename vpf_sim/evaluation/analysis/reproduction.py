"""What the paper claims of its simulator runs, beside what a run of ours shows: its table, and claim by claim.

The paper gives no formula for its accuracy, and no reference path for its MSE beyond "the original planned trajectory".
So each is computed by several definitions, and the tables say how far each is from print.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vpf_sim.evaluation.analysis.benchmark import PAPER, SCENARIOS, WEATHERS
from vpf_sim.evaluation.metrics.path import distances
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.types import Floats

DRIVER, RIVAL, SEEDS = "vpf-paper", "pid", "0:3"
CELLS = tuple((scenario, weather) for weather in WEATHERS for scenario in SCENARIOS)  # in the paper's order
SIGNALS = ("throttle", "steering")
OFTEN = 0.9  # the share of drives that counts as reaching the goal: the paper shows one drive a condition
SMOOTHED_S = 0.5  # over which the yaw rate is averaged before it is called jerky: the relay's ripple is shorter
Row = dict[str, Any]
Definition = Callable[[Floats, Floats], float]


@dataclass(frozen=True, slots=True)
class Drive:
    """One episode of a cell, and the PID's on the same seed in the same weather, without obstacles."""

    scenario: str
    weather: str
    record: Mapping[str, Any]
    table: StepTable
    rival: StepTable | None

    @property
    def good(self) -> bool:
        return bool(self.record["status"] == "success")


def plan(seeds: str | None, driver: str = DRIVER) -> Plan:
    """The paper's four cells, with its method and the PID."""
    return Plan(SCENARIOS, WEATHERS, (driver, RIVAL), seeds or SEEDS)


def _span(signal: Floats, pid: Floats) -> float:
    return 1.0 - float(np.mean(np.abs(signal - pid))) / max(float(np.ptp(pid)), 1e-9)


def _sign(signal: Floats, pid: Floats) -> float:
    moving = np.abs(pid) > 1e-3
    return float(np.mean(np.sign(signal[moving]) == np.sign(pid[moving]))) if moving.any() else 1.0


def _correlation(signal: Floats, pid: Floats) -> float:
    spread = float(np.std(signal)) * float(np.std(pid))
    return float(np.mean((signal - signal.mean()) * (pid - pid.mean()))) / spread if spread > 0.0 else 0.0


DEFINITIONS: dict[str, tuple[str, Definition]] = {
    "range": ("1 - mean |d| / 2", lambda u, w: 1.0 - float(np.mean(np.abs(u - w))) / 2.0),
    "difference": ("1 - mean |d|", lambda u, w: 1.0 - float(np.mean(np.abs(u - w)))),
    "span": ("1 - mean |d| / (max PID - min PID)", _span),
    "rms": ("1 - root mean square of d", lambda u, w: 1.0 - float(np.sqrt(np.mean((u - w) ** 2)))),
    "tolerance": ("share with |d| <= 0.1", lambda u, w: float(np.mean(np.abs(u - w) <= 0.1))),
    "sign": ("share with the PID's sign, where it acts", _sign),
    "correlation": ("correlation with the PID", _correlation),
}
PROTOCOLS = {
    "shadow": "the PID asked at every state that the driver visited",
    "paired": "the PID's own run, matched by the distance driven",
}


def accuracies(table: StepTable, signal: str, protocol: str) -> dict[str, float]:
    """Every definition of one signal's accuracy in one episode, 1 is best; d = signal - the PID's."""
    prefix = {"shadow": "pid", "paired": "paired"}[protocol]
    own, pid = (getattr(table, name)[: len(table)] for name in (signal, f"{prefix}_{signal}"))
    known = np.isfinite(own) & np.isfinite(pid)
    return {name: formula(own[known], pid[known]) for name, (_, formula) in DEFINITIONS.items()} if known.any() else {}


def path_errors(drive: Drive) -> dict[str, float | None]:
    """m2, the mean squared distance by three readings of "the original planned trajectory"."""
    error: dict[str, float | None] = {"lane centre": drive.record.get("path_mse_m2")}
    if drive.rival is None:
        return {**error, "PID's path": None, "PID at the same time": None}
    own, other = drive.table.positions_m, drive.rival.positions_m
    count = min(len(own), len(other))
    return {
        **error,
        "PID's path": float(np.mean(distances(own, other) ** 2)),
        "PID at the same time": float(np.mean(np.sum((own[:count] - other[:count]) ** 2, axis=1))),
    }


def jerkiness(table: StepTable) -> float:
    """rad/s2, mean |d/dt| of the yaw rate averaged over half a second: how restless the path is."""
    step_s = float(np.median(np.diff(table.time_s)))
    width = max(1, round(SMOOTHED_S / step_s))
    smooth = np.convolve(table.yaw_rate_radps, np.full(width, 1.0 / width), "valid")
    return float(np.mean(np.abs(np.diff(smooth)))) / step_s if len(smooth) > 1 else 0.0


def cells(drives: Sequence[Drive]) -> list[Row]:
    """The paper's table: a row a cell, means over the successful episodes."""
    return [_cell(cell, [drive for drive in drives if (drive.scenario, drive.weather) == cell]) for cell in CELLS]


def _cell(cell: tuple[str, str], drives: Sequence[Drive]) -> Row:
    good = [drive for drive in drives if drive.good]
    return {
        "scenario": cell[0],
        "weather": cell[1],
        "paper": PAPER[cell],
        "episodes": len(drives),
        "successes": len(good),
        "path_mse_m2": _means([path_errors(drive) for drive in good]),
        "clearance_m": min(
            (drive.record["min_clearance_m"] for drive in good if drive.scenario == SCENARIOS[1]), default=None
        ),
        "jerkiness_radps2": _mean([jerkiness(drive.table) for drive in good]),
        "in_lane_share": _mean([float(np.mean(drive.table.in_lane)) for drive in good]),
        "accuracy": {
            protocol: {signal: _means([accuracies(one.table, signal, protocol) for one in good]) for signal in SIGNALS}
            for protocol in PROTOCOLS
        },
    }


def definitions(rows: Sequence[Row]) -> list[Row]:
    """A row a protocol and definition: percentage points off from print, and whether the order is the paper's."""
    return [
        {
            "protocol": protocol,
            "definition": name,
            "formula": formula,
            **{signal: _against_print(rows, protocol, signal, name) for signal in SIGNALS},
        }
        for protocol in PROTOCOLS
        for name, (formula, _) in DEFINITIONS.items()
    ]


def _against_print(rows: Sequence[Row], protocol: str, signal: str, name: str) -> Row:
    ours = [row["accuracy"][protocol][signal].get(name) for row in rows]
    printed = [row["paper"][signal] for row in rows]
    if None in ours:
        return {"values": ours, "off": None, "same_order": None}
    off = float(np.mean(np.abs(np.subtract(ours, printed))))
    return {"values": ours, "off": 100.0 * off, "same_order": bool(np.all(np.argsort(ours) == np.argsort(printed)))}


def claims(rows: Sequence[Row], drives: Sequence[Drive], driver_ms: float | None) -> list[Row]:
    """Each claim of the paper, what was measured, and whether it holds; None where it cannot be told."""
    by_cell = {(row["scenario"], row["weather"]): row for row in rows}
    clear, rain = WEATHERS
    empty, blocked = SCENARIOS
    jerk = {cell: row["jerkiness_radps2"] for cell, row in by_cell.items()}
    errors = [row["path_mse_m2"].get("lane centre") for row in rows]
    printed = [row["paper"]["path_mse_m2"] for row in rows]
    clearances = [row["clearance_m"] for row in rows if row["clearance_m"] is not None]
    reached = [f"{row['successes']} of {row['episodes']}" for row in rows]
    names = ", ".join(
        f"{weather} {'without' if scenario == empty else 'with'} obstacles" for scenario, weather in CELLS
    )
    bended = [drive for drive in drives if drive.good and drive.scenario == blocked]
    return [
        _claim(
            "The vehicle reaches its destination in all four conditions (here: in nine drives of ten).",
            f"{', '.join(reached)} ({names})",
            all(often(row) for row in rows),
        ),
        _claim(
            "It avoids both the obstacles and the road's edges (likewise).",
            f"least clearance {_number(min(clearances, default=None))} m",
            bool(bended) and all(often(row) for row in rows if row["scenario"] == blocked),
        ),
        _claim(
            "Its path is jerkier with obstacles.",
            _pairs(jerk, [((blocked, weather), (empty, weather)) for weather in WEATHERS], "rad/s2"),
            _above(jerk, [((blocked, weather), (empty, weather)) for weather in WEATHERS]),
        ),
        _claim(
            "Its path is jerkier in rain.",
            _pairs(jerk, [((scenario, rain), (scenario, clear)) for scenario in SCENARIOS], "rad/s2"),
            _above(jerk, [((scenario, rain), (scenario, clear)) for scenario in SCENARIOS]),
        ),
        _claim(
            "It does not stay in its lane, since only the edges of the road bound it.",
            ", ".join(
                f"{_number(100.0 * row['in_lane_share'], 0)} %" for row in rows if row["in_lane_share"] is not None
            )
            + " of the way within one lane",
            None if not bended else any((row["in_lane_share"] or 1.0) < 0.99 for row in rows),
        ),
        _claim(
            "The mean squared error of the path is below 1 on average.",
            f"mean of the cells {_number(_mean(errors))} m2; the paper's {_number(_mean(printed))}",
            None if None in errors else float(np.mean(errors)) < 1.0,
        ),
        _claim(
            "The error grows with obstacles and in rain.",
            ", ".join(_number(error) for error in errors) + " m2 in the order of the table",
            None if None in errors else [*errors] == sorted(errors),
        ),
        _claim(
            "The accuracies fall in the order of the table.",
            _ordered(definitions(rows)),
            None if None in errors else any(_both(row) for row in definitions(rows)),
        ),
        _claim(
            "It takes less computation than learning.",
            f"{_number(driver_ms)} ms a frame on one core" if driver_ms is not None else "not timed",
            None,
        ),
    ]


def often(row: Row) -> bool:
    """Whether nearly every drive of a cell reached the goal."""
    return bool(row["episodes"] and row["successes"] >= OFTEN * row["episodes"])


def _claim(text: str, measured: str, holds: bool | None) -> Row:
    return {"claim": text, "measured": measured, "holds": holds}


def _pairs(values: Mapping[Any, float | None], pairs: Sequence[Any], unit: str) -> str:
    return (
        ", ".join(f"{_number(values[one], 3)} beside {_number(values[other], 3)}" for one, other in pairs) + f" {unit}"
    )


def _above(values: Mapping[Any, float | None], pairs: Sequence[Any]) -> bool | None:
    known = [(values[one], values[other]) for one, other in pairs]
    if any(one is None or other is None for one, other in known):
        return None
    return all(one > other for one, other in known)  # type: ignore[operator]


def _both(row: Row) -> bool:
    return all(row[signal]["same_order"] for signal in SIGNALS)


def _ordered(rows: Sequence[Row]) -> str:
    right = [f"{row['definition']} ({row['protocol']})" for row in rows if _both(row)]
    return f"in this order by {', '.join(right)}" if right else f"by none of {len(rows)} definitions"


def _number(value: float | None, digits: int = 2) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _means(rows: Sequence[Mapping[str, float | None]]) -> dict[str, float | None]:
    keys = rows[0] if rows else ()
    return {key: _mean([row.get(key) for row in rows]) for key in keys}
