"""The results of a search by choice of each quantity."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.evaluation.readings.search import CELLS, Trial
from vpf_sim.evaluation.readings.space import Quantity

Row = dict[str, Any]
PARTS = 4  # of a range, equal on the logarithmic scale


def by_choice(quantities: Sequence[Quantity], trials: Sequence[Trial]) -> list[Row]:
    """One row per choice: readings tried, readings that passed each cell in search order, and the best score.

    A range has four rows. The optimiser samples good regions more often, so the rows are not independent trials.
    """
    return [
        {
            "quantity": quantity.name,
            "choice": choice,
            "source": quantity.sources.get(choice) or quantity.sources.get("", ""),
            "tried": len(having),
            "passed": [sum(passed(one) > cell for one in having) for cell in range(len(CELLS))],
            "best_score": max((one.score for one in having), default=None),
        }
        for quantity in quantities
        for choice, having in _groups(quantity, trials).items()
    ]


def passed(one: Trial) -> int:
    """Number of consecutive cells passed on all seeds."""
    results = [one.cells.get(f"{scenario}.{weather}") for scenario, weather in CELLS]
    whole = [result is not None and result["successes"] == result["episodes"] for result in results]
    return next((i for i, right in enumerate(whole) if not right), len(whole))


def _groups(quantity: Quantity, trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    if quantity.choices:
        return {choice: [one for one in trials if one.reading[quantity.name] == choice] for choice in quantity.choices}
    step = (quantity.high / quantity.low) ** (1.0 / PARTS)
    bounds = [(quantity.low * step**part, quantity.low * step ** (part + 1)) for part in range(PARTS)]
    return {
        f"{low:.2g} to {high:.2g}": [one for one in trials if low <= float(one.reading[quantity.name]) < high]
        for low, high in bounds
    }
