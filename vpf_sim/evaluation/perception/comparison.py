"""What another driver, or another version of the code, perceives differently on the same poses."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.statistics import Difference, paired_difference, paired_shares
from vpf_sim.evaluation.metrics.perception import DUE_M
from vpf_sim.evaluation.perception.scores import ALL, ERRORS, RATE
from vpf_sim.evaluation.perception.store import Body, Record

Row = dict[str, Any]
Pair = tuple[Record, Record]


def between_drivers(records: Sequence[Record]) -> list[Row]:
    """Each driver less the first, in every weather and in all."""
    first, *others = dict.fromkeys(one.driver for one in records)
    base = [one for one in records if one.driver == first]
    found = []
    for driver in others:
        pairs = _pairs([one for one in records if one.driver == driver], base)
        found += _differences(pairs, driver, first)
    return found


def between_versions(now: Sequence[Record], before: Sequence[Record], name: str) -> list[Row]:
    """Each driver less the same in an earlier table, which is called `name`; InputError where they share no drive."""
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
    """Those of the same drive with the same poses."""
    known = {(one.drive, one.states_sha256): one for one in theirs}
    matched = ((one, known.get((one.drive, one.states_sha256))) for one in ours)
    return [(one, other) for one, other in matched if other is not None]


def _differences(pairs: Sequence[Pair], driver: str, minus: str) -> list[Row]:
    weathers = [*dict.fromkeys(one.weather for one, _ in pairs)]
    groups = {weather: [pair for pair in pairs if pair[0].weather == weather] for weather in weathers}
    groups |= {ALL: list(pairs)} if len(weathers) > 1 else {}
    return [
        {"driver": driver, "minus": minus, "weather": weather, "drives": len(group), **_figures(group)}
        for weather, group in groups.items()
    ]


def _figures(pairs: Sequence[Pair]) -> Row:
    """Recall over the bodies met, all else over the drives."""
    return {
        "recall": _told(_recall(pairs)),
        "precision": _told(_mean(pairs, "precision")),
        RATE: _told(_mean(pairs, RATE)),
        **{key: _told(_mean(pairs, key)) for key in ERRORS},
    }


def _recall(pairs: Sequence[Pair]) -> Difference | None:
    bodies = [(one, other) for ours, theirs in pairs for one, other in zip(ours.bodies, theirs.bodies, strict=True)]
    if not bodies:
        return None
    first, second = (np.array([_known(pair[side]) for pair in bodies]) for side in (0, 1))
    return paired_shares(first, second)


def _known(body: Body) -> bool:
    """Whether it was confirmed in time."""
    return body.first_confirmed_m is not None and body.first_confirmed_m >= DUE_M[body.kind]  # type: ignore[index]


def _mean(pairs: Sequence[Pair], key: str) -> Difference | None:
    values = [(_value(one, key), _value(other, key)) for one, other in pairs]
    there = np.array([pair for pair in values if None not in pair], float).reshape(-1, 2)
    return paired_difference(there[:, 0], there[:, 1])


def _value(record: Record, key: str) -> float | None:
    """A figure of a drive; of errors the median."""
    value: Any = getattr(record, key)
    found: float | None = value["median"] if isinstance(value, dict) else value
    return found


def _told(found: Difference | None) -> Row | None:
    return None if found is None else {**found._asdict(), "interval": found.interval and list(found.interval)}
