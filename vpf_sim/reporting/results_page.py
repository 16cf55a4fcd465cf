"""The results of several runs as one Markdown page: scores by cell, and what each run drove."""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from vpf_sim import drivers
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.registry import AT_FAULT, COLLISIONS, SUCCESS, columns
from vpf_sim.evaluation.sweeps.fingerprint import commit_of
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.seeds import parse_seeds
from vpf_sim.reporting.cells import NONE, cell, driver_row, shown, text_of
from vpf_sim.reporting.run_data import RunData
from vpf_sim.reporting.stored_run import open_run
from vpf_sim.reporting.tables import OBJECTS, PERCEPTION, perception

DEVELOPMENT_SEEDS_BELOW = 1000
SCORES = columns("results")
HEAD = """# Results

`vpf-sim results RUN... --out docs/results.md` writes this page from run folders. [reference.md](reference.md#scores)
defines the scores. Success is a share of all planned episodes, and collisions are counted in all driven ones. The other
scores are means over the successful episodes; the driving score is over all. The second line of a cell is the 95 %
interval. Path MSE includes the way around obstacles. Perception in (brackets) is of episodes that did not arrive, where
none did.
"""


def make(paths: Iterable[Path]) -> str:
    """The page. InputError for a folder that is no run."""
    subjects = [RunData.of(open_run(path)) for path in paths]
    perceived = [*_perceived(subjects)]
    parts = [HEAD, "## Driving\n", *_driving(subjects)]
    parts += ["\n## Perception against ground truth", *perceived] if perceived else []
    parts += ["\n## Runs\n", *_runs(subjects)]
    return "\n".join(parts) + "\n"


def _driving(subjects: Sequence[RunData]) -> Iterator[str]:
    headings = [metric.heading for metric in SCORES]
    yield from _head(("scenario", "weather", "driver", "seeds", "success, %", "collisions (at fault)", *headings), 4)
    for subject in subjects:
        yield from (_line(_cells(row, subject.plan)) for row in subject.rows)


def _cells(row: Row, plan: Plan) -> list[str]:
    found = driver_row(row)
    driver = found.driver if found.privileged == "none" else f"{found.driver}, knows the {found.privileged}"
    share = f"{text_of(SUCCESS, row[SUCCESS])} ({found.successes} of {found.episodes})"
    collisions = f"{text_of(COLLISIONS, row[COLLISIONS])} ({text_of(AT_FAULT, row[AT_FAULT])})"
    success = _below(share, "; ".join(filter(None, (found.interval, found.endings))))
    names = [shown(row.scenario), shown(row.weather), driver, _seeds(plan)]
    return [*names, success, collisions, *_scores(row)]


def _scores(row: Row) -> Iterator[str]:
    for metric in SCORES:
        found = cell(row, metric)
        yield _below(found.text, found.interval)


def _perceived(subjects: Sequence[RunData]) -> Iterator[str]:
    """Tables of the runs that have ground truth of perception, one for each set of columns."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for subject in subjects:
        for labels in (OBJECTS, PERCEPTION):
            table = perception(subject.rows, subject.order, labels)
            if table is not None:
                header = (*table.header[: table.names], "seeds", *table.header[table.names :])
                lines = rows.setdefault(header, [*_head(header, table.names + 1)])
                for row in table.rows:
                    cells = [_below(value.text, value.beside) for value in row]
                    lines.append(_line([*cells[: table.names], _seeds(subject.plan), *cells[table.names :]]))
    for lines in rows.values():
        yield from ("", *lines)


def _runs(subjects: Sequence[RunData]) -> Iterator[str]:
    yield from _head(("seeds", "used for", "episodes driven", "vpf_sim", "sources", "commit"), 2)
    for subject in subjects:
        made = subject.run.manifest.fingerprint
        sources = str(made.get("source", NONE))
        driven = f"{len(subject.records)} of {len(subject.jobs)}"
        used = [_seeds(subject.plan), _purpose(subject.plan), driven]
        yield _line([*used, str(made.get("vpf_sim", NONE)), sources[:12], commit_of(sources) or NONE])
    commands = dict.fromkeys(_commands(subjects))
    yield from ("", "```sh", *commands, "```") if commands else ()


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


def _head(header: Sequence[str], names: int) -> Iterator[str]:
    yield _line(header)
    yield _line(["---" if i < names else "---:" for i in range(len(header))])


def _line(cells: Sequence[str]) -> str:
    escaped = [one.replace("|", "\\|") for one in cells]
    return f"| {' | '.join(escaped)} |"


def _below(words: str, beside: str) -> str:
    return f"{words}<br>{beside}" if beside else words
