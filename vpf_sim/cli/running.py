"""What `sweep` and `benchmark` share: a run folder filled by workers, with progress, and a way back after Ctrl-C."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from vpf_sim.cli import invalid_frames
from vpf_sim.cli.options import prints_on_stderr
from vpf_sim.errors import InputError
from vpf_sim.evaluation.plan import Plan

Record = dict[str, Any]


def plan_of(out: Path | None, resume: bool, asked: bool, make: Callable[[], Plan]) -> Plan:
    """The plan that `make` gives; of a run that goes on without anything else asked, the one it was made for."""
    from vpf_sim.evaluation.run_folder import MANIFEST, stored_plan

    if resume and not asked and out is not None and (out / MANIFEST).exists():
        return stored_plan(out)
    return make()


def fill(command: str, plan: Plan, out: Path | None, resume: bool, mixed: bool, workers: int | None) -> Path:
    """Drive what the run folder lacks of the plan, write its summary, and give its path."""
    from vpf_sim.evaluation import run_folder, sweep
    from vpf_sim.evaluation.benchmark import with_paper
    from vpf_sim.evaluation.summary import summarize

    if resume and out is None:
        raise InputError("--resume: expected the folder of the run in --out, got none")
    if resume and out is not None and not out.exists():
        raise InputError(f"{out}: --resume: expected the folder of a run, found nothing")
    with prints_on_stderr():
        asked = run_folder.manifest(command, plan)
    folder = run_folder.RunFolder(out or run_folder.new_path(command), asked, resume, mixed)
    jobs = plan.jobs()
    try:
        with progress(len(jobs), len(folder.done)) as tell:
            sweep.run(folder, jobs, workers or sweep.default_workers(), tell)
    except KeyboardInterrupt:
        _say(f"stopped with {len(folder.done)} of {len(jobs)} episodes stored")
        _say(f"go on with: vpf-sim {command} --out {folder.path} --resume")
        raise
    finally:
        folder.close()
    records = folder.records()
    with prints_on_stderr():
        summary = with_paper(summarize(jobs, records))
    invalid_frames.warn(records)
    folder.write_json("summary.json", summary)
    return folder.path


@contextmanager
def progress(total: int, done: int) -> Iterator[Callable[[Record], None]]:
    """A function to be told of each record: a bar on a terminal, lines elsewhere; on stderr, for stdout has answers."""
    if sys.stderr.isatty():
        with _bar(total, done) as tell:
            yield tell
        return
    count = done

    def tell_line(record: Record) -> None:
        nonlocal count
        count += 1
        _say(f"{count}/{total} {record['id']} {record['status']}")

    yield tell_line


@contextmanager
def _bar(total: int, done: int) -> Iterator[Callable[[Record], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    failures = 0
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("no episode yet", total=total, completed=done)

        def tell(record: Record) -> None:
            nonlocal failures
            failures += record["status"] != "success"
            bar.update(task, advance=1, description=f"{failures} without success, last {record['id']}")

        yield tell


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
