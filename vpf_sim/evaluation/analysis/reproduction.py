"""The paper's simulator table, recomputed from a run: path errors, accuracies and jerkiness by cell.

The paper gives no formula for its accuracy, and no reference path for its MSE beyond "the original planned trajectory".
So each is computed by several definitions, and the tables show how far each is from the printed value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vpf_sim.evaluation.analysis.benchmark import PAPER, SCENARIOS, WEATHERS
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import CLEARANCE, PATH_MSE
from vpf_sim.evaluation.metrics.tracking import accuracy, distances
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.types import Floats

DRIVER, REFERENCE_DRIVER, SEEDS = "vpf-paper", "pid", "0:3"
CELLS = tuple((scenario, weather) for weather in WEATHERS for scenario in SCENARIOS)  # in the paper's order
SIGNALS = ("throttle", "steering")
SMOOTHED_S = 0.5  # averaging window of the yaw rate: longer than the ripple of the sliding mode's relay
LEAST_COMMAND = 1e-3  # a smaller command of the PID has no sign
DEFINITIONS = {  # d = signal - the PID's
    "range": "1 - mean |d| / 2",
    "difference": "1 - mean |d|",
    "span": "1 - mean |d| / (max PID - min PID)",
    "rms": "1 - root mean square of d",
    "tolerance": "share with |d| <= 0.1",
    "sign": "share with the PID's sign, where it acts",
    "correlation": "correlation with the PID",
}
PROTOCOLS = ("shadow", "paired")
Values = dict[str, float | None]  # by definition, or by reference path


@dataclass(frozen=True, slots=True)
class Drive:
    """One episode of a cell, and the PID's episode without obstacles on the same seed and weather."""

    scenario: str
    weather: str
    record: Record
    table: StepTable
    pid: StepTable | None

    @property
    def succeeded(self) -> bool:
        return self.record.succeeded


@dataclass(frozen=True, slots=True)
class CellResult:
    """One row of the paper's table: means over the drives that reached the goal."""

    scenario: str
    weather: str
    paper: Mapping[str, float]
    episodes: int
    successes: int
    path_mse_m2: Values
    clearance_m: float | None  # the least, to the parked cars
    jerkiness_radps2: float | None
    in_lane_share: float | None
    accuracy: Mapping[str, Mapping[str, Values]]  # by protocol and signal

    @property
    def cell(self) -> tuple[str, str]:
        return self.scenario, self.weather

    @property
    def lane_mse_m2(self) -> float | None:
        """Path MSE to the lane's centre."""
        return self.path_mse_m2.get("lane centre")


@dataclass(frozen=True, slots=True)
class AgainstPrint:
    """One signal's accuracies in the four cells, and how far they are from the printed ones."""

    values: list[float | None]
    off: float | None  # mean deviation, percentage points
    same_order: bool | None


@dataclass(frozen=True, slots=True)
class Definition:
    """One definition of accuracy by one protocol, held against the printed values."""

    protocol: str
    definition: str
    formula: str
    throttle: AgainstPrint
    steering: AgainstPrint


def plan(seeds: str | None, driver: str = DRIVER) -> Plan:
    """The paper's four cells, with its method and the PID."""
    return Plan(SCENARIOS, WEATHERS, (driver, REFERENCE_DRIVER), seeds or SEEDS)


def accuracies(table: StepTable, signal: str, protocol: str) -> Values:
    """One signal's accuracy in one episode by each of DEFINITIONS, 1 is best; empty without samples.

    `span` is None where the PID's signal never moved.
    """
    prefix = {"shadow": "pid", "paired": "paired"}[protocol]
    own, pid = (getattr(table, name)[: len(table)] for name in (signal, f"{prefix}_{signal}"))
    finite = np.isfinite(own) & np.isfinite(pid)
    own, pid = own[finite], pid[finite]
    named = accuracy(own, pid, span=float(np.ptp(pid)) if len(pid) else 0.0)
    if named is None:
        return {}
    mae = named["mae"]
    assert mae is not None
    return {
        "range": named["range"],
        "difference": 1.0 - mae,
        "span": named["span"],
        "rms": 1.0 - float(np.sqrt(np.mean((own - pid) ** 2))),
        "tolerance": named["tolerance"],
        "sign": _sign_agreement(own, pid),
        "correlation": _correlation(own, pid),
    }


def _sign_agreement(signal: Floats, pid: Floats) -> float:
    acting = np.abs(pid) > LEAST_COMMAND
    return float(np.mean(np.sign(signal[acting]) == np.sign(pid[acting]))) if acting.any() else 1.0


def _correlation(signal: Floats, pid: Floats) -> float:
    spread = float(np.std(signal)) * float(np.std(pid))
    return float(np.mean((signal - signal.mean()) * (pid - pid.mean()))) / spread if spread > 0.0 else 0.0


def path_errors(drive: Drive) -> Values:
    """Mean squared distance, m2, by three interpretations of "the original planned trajectory"."""
    error: Values = {"lane centre": drive.record[PATH_MSE]}
    if drive.pid is None:
        return {**error, "PID's path": None, "PID at the same time": None}
    own, other = drive.table.positions_m, drive.pid.positions_m
    count = min(len(own), len(other))
    return {
        **error,
        "PID's path": float(np.mean(distances(own, other) ** 2)),
        "PID at the same time": float(np.mean(np.sum((own[:count] - other[:count]) ** 2, axis=1))),
    }


def jerkiness(table: StepTable) -> float:
    """Mean |yaw acceleration|, rad/s2, of the yaw rate averaged over half a second."""
    step_s = float(np.median(np.diff(table.time_s)))
    width = max(1, round(SMOOTHED_S / step_s))
    smooth = np.convolve(table.yaw_rate_radps, np.full(width, 1.0 / width), "valid")
    return float(np.mean(np.abs(np.diff(smooth)))) / step_s if len(smooth) > 1 else 0.0


def cells(drives: Sequence[Drive]) -> list[CellResult]:
    """The paper's table: one row per cell, means over the successful episodes."""
    return [_cell(cell, [drive for drive in drives if (drive.scenario, drive.weather) == cell]) for cell in CELLS]


def _cell(cell: tuple[str, str], drives: Sequence[Drive]) -> CellResult:
    good = [drive for drive in drives if drive.succeeded]
    gaps = (one.record[CLEARANCE] for one in good if one.scenario == SCENARIOS[1])
    return CellResult(
        *cell,
        paper=PAPER[cell],
        episodes=len(drives),
        successes=len(good),
        path_mse_m2=_means([path_errors(drive) for drive in good]),
        clearance_m=min((gap for gap in gaps if gap is not None), default=None),
        jerkiness_radps2=mean([jerkiness(drive.table) for drive in good]),
        in_lane_share=mean([float(np.mean(drive.table.in_lane)) for drive in good]),
        accuracy={
            protocol: {signal: _means([accuracies(one.table, signal, protocol) for one in good]) for signal in SIGNALS}
            for protocol in PROTOCOLS
        },
    )


def definitions(rows: Sequence[CellResult]) -> list[Definition]:
    """One row per protocol and definition."""
    return [
        Definition(protocol, name, formula, *(_against_print(rows, protocol, signal, name) for signal in SIGNALS))
        for protocol in PROTOCOLS
        for name, formula in DEFINITIONS.items()
    ]


def _against_print(rows: Sequence[CellResult], protocol: str, signal: str, name: str) -> AgainstPrint:
    ours = [row.accuracy[protocol][signal].get(name) for row in rows]
    printed = [row.paper[signal] for row in rows]
    known = np.array([value for value in ours if value is not None])
    if len(known) < len(ours):
        return AgainstPrint(ours, None, None)
    off = float(np.mean(np.abs(known - printed)))
    return AgainstPrint(ours, 100.0 * off, bool(np.all(np.argsort(known) == np.argsort(printed))))


def mean(values: Sequence[float | None]) -> float | None:
    """The mean of the values that are not None; None without any."""
    present = [value for value in values if value is not None]
    return float(np.mean(present)) if present else None


def _means(rows: Sequence[Values]) -> Values:
    keys = rows[0] if rows else ()
    return {key: mean([row.get(key) for row in rows]) for key in keys}
