"""Searches the best reading with an optimiser and early stopping.

A generation of readings drives the paper's four cells in order, the hardest first. A reading that fails, or whose path
MSE is more than 1.5 times the paper's, stops early. The scores go to the optimiser, a tree-structured Parzen estimator
(Bergstra et al. 2011, optuna's TPESampler), which proposes the next generation. Finally, the best readings drive more
seeds.

Proposals depend on seed and scores alone, and drives are reproducible. So an interrupted search restarts from its first
proposal and finds the driven episodes in the folders of its generations.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.benchmark import PAPER
from vpf_sim.evaluation.readings import space
from vpf_sim.evaluation.readings.space import Quantity, Reading
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.seeds import parse_seeds
from vpf_sim.files import write_text

CELLS = (("town04", "clear"), ("town04-clean", "clear"), ("town04", "rain"), ("town04-clean", "rain"))
PATIENCE = 1.5  # times the paper's path MSE: above it, a reading stops early
Record = dict[str, Any]
Drive = Callable[
    [Plan, Path], Sequence[Record]
]  # drives the missing episodes of a plan in a folder; returns all records


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """The settings of a search."""

    readings: int = 200
    generation: int = 20
    seeds: str = "0:1"  # during the search
    finalists: int = 4
    final_seeds: str = "10:20"
    seed: int = 0  # of the optimiser

    def __post_init__(self) -> None:
        for name in ("readings", "generation", "finalists"):
            if getattr(self, name) < 1:
                raise InputError(f"readings: {name}: expected at least 1, got {getattr(self, name)}")
        for name in ("seeds", "final_seeds"):
            parse_seeds(getattr(self, name), f"readings: {name}")


@dataclass(frozen=True, slots=True)
class Trial:
    """A reading and its results."""

    number: int
    reading: Reading
    driver: str
    cells: Mapping[str, Mapping[str, Any]]  # "scenario.weather" -> successes, episodes, route, MSE
    score: float


class Optimiser(Protocol):
    """Proposes readings (`ask`), and receives their scores (`tell`)."""

    def ask(self, count: int) -> list[Reading]: ...

    def tell(self, scores: Sequence[float]) -> None:
        """Scores of the last proposals, in order; higher is better."""


class Tpe:
    """optuna's tree-structured Parzen estimator: the `known` readings, then 30 random ones, then its proposals."""

    def __init__(self, quantities: Sequence[Quantity], seed: int, known: Sequence[Reading] = ()) -> None:
        try:
            import optuna
        except ImportError:
            raise InputError("readings: the optimiser is missing: pip install 'vpf_sim[readings]'") from None
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=30 + len(known), n_ei_candidates=48)
        self._study = optuna.create_study(sampler=sampler, direction="maximize")
        for reading in known:
            self._study.enqueue_trial(dict(reading))
        self._quantities = quantities
        self._open: list[Any] = []

    def ask(self, count: int) -> list[Reading]:
        self._open = [self._study.ask() for _ in range(count)]
        return [{one.name: self._value(trial, one) for one in self._quantities} for trial in self._open]

    def tell(self, scores: Sequence[float]) -> None:
        for trial, score in zip(self._open, scores, strict=True):
            self._study.tell(trial, score)

    @staticmethod
    def _value(trial: Any, quantity: Quantity) -> str | float:
        if quantity.choices:
            return str(trial.suggest_categorical(quantity.name, list(quantity.choices)))
        return float(trial.suggest_float(quantity.name, quantity.low, quantity.high, log=True))


def search(settings: SearchSettings, folder: Path, drive: Drive, optimiser: Optimiser) -> list[Trial]:
    """All trials, in the order of the search."""
    tried: list[Trial] = []
    while len(tried) < settings.readings:
        proposals = optimiser.ask(min(settings.generation, settings.readings - len(tried)))
        names = [write(folder, len(tried) + i, reading) for i, reading in enumerate(proposals)]
        results = _drive_generation(
            names, settings.seeds, folder / f"generation-{len(tried) // settings.generation:02}", drive
        )
        found = [
            Trial(len(tried) + i, reading, name, results[name], score(results[name]))
            for i, (reading, name) in enumerate(zip(proposals, names, strict=True))
        ]
        optimiser.tell([one.score for one in found])
        tried += found
    return tried


def finals(settings: SearchSettings, tried: Sequence[Trial], folder: Path, drive: Drive) -> list[Trial]:
    """The best trials repeated in all cells on other seeds, best first."""
    best = sorted(tried, key=lambda one: -one.score)[: settings.finalists]
    cells: dict[str, dict[str, dict[str, Any]]] = {one.driver: {} for one in best}
    for scenario, weather in CELLS:
        drivers = tuple(one.driver for one in best)
        plan = Plan((scenario,), (weather,), drivers, settings.final_seeds)
        for name, result in _results(drive(plan, folder / "finals" / f"{scenario}.{weather}")).items():
            cells[name][f"{scenario}.{weather}"] = result
    again = [Trial(one.number, one.reading, one.driver, cells[one.driver], score(cells[one.driver])) for one in best]
    return sorted(again, key=lambda one: -one.score)


def write(folder: Path, number: int, reading: Reading) -> str:
    """Write the variant file of a reading; returns the name of its driver."""
    path = folder / "variants" / f"reading-{number:03}.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, space.toml(space.variant_table(reading)))
    return f"vpf@{path}"


def score(cells: Mapping[str, Mapping[str, Any]]) -> float:
    """The score of a reading's cells; higher is better.

    A cell adds up to 1 for its success rate and up to 0.5 for its path MSE: 0.5 at 0, 0.25 at the paper's value, 0 from
    twice that on. Failures add half their route completion. Cells that were not driven add nothing.
    """
    total = 0.0
    for name, cell in cells.items():
        scenario, _, weather = name.partition(".")
        share = cell["successes"] / cell["episodes"]
        total += share + 0.5 * (1.0 - share) * cell["route"]
        if cell["path_mse_m2"] is not None:
            paper = PAPER[scenario, weather]["path_mse_m2"]
            total += 0.5 * share * max(0.0, 1.0 - 0.5 * cell["path_mse_m2"] / paper)
    return total


def _drive_generation(
    names: Sequence[str], seeds: str, folder: Path, drive: Drive
) -> dict[str, dict[str, dict[str, Any]]]:
    """Drive cell by cell with the readings that passed the previous cells: driver -> cell -> result."""
    results: dict[str, dict[str, dict[str, Any]]] = {name: {} for name in names}
    left = tuple(names)
    for scenario, weather in CELLS:
        if not left:
            break
        plan = Plan((scenario,), (weather,), left, seeds)
        found = _results(drive(plan, folder / f"{scenario}.{weather}"))
        for name in left:
            results[name][f"{scenario}.{weather}"] = found[name]
        left = tuple(name for name in left if _passes(found[name], PAPER[scenario, weather]["path_mse_m2"]))
    return results


def _passes(result: Mapping[str, Any], paper_m2: float) -> bool:
    passed: bool = result["successes"] == result["episodes"]
    return passed and (result["path_mse_m2"] or 0.0) <= PATIENCE * paper_m2


def _results(records: Iterable[Record]) -> dict[str, dict[str, Any]]:
    by_driver: dict[str, list[Record]] = {}
    for record in records:
        by_driver.setdefault(record["driver"], []).append(record)
    return {name: _result(rows) for name, rows in by_driver.items()}


def _result(rows: Sequence[Record]) -> dict[str, Any]:
    passed = [row for row in rows if row["status"] == "success"]
    errors = [row["path_mse_m2"] for row in passed if row["path_mse_m2"] is not None]
    return {
        "successes": len(passed),
        "episodes": len(rows),
        "route": sum(row.get("route_completion") or 0.0 for row in rows) / len(rows),
        "path_mse_m2": sum(errors) / len(errors) if errors else None,
        "clearance_m": min((row["min_clearance_m"] for row in passed if row.get("min_clearance_m")), default=None),
        "steering_span": _mean([_span(row) for row in passed]),
    }


def _span(row: Record) -> float | None:
    found = ((row.get("accuracy") or {}).get("shadow") or {}).get("steering") or {}
    value: float | None = found.get("span")
    return value


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None
