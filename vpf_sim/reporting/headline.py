"""The title of a report, and its findings in a few sentences with intervals."""

from collections.abc import Iterable, Mapping, Sequence
from datetime import date

import numpy as np

from vpf_sim.evaluation.analysis.comparisons import succeeded
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.analysis.statistics import Difference, paired_shares, share_interval
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import PATH_MSE
from vpf_sim.evaluation.sweeps.plan import Plan, parse_seeds
from vpf_sim.reporting.kit.page import formatted, interval_text
from vpf_sim.reporting.main_table import Order, shown, text_of

WHAT = {"town04-clean": "without obstacles", "town04": "with obstacles"}
MOST_NAMES = 4  # in a title


def title(plan: Plan, begun: date | None = None) -> str:
    """What is compared, where, and when: "vpf against pid on town04 — rain — seeds 0:3 — 1 Nov 2026"."""
    drivers = " against ".join(plan.driver) if len(plan.driver) == 2 else listed(plan.driver)
    parts = [f"{drivers} on {listed(plan.scenario)}", ", ".join(map(shown, plan.weather)), _seeds(plan)]
    return " — ".join([*parts, *([day(begun)] if begun else [])])


def listed(names: Sequence[str]) -> str:
    """Names as text: "a, b and c", or the first ones and the number of the others."""
    words = [*map(shown, names)]
    if len(words) > MOST_NAMES:
        words[MOST_NAMES - 1 :] = [f"{len(words) - MOST_NAMES + 1} others"]
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def day(when: date) -> str:
    """A date as text: "26 Nov 2026"."""
    return f"{when.day} {when:%b %Y}"


def _seeds(plan: Plan) -> str:
    if plan.drives:
        return f"{len(plan.drives)} drives"
    seeds = parse_seeds(plan.seeds)
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {plan.seeds}"


def sentences(rows: Sequence[Row], order: Order, against: Difference | None, command: str = "sweep") -> list[str]:
    """The success of each driver, the difference of two, and in a benchmark the path MSE beside the paper's."""
    first, *others = order.drivers
    success = [
        f"{first} reached the goal in {_success(first, rows)}",
        *(f"{one} in {_success(one, rows)}" for one in others),
    ]
    if len(order.drivers) > 2:
        found = [f"{one}{end}" for one, end in zip(success, [*(len(others) * ";"), "."], strict=True)]
        found[0] = found[0].replace(" (", " (95 % interval: ", 1)
    else:
        found = [
            f"{', '.join(success).replace(' (', ' (95 % interval: ', 1)}{_where(first, rows) if not others else ''}."
        ]
    if against is not None and others:
        found.append(f"On the same seeds {first} reached it {difference(against, others[0])}.")
    return [*found, *(_against_paper(rows, order) if command == "benchmark" else [])]


def difference(found: Difference, other: str) -> str:
    """A difference of success as text: "17 percentage points more often than pid (−9 to 43, p = 0.25)"."""
    points, test = 100.0 * found.difference, f"p {probability(found.p)}"
    ends = interval_text(found.interval, 0, percent=True)
    if points == 0.0:
        return f"as often as {other} ({ends} percentage points, {test})"
    more = "more" if points > 0.0 else "less"
    return f"{abs(points):.0f} percentage points {more} often than {other} ({ends}, {test})"


def probability(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"= {p:.3f}" if p < 0.1 else f"= {p:.2f}"


def of_two(jobs: Iterable[Job], records: Mapping[str, Record], order: Order) -> Difference | None:
    """Success of the first driver minus the second's over the episodes planned for both; None without two drivers."""
    if len(order.drivers) != 2:
        return None
    places: dict[tuple[str, str, int], dict[str, bool]] = {}
    for job in jobs:
        places.setdefault((job.scenario, job.weather, job.seed), {})[job.driver] = succeeded(records.get(job.id))
    both = np.array([[one[driver] for driver in order.drivers] for one in places.values() if len(one) == 2], bool)
    return paired_shares(both[:, 0], both[:, 1]) if len(both) else None


def _success(driver: str, rows: Sequence[Row]) -> str:
    own = [row for row in rows if row.driver == driver]
    reached, planned = sum(row.successes for row in own), sum(row.episodes for row in own)
    ends = interval_text(share_interval(reached, planned), 0, percent=True)
    return f"{reached} of {planned} episode{'s' * (planned != 1)} ({ends} %)"


def _where(driver: str, rows: Sequence[Row]) -> str:
    """The cells with failures, if they are few."""
    own = [row for row in rows if row.driver == driver]
    bad = [row for row in own if row.successes < row.episodes]
    if not bad or len(bad) == len(own) or len(bad) > 4:
        return ""
    failing = (f"{row.successes} of {row.episodes} on {shown(row.scenario)} in {shown(row.weather)}" for row in bad)
    return f": {', '.join(failing)}, all in the others"


def _against_paper(rows: Sequence[Row], order: Order) -> list[str]:
    """A sentence with the first driver's path MSE beside the paper's; empty without both."""
    first = order.drivers[0]
    own = [row for row in order.sorted(rows) if row.driver == first and row.paper]
    scored = [row for row in own if row[PATH_MSE] is not None]
    if not scored:
        return []
    pairs = ", ".join(f"{text_of(PATH_MSE, row[PATH_MSE])} ({_cell(row)}; paper {_paper(row)})" for row in scored)
    return [f"Path MSE of {first}, m²: {pairs}. Simulator and camera differ: see below."]


def _cell(row: Row) -> str:
    return f"{row.weather}, {WHAT.get(row.scenario, row.scenario)}"


def _paper(row: Row) -> str:
    return formatted((row.paper or {}).get(PATH_MSE.paper), 2)
