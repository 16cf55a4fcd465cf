"""Rules on perception: the figures that `vpf-sim perception` stored in the run's folder."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from vpf_sim.evaluation.gate.cells import Cell, Run, worst_first
from vpf_sim.evaluation.gate.checks import Check, Outcome, matching, number
from vpf_sim.evaluation.gate.rules import PerceptionBounds, Rule
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.perception.store import Figures, Record, read

PERFECT = {"recall": 1.0, "precision": 1.0, "false_positives_per_minute": 0.0}
OF_FRAMES = ("edge_error_m", "lane_error_m", "foe_error_px")  # told at every frame, whatever stands there
P95 = "_p95"


def check(run: Run, rule: Rule, bounds: PerceptionBounds, where: str) -> list[Check]:
    """The bounds in every cell that they are for: its driver is the one that perceived, whoever drove."""
    stored = read(run.path)
    rows = {Cell(row.scenario, row.weather, row.driver): row for row in stored.rows}
    checks = []
    for cell in matching(rule, rows, run.path, where):
        found = [one for one in stored.records if Cell(one.scenario, one.weather, one.driver) == cell]
        missing = _missing(cell, found, run)
        checks += [
            _bound(key, limit, cell, rows[cell], found, missing, run.path) for key, limit in bounds.bounds().items()
        ]
    return checks


def _bound(
    key: str, limit: float, cell: Cell, row: Figures, found: Sequence[Record], missing: int, folder: Path
) -> Check:
    """A figure of a cell; a planned drive that was not perceived as it is now breaks every rule."""
    figure, _, side = key.rpartition("_at_")
    sign, value = 1.0 if side == "least" else -1.0, _value(row, figure)
    actual = f"{'none' if value is None else number(value, limit)} over {len(found)} drive" + "s" * (len(found) != 1)
    told = Check(cell, f"perception.{key} {limit:g}", actual, "passed")
    if missing:
        return replace(told, actual=f"{actual}, {missing} not perceived", outcome="failed", folder=str(folder))
    if value is None:
        outcome: Outcome = "skipped" if _may_lack(figure, row) else "failed"
        return replace(told, outcome=outcome, folder=str(folder) if outcome == "failed" else "")
    if sign * (value - limit) >= 0.0:
        return told
    good = PERFECT.get(figure, limit)
    short = {k: sign * (good - own) for k, one in enumerate(found) if (own := _value(one, figure)) is not None}
    worst = [k for k in worst_first(short) if short[k] > 0.0]
    seeds, drives = tuple(found[k].seed for k in worst), tuple(found[k].drive for k in worst)
    return replace(told, outcome="failed", seeds=seeds, drives=drives, folder=str(folder))


def _missing(cell: Cell, found: Sequence[Record], run: Run) -> int:
    """How many of the run's planned drives have no record of perception, or one of other poses."""
    perceived = {(one.drive, one.states_sha256) for one in found}
    planned = [
        (Job(*driven, seed).id, None if episode is None else episode.states_sha256)
        for driven, episodes in run.cells.items()
        for seed, episode in episodes.items()
        if driven[:2] == cell[:2]
    ]
    return sum(drive not in perceived for drive in planned)


def _value(told: Figures, figure: str) -> float | None:
    """A figure, of errors the median, or the 95th percentile of one that says so; None where there is none."""
    value: Any = getattr(told, figure.removesuffix(P95))
    if isinstance(value, dict):
        value = value["p95" if figure.endswith(P95) else "median"]
    found: float | None = value
    return found


def _may_lack(figure: str, row: Figures) -> bool:
    """Whether a cell may have none of a figure: of bodies where none was met, of speeds where nothing moves."""
    name = figure.removesuffix(P95)
    return name == "speed_error_mps" or (name not in OF_FRAMES and row.recall is None)
