"""Perception rules, on the metrics that `vpf-sim perception` stored in the run's folder."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from vpf_sim.evaluation.analysis.rows import Cell
from vpf_sim.evaluation.gate.checks import Check, Outcome, matching, number
from vpf_sim.evaluation.gate.rules import PerceptionBounds, Rule
from vpf_sim.evaluation.gate.run_cells import Run, worst_first
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.perception.store import Metrics, Record, read

PERFECT = {"recall": 1.0, "precision": 1.0, "false_positives_per_minute": 0.0}
OF_FRAMES = ("edge_error_m", "lane_error_m", "foe_error_px")  # do not depend on obstacles
P95 = "_p95"


def check(run: Run, rule: Rule, bounds: PerceptionBounds, where: str) -> list[Check]:
    """Check the bounds in every matching cell; a cell's driver is the one that perceived."""
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
    key: str, limit: float, cell: Cell, row: Metrics, found: Sequence[Record], missing: int, folder: Path
) -> Check:
    """Check one metric of a cell; a planned drive without perception of its current poses fails."""
    figure, _, side = key.rpartition("_at_")
    sign, value = 1.0 if side == "least" else -1.0, _value(row, figure)
    actual = f"{'none' if value is None else number(value, limit)} over {len(found)} drive" + "s" * (len(found) != 1)
    check = Check(cell, f"perception.{key} {limit:g}", actual, "passed")
    if missing:
        return replace(check, actual=f"{actual}, {missing} not perceived", outcome="failed", folder=str(folder))
    if value is None:
        outcome: Outcome = "skipped" if _may_lack(figure, row) else "failed"
        return replace(check, outcome=outcome, folder=str(folder) if outcome == "failed" else "")
    if sign * (value - limit) >= 0.0:
        return check
    good = PERFECT.get(figure, limit)
    short = {k: sign * (good - own) for k, one in enumerate(found) if (own := _value(one, figure)) is not None}
    worst = [k for k in worst_first(short) if short[k] > 0.0]
    seeds, drives = tuple(found[k].seed for k in worst), tuple(found[k].drive for k in worst)
    return replace(check, outcome="failed", seeds=seeds, drives=drives, folder=str(folder))


def _missing(cell: Cell, found: Sequence[Record], run: Run) -> int:
    """Number of planned drives without a perception record of their poses."""
    perceived = {(one.drive, one.states_sha256) for one in found}
    planned = [
        (Job(*driven, seed).id, None if episode is None else episode.states_sha256)
        for driven, episodes in run.cells.items()
        for seed, episode in episodes.items()
        if driven[:2] == cell[:2]
    ]
    return sum(drive not in perceived for drive in planned)


def _value(metrics: Metrics, figure: str) -> float | None:
    """A metric's value: of errors the median, or the 95th percentile for a name with _p95."""
    value: Any = getattr(metrics, figure.removesuffix(P95))
    if isinstance(value, dict):
        value = value["p95" if figure.endswith(P95) else "median"]
    found: float | None = value
    return found


def _may_lack(figure: str, row: Metrics) -> bool:
    """Whether a metric may be missing: without met objects, or speed errors without moving ones."""
    name = figure.removesuffix(P95)
    return name == "speed_error_mps" or (name not in OF_FRAMES and row.recall is None)
