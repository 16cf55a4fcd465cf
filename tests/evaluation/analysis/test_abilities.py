"""Success by ability: which drives count where, and what is paired with what."""

from itertools import product

import pytest
import stored

from vpf_sim import scenarios
from vpf_sim.evaluation.analysis.abilities import ABILITIES, AbilityRow, by_ability
from vpf_sim.evaluation.analysis.statistics import share_interval
from vpf_sim.evaluation.job import Job
from vpf_sim.scenarios import Ability

OF: dict[str, tuple[Ability, ...]] = {"one": ("follow", "cut-in"), "two": ("follow",), "three": ()}
SEEDS = range(4)
LOST = {("one", "rain", 0), ("one", "rain", 1), ("two", "rain", 0), ("two", "clear", 3), ("three", "clear", 0)}


def rows(of: dict[str, tuple[Ability, ...]] = OF, weathers: tuple[str, ...] = ("clear", "rain")) -> list[AbilityRow]:
    jobs = [Job(*place, "vpf", seed) for *place, seed in product(("one", "two", "three"), weathers, SEEDS)]
    made = [
        stored.record(job, status="stuck" if (job.scenario, job.weather, job.seed) in LOST else "success")
        for job in jobs
        if job != Job("two", "rain", "vpf", 2)  # not driven
    ]
    return by_ability(jobs, {record.id: record for record in stored.records(made)}, of)


def test_a_drive_counts_for_each_ability_of_its_scenario() -> None:
    follow, cut_in, together = rows()
    shares = {weather: (one.successes, one.drives) for weather, one in follow.by_weather.items()}
    assert (follow.ability, shares) == ("follow", {"clear": (7, 8), "rain": (4, 8)})
    shares = {weather: (one.successes, one.drives) for weather, one in cut_in.by_weather.items()}
    assert (cut_in.ability, shares) == ("cut-in", {"clear": (4, 4), "rain": (2, 4)})
    assert (together.ability, together.all.successes, together.all.drives) == (None, 10 + 8, 24)
    assert follow.all.interval == share_interval(11, 16)


def test_weathers_are_paired_by_scenario_and_seed() -> None:
    """Lost in rain alone: 4 of 8; in clear weather alone: 1 of 8."""
    follow, cut_in, _ = rows()
    assert follow.changes.keys() == {"rain"}
    assert (follow.changes["rain"].difference, follow.changes["rain"].pairs) == (pytest.approx((1 - 4) / 8), 8)
    assert cut_in.changes["rain"].difference == pytest.approx(-0.5)


def test_one_weather_has_nothing_to_compare() -> None:
    assert all(not row.changes for row in rows(weathers=("rain",)))


def test_scenarios_without_abilities_have_no_rows() -> None:
    assert rows({"one": (), "two": (), "three": ()}) == []


def test_the_catalog_names_abilities_and_hard_has_all_of_them() -> None:
    from vpf_sim.evaluation.sweeps.plan import read_plan

    unnamed = {name for name in scenarios.names() if not scenarios.load(name).abilities}
    assert unnamed == {"blocked"}  # it is driven to stop
    hard = read_plan("hard")["scenario"]
    assert {ability for name in hard for ability in scenarios.load(name).abilities} == {*ABILITIES}
