"""What a search says: the best reading, and how each choice of each quantity fared."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.evaluation.readings.search import CELLS, Tried
from vpf_sim.evaluation.readings.space import Quantity

Row = dict[str, Any]
PARTS = 4  # of a range, equal on the logarithmic scale


def by_choice(quantities: Sequence[Quantity], tried: Sequence[Tried]) -> list[Row]:
    """A row a choice: how many readings had it, how many passed each cell in the order of the search, the best score.

    A range has four rows. The optimiser looks more often where it found more, so the rows are no independent trials.
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
        for choice, having in _groups(quantity, tried).items()
    ]


def passed(one: Tried) -> int:
    """How many cells in a row it passed, each on all seeds."""
    results = [one.cells.get(f"{scenario}.{weather}") for scenario, weather in CELLS]
    whole = [result is not None and result["successes"] == result["episodes"] for result in results]
    return next((i for i, right in enumerate(whole) if not right), len(whole))


def _groups(quantity: Quantity, tried: Sequence[Tried]) -> dict[str, list[Tried]]:
    if quantity.choices:
        return {choice: [one for one in tried if one.reading[quantity.name] == choice] for choice in quantity.choices}
    step = (quantity.high / quantity.low) ** (1.0 / PARTS)
    bounds = [(quantity.low * step**part, quantity.low * step ** (part + 1)) for part in range(PARTS)]
    return {
        f"{low:.2g} to {high:.2g}": [one for one in tried if low <= float(one.reading[quantity.name]) < high]
        for low, high in bounds
    }
