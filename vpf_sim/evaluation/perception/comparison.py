"""Paired differences of perception metrics between drivers or code versions, on the same poses."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.statistics import Difference, paired_difference, paired_shares
from vpf_sim.evaluation.metrics.perception import DUE_M
from vpf_sim.evaluation.perception.scores import ALL, ERRORS, RATE, Row
from vpf_sim.evaluation.perception.store import MetObject, Record

Pair = tuple[Record, Record]


def between_drivers(records: Sequence[Record]) -> list[Row]:
    """Each driver minus the first, by weather and over all weathers."""
    first, *others = dict.fromkeys(one.driver for one in records)
    base = [one for one in records if one.driver == first]
    found = []
    for driver in others:
        pairs = _pairs([one for one in records if one.driver == driver], base)
        found += _differences(pairs, driver, first)
    return found


def between_versions(now: Sequence[Record], before: Sequence[Record], name: str) -> list[Row]:
    """Each driver minus itself in an earlier table called `name`; InputError without a common drive."""
    found = []
    for driver in dict.fromkeys(one.driver for one in now):
        ours, theirs = ([one for one in table if one.driver == driver] for table in (now, before))
        if not theirs:
            known = ", ".join(dict.fromkeys(one.driver for one in before))
            raise InputError(f"{name}: expected what driver '{driver}' perceived, got only: {known or 'nothing'}")
        pairs = _pairs(ours, theirs)
        if not pairs:
            raise InputError(f"{name}: expected a drive with the same poses, got none of {len(ours)}")
        found += _differences(pairs, driver, f"{driver} in {name}")
    return found


def _pairs(ours: Iterable[Record], theirs: Iterable[Record]) -> list[Pair]:
    """Pairs of records of the same drive with the same poses."""
    by_drive = {(one.drive, one.states_sha256): one for one in theirs}
    matched = ((one, by_drive.get((one.drive, one.states_sha256))) for one in ours)
    return [(one, other) for one, other in matched if other is not None]


def _differences(pairs: Sequence[Pair], driver: str, minus: str) -> list[Row]:
    weathers = [*dict.fromkeys(one.weather for one, _ in pairs)]
    groups = {weather: [pair for pair in pairs if pair[0].weather == weather] for weather in weathers}
    groups |= {ALL: list(pairs)} if len(weathers) > 1 else {}
    return [
        {"driver": driver, "minus": minus, "weather": weather, "drives": len(group), **_metrics(group)}
        for weather, group in groups.items()
    ]


def _metrics(pairs: Sequence[Pair]) -> Row:
    """Recall is paired by object, all else by drive."""
    return {
        "recall": _as_row(_recall(pairs)),
        "precision": _as_row(_mean(pairs, "precision")),
        RATE: _as_row(_mean(pairs, RATE)),
        **{key: _as_row(_mean(pairs, key)) for key in ERRORS},
    }


def _recall(pairs: Sequence[Pair]) -> Difference | None:
    objects = [(one, other) for ours, theirs in pairs for one, other in zip(ours.bodies, theirs.bodies, strict=True)]
    if not objects:
        return None
    first, second = (np.array([_confirmed_in_time(pair[side]) for pair in objects]) for side in (0, 1))
    return paired_shares(first, second)


def _confirmed_in_time(met: MetObject) -> bool:
    return met.first_confirmed_m is not None and met.first_confirmed_m >= DUE_M[met.kind]  # type: ignore[index]


def _mean(pairs: Sequence[Pair], key: str) -> Difference | None:
    values = [(_value(one, key), _value(other, key)) for one, other in pairs]
    there = np.array([pair for pair in values if None not in pair], float).reshape(-1, 2)
    return paired_difference(there[:, 0], there[:, 1])


def _value(record: Record, key: str) -> float | None:
    """A metric of a drive; the median for errors."""
    value: Any = getattr(record, key)
    found: float | None = value["median"] if isinstance(value, dict) else value
    return found


def _as_row(found: Difference | None) -> Row | None:
    return None if found is None else {**found._asdict(), "interval": found.interval and list(found.interval)}
