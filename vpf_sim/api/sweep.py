"""A grid of episodes."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from vpf_sim import drivers
from vpf_sim.api.arguments import StrPath, text, texts
from vpf_sim.api.filling import Execution, fill
from vpf_sim.api.run import Run
from vpf_sim.drivers import DriverLike
from vpf_sim.errors import InputError, shown
from vpf_sim.evaluation.sweeps import run_folder
from vpf_sim.evaluation.sweeps.plan import make_plan, seeds_text

Drivers: TypeAlias = DriverLike | Iterable[DriverLike] | Mapping[str, DriverLike]


def sweep(
    scenario: StrPath | Iterable[StrPath] = "town04",
    *,
    driver: Drivers = "vpf",
    weather: StrPath | Iterable[StrPath] = "clear",
    seeds: str | Iterable[int] = "0:5",
    workers: int | None = None,
    timeout: float | None = None,
    cluster: str | None = None,
    out: StrPath | None = None,
    resume: bool = False,
    mixed: bool = False,
    progress: bool = True,
) -> Run:
    """Drive every scenario in every weather with every driver and seed, and store them in a run folder.

    >>> run = vpf_sim.sweep("town04", driver=["vpf", MyDriver], weather=["clear", "rain"], seeds=range(10))
    >>> run.table[["weather", "driver", "success_rate"]]

    Of each kind, one or several are given, as to `drive`. Drivers in a mapping are called by its keys, as are two
    instances of one class: `driver={"slow": MyDriver(4.0), "fast": MyDriver(8.0)}`. Seeds are "A:B", without B,
    or numbers, as in a list or a range. Worker processes drive side by side, by default one per core. They cannot
    import instances, nor classes of a notebook or script: with any of these, all episodes are driven in this process,
    one after another, as in a worker of multiprocessing.Pool, which may start no processes. `timeout` is the time limit
    of an episode in s, by default from its scenario. `cluster` is the address of a Dask scheduler, whose workers drive
    instead. `out` is the run folder, by default a new one under runs/; with `resume` it is continued, with `mixed` also
    by another version or machine. `progress` prints a line for each episode on stderr, or a bar on a terminal.
    Raises InputError for an unknown name, an unusable file or a class that is no driver.
    """
    table = {
        "scenario": texts("scenario", scenario),
        "weather": texts("weather", weather),
        "driver": _names(driver),
        "seeds": seeds if isinstance(seeds, str) else seeds_text(seeds, "seeds"),
    }
    folder = None if out is None else run_folder.located(Path(text("out", out)))
    how = Execution(workers, timeout, cluster, folder, resume, mixed)
    return Run(fill("sweep", make_plan(table, "sweep"), how, progress))


def _names(given: Drivers) -> list[str]:
    """The names of drivers; those that no name leads to are kept for this process."""
    is_one = isinstance(given, str | type) or hasattr(given, "act") or not isinstance(given, Iterable)
    several: Any = [given] if is_one else given
    named = [*several.items()] if isinstance(several, Mapping) else [(drivers.name_of(one), one) for one in several]
    known: dict[str, DriverLike] = {}
    for name, one in named:
        if name in known and known[name] is not one and name != one:
            raise InputError(f"driver: two are called '{name}'; name them: driver={{'a': ..., 'b': ...}}")
        if isinstance(several, Mapping) and name != one:
            _check_key(name, one)
        known[name] = one
        drivers.admit(name, one)
    return list(known)


def _check_key(key: object, driver: DriverLike) -> None:
    """InputError for a key of a mapping that means another driver, or whose driver has a name already."""
    if not isinstance(key, str):
        raise InputError(f"driver: expected names as keys, got {shown(key)}")
    if key in drivers.names() or ":" in key or key.startswith(drivers.VARIANT_PREFIX):
        raise InputError(f"driver: '{key}' is the name of another driver; choose another key")
    if isinstance(driver, str):
        raise InputError(f"driver: '{key}': expected a class or an instance, got '{driver}'; give names in a list")
