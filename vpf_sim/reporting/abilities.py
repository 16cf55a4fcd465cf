"""Tables of success by ability and weather, and of the classes of failures."""

from collections import Counter
from collections.abc import Sequence
from typing import get_args

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.abilities import AbilityRow, Share, base_of, by_ability
from vpf_sim.evaluation.analysis.statistics import Difference
from vpf_sim.evaluation.metrics.failure import Failure
from vpf_sim.reporting.endings import class_of
from vpf_sim.reporting.kit.page import NONE, Line, Table, Value, formatted, interval_text
from vpf_sim.reporting.main_table import shown
from vpf_sim.reporting.run_data import RunData
from vpf_sim.scenarios import Ability

TITLES: dict[Ability, str] = {
    "keep-lane": "keep the lane",
    "pass-static": "pass what stands",
    "low-obstacles": "low obstacles",
    "follow": "follow",
    "cut-in": "cut-in",
    "oncoming": "oncoming",
    "crossing": "crossing",
    "marks-and-shadows": "marks and shadows",
    "worn-paint": "worn paint",
    "cameras": "cameras",
}
ALL = "all drives"
OPEN = "not known"  # of a failure whose record does not tell why
CLASSES: tuple[Failure, ...] = get_args(Failure)


def abilities(run_data: RunData) -> Table | None:
    """One row for each driver and ability; None where no scenario of the run names any."""
    rows = by_ability(run_data.jobs, run_data.records, _abilities_of(run_data))
    if not rows:
        return None
    weathers = list(run_data.order.weathers)
    base = base_of(weathers)
    others = [weather for weather in weathers if weather != base]
    header = ("driver", "ability", *map(shown, weathers), *(["all weathers"] if others else []))
    changes = tuple(f"{shown(weather)} − {shown(base)}" for weather in others)
    lines = tuple(_line(row, weathers, others) for row in rows)
    return Table((*header, *changes), lines, names=2)


def _abilities_of(run_data: RunData) -> dict[str, tuple[Ability, ...]]:
    """The abilities of the run's scenarios; those that can no longer be read are left out."""
    found: dict[str, tuple[Ability, ...]] = {}
    for name in run_data.order.scenarios:
        try:
            found[name] = run_data.run.inputs.scenario(name).abilities
        except InputError:
            continue
    return found


def _line(row: AbilityRow, weathers: Sequence[str], others: Sequence[str]) -> Line:
    shares = [_share(row.by_weather.get(weather)) for weather in weathers]
    together = [_share(row.all)] if others else []
    changes = [_change(row.changes.get(weather)) for weather in others]
    return (row.driver, ALL if row.ability is None else TITLES[row.ability], *shares, *together, *changes)


def _share(share: Share | None) -> Value:
    if share is None:
        return Value(NONE)
    ends = f"{interval_text(share.interval, 0, percent=True)} %"
    return Value(f"{share.successes} of {share.drives}", ends, share.successes / share.drives)


def _change(change: Difference | None) -> Value:
    """Percentage points on the same scenarios and seeds."""
    if change is None:
        return Value(NONE)
    sign = "+" if change.difference > 0.0 else ""
    beside = f"{interval_text(change.interval, 0, percent=True)}, n {change.pairs}"
    return Value(sign + formatted(change.difference, 0, percent=True), beside, change.difference)


def failure_classes(run_data: RunData) -> Table | None:
    """The number of failures of each class, by driver; None without failures."""
    counts: dict[str, Counter[str]] = {}
    for record in run_data.failures():
        counts.setdefault(record.driver, Counter())[record.failure or OPEN] += 1
    header = ("driver", "failures", *map(class_of, CLASSES), OPEN)
    lines: list[Line] = [
        (driver, _count(found.total()), *(_count(found[name]) for name in (*CLASSES, OPEN)))
        for driver in run_data.order.drivers
        if (found := counts.get(driver))
    ]
    return Table(header, tuple(lines)) if lines else None


def _count(count: int) -> Value:
    return Value(str(count) if count else NONE, value=count)
