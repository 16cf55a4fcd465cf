"""The plan of a sweep: a grid of scenarios, weathers, drivers and seeds."""

from collections.abc import Iterable
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.errors import InputError
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.sweeps.seeds import parse_seeds, seeds_text

SHIPPED = ("ablation", "hard")  # plans that come with the package


Drive = tuple[str, str, Annotated[int, Field(ge=0)]]  # scenario, weather and seed


@settings
class Plan:
    """The grid of a sweep, or the single `drives` of it."""

    scenario: tuple[str, ...] = setting("Names or files of the scenarios.", min_length=1)
    weather: tuple[str, ...] = setting("Names or files of the weathers.", min_length=1)
    driver: tuple[str, ...] = setting("Names of the drivers.", min_length=1)
    seeds: str = setting('Seeds as "A:B", without B, or as a list of numbers.')
    drives: tuple[Drive, ...] = setting(
        "Scenario, weather and seed of each single drive, in place of a grid.", default=()
    )

    def jobs(self) -> list[Job]:
        """The planned episodes, seed by seed, so that an interrupted sweep has episodes of every cell."""
        if self.drives:
            jobs = [
                Job(scenario, weather, driver, seed)
                for scenario, weather, seed in self.drives
                for driver in self.driver
            ]
        else:
            grid = product(parse_seeds(self.seeds), self.scenario, self.weather, self.driver)
            jobs = [Job(scenario, weather, driver, seed) for seed, scenario, weather, driver in grid]
        return list(dict.fromkeys(jobs))

    def check(self) -> dict[str, dict[str, str]]:
        """The hashes, and the privilege of each driver, which is created; InputError for an unknown name or file."""
        from vpf_sim import drivers

        privileged: dict[str, str] = {name: drivers.create(name).privileged for name in self.driver}
        return {**self.hashes(), "privileged": privileged}

    def hashes(self, inputs: RunInputs | None = None) -> dict[str, dict[str, str]]:
        """Hashes of the scenarios, the weathers, and the code of users' drivers; of a stored run, by its `inputs`."""
        from vpf_sim.evaluation.sweeps.fingerprint import own_code

        inputs = inputs or RunInputs()
        return {
            "scenarios": self.scenario_hashes(inputs),
            "weathers": {name: _hash(inputs.weather(name)) for name in self.weather},
            "drivers": {name: code for name in self.driver if (code := own_code(inputs.driver(name))) is not None},
        }

    def scenario_hashes(self, inputs: RunInputs | None = None) -> dict[str, str]:
        """Hashes of the scenarios; of a stored run, by its `inputs`."""
        inputs = inputs or RunInputs()
        return {name: _hash(inputs.scenario(name)) for name in self.scenario}

    @classmethod
    def of(cls, job: Job) -> "Plan":
        """The plan of one episode."""
        return cls((job.scenario,), (job.weather,), (job.driver,), f"{job.seed}:{job.seed + 1}")


def read_plan(name_or_path: str) -> dict[str, Any]:
    """The keys and values of a plan of SHIPPED by its name, or of a sweep file."""
    if name_or_path in SHIPPED:
        return configuration.read("vpf_sim.evaluation.sweeps", f"{name_or_path}.toml")
    return configuration.read_file(Path(name_or_path), "sweep")


def make_plan(table: dict[str, Any], where: str) -> Plan:
    """A validated plan from keys and values; messages call their source `where`."""
    if isinstance(seeds := table.get("seeds"), list):
        table = {**table, "seeds": seeds_text(seeds, f"{where}: seeds")}
    plan = configuration.build(Plan, table, where) if "drives" not in table else _of_drives(table, where)
    if not plan.drives:
        parse_seeds(plan.seeds, f"{where}: seeds")
    return plan


def _of_drives(table: dict[str, Any], where: str) -> Plan:
    """The plan of single drives, with the smallest grid that contains them."""
    drives = configuration.build(_Drives, {"drives": table["drives"]}, where).drives
    names = [[*dict.fromkeys(drive[i] for drive in drives)] for i in (0, 1)]
    seeds = sorted(drive[2] for drive in drives)
    grid = {"scenario": names[0], "weather": names[1], "seeds": f"{seeds[0]}:{seeds[-1] + 1}"}
    for key, value in grid.items():
        if table.get(key, value) != value:
            raise InputError(f"{where}: {key}: expected drives or a grid, got both")
    return configuration.build(Plan, {**table, **grid}, where)


@settings
class _Drives:
    drives: tuple[Drive, ...] = setting("Scenario, weather and seed of each single drive.", min_length=1)


def _hash(value: Iterable[Any] | Any) -> str:
    return sha256(repr(value).encode()).hexdigest()
