"""The results of several runs as one Markdown page: scores by cell, and what each run drove."""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from vpf_sim import drivers
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.registry import AT_FAULT, COLLISIONS, SUCCESS, columns
from vpf_sim.evaluation.sweeps.fingerprint import commit_of
from vpf_sim.evaluation.sweeps.plan import Plan, parse_seeds
from vpf_sim.reporting import abilities
from vpf_sim.reporting.kit.page import NONE, Cell, Table, Value
from vpf_sim.reporting.main_table import cell, driver_row, shown, text_of
from vpf_sim.reporting.run_data import RunData, open_run
from vpf_sim.reporting.tables import OBJECTS, PERCEPTION, perception

DEVELOPMENT_SEEDS_BELOW = 1000
SCORES = columns("results")
HEAD = """# Results

`vpf-sim results RUN... --out docs/results.md` writes this page from run folders. [reference.md](reference.md#scores)
defines the scores. Success is a share of all planned episodes, and collisions are counted in all driven ones. The other
scores are means over the successful episodes; the driving score is over all. The second line of a cell is the 95 %
interval. Path MSE includes the detour around obstacles. Perception in (brackets) is of episodes that did not arrive,
where none did.
"""


def make(paths: Iterable[Path]) -> str:
    """The page. InputError for a folder that is no run."""
    subjects = [RunData.of(open_run(path)) for path in paths]
    perceived = [*_perceived(subjects)]
    parts = [HEAD, "## Driving\n", *_driving(subjects)]
    parts += _section("Abilities", [abilities.abilities(subject) for subject in subjects])
    parts += _section("Why episodes failed", [abilities.failure_classes(subject) for subject in subjects])
    parts += ["\n## Perception against ground truth", *perceived] if perceived else []
    parts += ["\n## Runs\n", *_runs(subjects)]
    return "\n".join(parts) + "\n"


def _section(title: str, tables: Sequence[Table | None]) -> list[str]:
    """The tables of the runs that have one, under a title."""
    lines = [line for table in tables if table is not None for line in ("", *table.markdown())]
    return [f"\n## {title}", *lines] if lines else []


def _driving(subjects: Sequence[RunData]) -> Iterator[str]:
    headings = [metric.heading for metric in SCORES]
    header = ("scenario", "weather", "driver", "seeds", "success, %", "collisions (at fault)", *headings)
    rows = tuple(_cells(row, subject.plan) for subject in subjects for row in subject.rows)
    yield from Table(header, rows, names=4).markdown()


def _cells(row: Row, plan: Plan) -> tuple[Cell, ...]:
    found = driver_row(row)
    driver = found.driver if found.privileged == "none" else f"{found.driver}, knows the {found.privileged}"
    share = f"{text_of(SUCCESS, row[SUCCESS])} ({found.successes} of {found.episodes})"
    collisions = f"{text_of(COLLISIONS, row[COLLISIONS])} ({text_of(AT_FAULT, row[AT_FAULT])})"
    success = Value(share, "; ".join(filter(None, (found.interval, found.endings))))
    names = (shown(row.scenario), shown(row.weather), driver, _seeds(plan))
    return (*names, success, collisions, *(cell(row, metric) for metric in SCORES))


def _perceived(subjects: Sequence[RunData]) -> Iterator[str]:
    """Tables of the runs that have ground truth of perception, one for each set of columns."""
    found: dict[tuple[str, ...], list[tuple[Cell, ...]]] = {}
    for subject in subjects:
        for labels in (OBJECTS, PERCEPTION):
            table = perception(subject.rows, subject.order, labels)
            if table is not None:
                header = (*table.header[: table.names], "seeds", *table.header[table.names :])
                for row in table.rows:
                    cells = (*row[: table.names], _seeds(subject.plan), *row[table.names :])
                    found.setdefault(header, []).append(cells)
    for header, rows in found.items():
        yield from ("", *Table(header, tuple(rows), names=4).markdown())


def _runs(subjects: Sequence[RunData]) -> Iterator[str]:
    header = ("seeds", "used for", "episodes driven", "vpf_sim", "sources", "commit")
    yield from Table(header, tuple(map(_run, subjects)), names=2).markdown()
    commands = dict.fromkeys(_commands(subjects))
    yield from ("", "```sh", *commands, "```") if commands else ()


def _run(subject: RunData) -> tuple[str, ...]:
    made = subject.run.manifest.fingerprint
    sources = str(made.get("source", NONE))
    driven = f"{len(subject.records)} of {len(subject.jobs)}"
    version = (str(made.get("vpf_sim", NONE)), sources[:12], commit_of(sources) or NONE)
    return (_seeds(subject.plan), _purpose(subject.plan), driven, *version)


def _commands(subjects: Iterable[RunData]) -> Iterator[str]:
    """The commands that drive the same again.

    Single drives have none, but a sweep file; nor have drivers of a notebook or script.
    """
    for subject in subjects:
        plan, is_benchmark = subject.plan, subject.command == "benchmark"
        named = [name for name in plan.driver if drivers.has_name(name)]
        if plan.drives or not named:
            continue
        grid = () if is_benchmark else (("--scenario", plan.scenario), ("--weather", plan.weather))
        options = (*grid, ("--driver", named), ("--seeds", (plan.seeds,)))
        words = [word for option, values in options for value in values for word in (option, value)]
        yield shlex.join(["vpf-sim", "benchmark" if is_benchmark else "sweep", *words])


def _seeds(plan: Plan) -> str:
    return f"{len(plan.drives)} drives" if plan.drives else plan.seeds


def _purpose(plan: Plan) -> str:
    """What a block of seeds is for, by the project's rule."""
    first = min(drive[2] for drive in plan.drives) if plan.drives else min(parse_seeds(plan.seeds))
    return "development" if first < DEVELOPMENT_SEEDS_BELOW else "evaluation"
