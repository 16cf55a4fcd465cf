"""Success by what a drive asks of a driver, over all scenarios that ask for it.

A drive counts for every ability that its scenario names. Weathers are compared on the same scenarios and seeds.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from vpf_sim.evaluation.analysis.comparisons import BASE_WEATHER, succeeded
from vpf_sim.evaluation.analysis.statistics import Difference, Interval, paired_shares, share_interval
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.scenarios import Ability

ABILITIES: tuple[Ability, ...] = get_args(Ability)


@dataclass(frozen=True, slots=True)
class Share:
    """Successes among planned drives."""

    successes: int
    drives: int

    @property
    def interval(self) -> Interval:
        """The 95 % interval of the share."""
        return share_interval(self.successes, self.drives)


@dataclass(frozen=True, slots=True)
class AbilityRow:
    """The results of a driver in one ability, or in all drives."""

    driver: str
    ability: Ability | None  # None: all drives
    by_weather: Mapping[str, Share]
    changes: Mapping[str, Difference]  # by weather: its share less that of the base weather

    @property
    def all(self) -> Share:
        """The share over all weathers."""
        shares = self.by_weather.values()
        return Share(sum(one.successes for one in shares), sum(one.drives for one in shares))


def base_of(weathers: Sequence[str]) -> str:
    """The weather that the others are compared with: the clear one, else the first."""
    return BASE_WEATHER if BASE_WEATHER in weathers else weathers[0]


def by_ability(
    jobs: Iterable[Job], records: Mapping[str, Record], of: Mapping[str, Collection[Ability]]
) -> list[AbilityRow]:
    """The rows of each driver; `of` has the abilities of the scenarios by name. Empty where none names any."""
    jobs = [job for job in jobs if job.scenario in of]
    abilities = [ability for ability in ABILITIES if any(ability in named for named in of.values())]
    if not abilities:
        return []
    return [
        _row([job for job in jobs if job.driver == driver], records, of, driver, ability)
        for driver in dict.fromkeys(job.driver for job in jobs)
        for ability in (*abilities, None)
    ]


def _row(
    jobs: Sequence[Job],
    records: Mapping[str, Record],
    of: Mapping[str, Collection[Ability]],
    driver: str,
    ability: Ability | None,
) -> AbilityRow:
    found: dict[str, dict[tuple[str, int], bool]] = {}
    for job in jobs:
        if ability is None or ability in of[job.scenario]:
            found.setdefault(job.weather, {})[job.scenario, job.seed] = succeeded(records.get(job.id))
    base = found.get(base_of([job.weather for job in jobs]), {})
    return AbilityRow(
        driver,
        ability,
        {weather: Share(sum(drives.values()), len(drives)) for weather, drives in found.items()},
        {
            weather: _change(drives, base)
            for weather, drives in found.items()
            if drives is not base and drives.keys() & base
        },
    )


def _change(drives: Mapping[tuple[str, int], bool], base: Mapping[tuple[str, int], bool]) -> Difference:
    both = sorted(drives.keys() & base.keys())
    return paired_shares(np.array([drives[one] for one in both]), np.array([base[one] for one in both]))
