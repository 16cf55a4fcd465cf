"""Ablations: from one variant to another in single steps, compared on the same seeds."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

import numpy as np

from vpf_sim.evaluation.analysis import benchmark
from vpf_sim.evaluation.analysis.comparisons import succeeded, value_at
from vpf_sim.evaluation.analysis.statistics import (
    Difference,
    mean_interval,
    paired_difference,
    paired_shares,
    share_interval,
)
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.planning.variant import Chain
from vpf_sim.planning.variants.knockouts import NO
from vpf_sim.planning.variants.repair_steps import WITHOUT

BETWEEN = "vpf@"
FIRST = {"robust": "vpf@full-frame", "paper": "vpf-literal", "without": "vpf-paper", "mechanisms": "vpf"}
APART = ("without", "mechanisms")  # each step is compared with the first
SCENARIOS = {
    "robust": ("town04-clean", "town04", "random"),
    "mechanisms": ("random",),
}  # otherwise those of the paper's table
WEATHERS = {"robust": ("clear",)}
SEEDS = "1000:1010"
OF_SUCCESSES = ("path_mse_m2", "min_clearance_m")
OF_ALL = ("route_completion", "steering_changes_per_s", "driver_ms")
COMFORT = "comfort.comfortable"
PLACES = {"steering_changes_per_s": "chattering.steering.direction_changes_per_s"}

Record = dict[str, Any]
Row = dict[str, Any]


def ablation_steps(chain: Chain = "robust") -> dict[str, str]:
    """The drivers of a chain in order, with what each changes; `robust` ends with `vpf`, `paper` with `vpf-paper`."""
    from vpf_sim import drivers
    from vpf_sim.planning import variant

    first = FIRST[chain]
    steps = {f"{BETWEEN}{name}": summary for name, summary in variant.ablation(chain).items()}
    if chain not in APART:
        _, summary = steps.popitem()
        steps["vpf" if chain == "robust" else "vpf-paper"] = summary
    return {first: drivers.description(first).summary, **steps}


def plan(seeds: str | None, scenarios: Sequence[str], weathers: Sequence[str], chain: Chain = "robust") -> Plan:
    """The grid of an ablation."""
    where = tuple(scenarios) or SCENARIOS.get(chain, benchmark.SCENARIOS)
    when = tuple(weathers) or WEATHERS.get(chain, benchmark.WEATHERS)
    return Plan(where, when, tuple(ablation_steps(chain)), seeds or SEEDS)


def table(jobs: Iterable[Job], records: Iterable[Record], timing: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """`{"rows": [...]}`: scores of each step by scenario and weather, and differences to the previous step.

    In the chains `without` and `mechanisms`, the difference is to the whole variant. Success and comfort are over the
    planned seeds; path MSE and clearance over successful episodes, differences over seeds where both succeeded; the
    others over all driven episodes. `driver_ms` is the driver's wall time per step.
    """
    clock = {row["id"]: (row.get("stages_ms") or {}).get("driver") for row in timing}
    by_id = {record["id"]: {**record, "driver_ms": clock.get(record["id"])} for record in records}
    cells: dict[tuple[str, str], dict[str, dict[int, Record | None]]] = {}
    for job in jobs:
        steps = cells.setdefault((job.scenario, job.weather), {})
        steps.setdefault(job.driver, {})[job.seed] = by_id.get(job.id)
    return {"rows": [row for cell, steps in sorted(cells.items()) for row in _rows(cell, steps)]}


def _rows(cell: tuple[str, str], steps: Mapping[str, Mapping[int, Record | None]]) -> list[Row]:
    summaries = {driver: summary for chain in get_args(Chain) for driver, summary in ablation_steps(chain).items()}
    order, rows = [*steps], []
    for before, step in zip([None, *order], order, strict=False):
        if before is not None and step.startswith((f"{BETWEEN}{WITHOUT}", f"{BETWEEN}{NO}")):
            before = order[0]
        scores = _scores([*steps[step].values()])
        change = None if before is None else _differences(steps[step], steps[before])
        row = {"scenario": cell[0], "weather": cell[1], "driver": step, "changes": summaries.get(step, "")}
        rows.append({**row, **scores, "difference": change})
    return rows


def _scores(found: Sequence[Record | None]) -> Row:
    driven = [record for record in found if record is not None]
    good = [record for record in driven if succeeded(record)]
    values = {
        **{key: _values(good, key) for key in OF_SUCCESSES},
        **{key: _values(driven, key) for key in OF_ALL},
    }
    comfortable = sum(map(_comfortable, found))
    shares = {"success_rate": len(good), "comfortable_rate": comfortable}
    return {
        "episodes": len(found),
        "successes": len(good),
        **{key: count / len(found) for key, count in shares.items()},
        **{key: float(np.mean(some)) if len(some) else None for key, some in values.items()},
        "intervals": {
            **{key: list(share_interval(count, len(found))) for key, count in shares.items()},
            **{key: _listed(mean_interval(some)) for key, some in values.items()},
        },
    }


def _differences(step: Mapping[int, Record | None], before: Mapping[int, Record | None]) -> Row:
    pairs = [(step[seed], before[seed]) for seed in sorted(step)]
    there = [(one, other) for one, other in pairs if one is not None and other is not None]
    good = [(one, other) for one, other in there if succeeded(one) and succeeded(other)]
    shares = {"success_rate": succeeded, "comfortable_rate": _comfortable}
    return {
        **{key: _as_row(_share_difference(pairs, of)) for key, of in shares.items()},
        **{key: _as_row(_mean_difference(good, key)) for key in OF_SUCCESSES},
        **{key: _as_row(_mean_difference(there, key)) for key in OF_ALL},
    }


def _share_difference(pairs: Sequence[tuple[Record | None, Record | None]], of: Any) -> Difference:
    return paired_shares(np.array([of(one) for one, _ in pairs]), np.array([of(other) for _, other in pairs]))


def _mean_difference(pairs: Sequence[tuple[Record, Record]], key: str) -> Difference | None:
    values = [(_value(one, key), _value(other, key)) for one, other in pairs]
    there = np.array([pair for pair in values if None not in pair], float).reshape(-1, 2)
    return paired_difference(there[:, 0], there[:, 1])


def _comfortable(record: Record | None) -> bool:
    return succeeded(record) and record is not None and bool(value_at(record, COMFORT))


def _values(records: Sequence[Record], key: str) -> Any:
    return np.array([value for record in records if (value := _value(record, key)) is not None], float)


def _value(record: Record, key: str) -> float | None:
    return value_at(record, PLACES.get(key, key))


def _as_row(difference: Difference | None) -> Row | None:
    return None if difference is None else {**difference._asdict(), "interval": _listed(difference.interval)}


def _listed(interval: Any) -> list[float] | None:
    return None if interval is None else list(interval)
