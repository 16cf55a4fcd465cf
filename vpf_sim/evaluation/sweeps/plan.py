"""The plan of a sweep: a grid of scenarios, weathers, drivers and seeds."""

from collections.abc import Iterable, Sequence
from hashlib import sha256
from itertools import chain, islice, product
from operator import index
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from vpf_sim import configuration
from vpf_sim.configuration import TomlTable, setting, settings
from vpf_sim.errors import InputError, shown
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_inputs import RunInputs

SHIPPED = ("ablation", "hard")  # plans that come with the package


Drive = tuple[str, str, Annotated[int, Field(ge=0)]]  # scenario, weather and seed
MOST_DIGITS = 18  # of a seed
MOST_SEEDS = 1_000_000  # of one run: more is a typing error and does not fit into memory


def parse_seeds(text: str, where: str = "--seeds") -> Sequence[int]:
    """The seeds that a text names, in its order."""
    parts = text.split(",")
    ranges = [_range(part, text, where, is_listed=len(parts) > 1) for part in parts]
    if sum(found.stop - found.start for found in ranges) > MOST_SEEDS:
        raise InputError(f"{where}: expected at most {MOST_SEEDS} seeds, got '{text[:60]}'")
    return ranges[0] if len(ranges) == 1 else _distinct(chain(*ranges), where)


def seeds_text(seeds: Iterable[int], where: str) -> str:
    """The text of seeds, such as "3:6,9" for 3, 4, 5 and 9; InputError where they are none."""
    try:
        given = [_seed(seed) for seed in islice(seeds, MOST_SEEDS + 1)]
    except (TypeError, ValueError):
        raise InputError(f"{where}: expected whole numbers of up to {MOST_DIGITS} digits, got {shown(seeds)}") from None
    if not 0 < len(given) <= MOST_SEEDS:
        raise InputError(f"{where}: expected 1 to {MOST_SEEDS} seeds, got {shown(seeds)}")
    runs: list[list[int]] = []
    for seed in _distinct(given, where):
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    is_one = len(runs) == 1
    return ",".join(str(run[0]) if len(run) == 1 and not is_one else f"{run[0]}:{run[-1] + 1}" for run in runs)


def _range(part: str, text: str, where: str, is_listed: bool) -> range:
    """The seeds of "A:B", or of "A" in a list."""
    first, colon, last = part.strip().partition(":")
    if is_listed and not colon:
        colon, last = ":", str(int(first) + 1) if _is_number(first) else ""
    if not (colon and _is_number(first) and _is_number(last)):
        form = "A:B and whole numbers, such as 0:5,9" if is_listed else "A:B with whole numbers, such as 1000:1030"
        raise InputError(f"{where}: expected {form}, got '{text[:60]}'")
    seeds = range(int(first), int(last))
    if not seeds:
        raise InputError(f"{where}: expected A:B with A below B, got '{part[:60]}', which holds no seed")
    return seeds


def _is_number(text: str) -> bool:
    return text.isdecimal() and len(text) <= MOST_DIGITS


def _seed(value: object) -> int:
    """A seed as Python's own number, also of numpy's; TypeError or ValueError for anything else."""
    if isinstance(value, bool):
        raise TypeError
    seed = index(value)  # type: ignore[arg-type]  # raises TypeError where it is none
    if not 0 <= seed < 10**MOST_DIGITS:
        raise ValueError
    return seed


def _distinct(seeds: Iterable[int], where: str) -> tuple[int, ...]:
    """The seeds; InputError where one is named twice."""
    given: dict[int, None] = {}
    for seed in seeds:
        if seed in given:
            raise InputError(f"{where}: expected different seeds, got {seed} twice")
        given[seed] = None
    return tuple(given)


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


def read_plan(name_or_path: str) -> TomlTable:
    """The keys and values of a plan of SHIPPED by its name, or of a sweep file."""
    if name_or_path in SHIPPED:
        return configuration.read("vpf_sim.evaluation.sweeps", f"{name_or_path}.toml")
    return configuration.read_file(Path(name_or_path), "sweep")


def make_plan(table: TomlTable, where: str) -> Plan:
    """A validated plan from keys and values; messages call their source `where`."""
    if isinstance(seeds := table.get("seeds"), list):
        table = {**table, "seeds": seeds_text(seeds, f"{where}: seeds")}
    plan = configuration.build(Plan, table, where) if "drives" not in table else _of_drives(table, where)
    if not plan.drives:
        parse_seeds(plan.seeds, f"{where}: seeds")
    return plan


def _of_drives(table: TomlTable, where: str) -> Plan:
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
