"""Export a run: its episodes, drawn again by worker processes, as one data set with a data sheet."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from vpf_sim.datasets import datasheet
from vpf_sim.datasets.formats import Format, Place, Written
from vpf_sim.datasets.played_episode import Contents, Episode, task_of
from vpf_sim.errors import InputError, option, unknown_name
from vpf_sim.evaluation import pool
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.files import new_folder, write_text
from vpf_sim.reporting.run_data import RunData, StoredRun

Task = tuple[Place, Record]


@dataclass(frozen=True, slots=True)
class Exported:
    """A data set on disk."""

    path: Path
    format: str
    episodes: int
    frames: int  #: with an action
    left_out: dict[str, str]  #: why, by the id of the episode
    remarks: list[str]  #: how the set differs from the run, or the run from its plan


def export(
    data: RunData,
    format_name: str,
    form: Format,
    out: Path,
    contents: Contents,
    statuses: Sequence[str],
    workers: int,
    notify: Callable[[str], None],
) -> Exported:
    """Write the set into a new folder, which is complete or absent; `notify` gets a line for each episode."""
    form.check(contents)
    chosen, left_out = choose(data, statuses)
    tasks = _placed(chosen)
    with new_folder(out) as folder:
        written: list[Written] = []
        work = partial(write_episode, folder, data.run, form, contents)
        with closing(pool.run(work, tasks, workers)) as results:
            for done in results:
                if done.result is None:
                    raise InputError(f"{done.task[1].id}: {done.reason.splitlines()[0]}")
                written.append(done.result)
                notify(f"{len(written)}/{len(tasks)} {done.task[1].id}")
        written.sort(key=lambda one: one.place)
        _check_rate(written)
        form.finish(folder, out.name, written, contents)
        remarks = _remarks(data, written)
        sheet = datasheet.make(form.head, data.run, format_name, contents, written, left_out, remarks)
        write_text(folder / "README.md", sheet)
    frames = sum(one.length for one in written)
    return Exported(out, format_name, len(written), frames, left_out, remarks)


def choose(data: RunData, statuses: Sequence[str]) -> tuple[list[Record], dict[str, str]]:
    """The driven episodes in the order of the plan, and why the others are left out, by id."""
    records = [data.records[job.id] for job in data.jobs if job.id in data.records]
    ended = {record.status for record in records}
    for status in statuses:
        if status not in ended:
            raise unknown_name(f"status of the episodes of {data.run.path}", status, ended)
    left_out = {}
    for record in records:
        if not record.steps:
            left_out[record.id] = f"never began ({record.status})"
        elif statuses and record.status not in statuses:
            left_out[record.id] = f"ended in {record.status}"
    chosen = [record for record in records if record.id not in left_out]
    if not chosen:
        raise InputError(f"{data.run.path}: expected at least one driven episode to export, got none")
    return chosen, left_out


def write_episode(folder: Path, run: StoredRun, form: Format, contents: Contents, task: Task) -> Written:
    """Store one episode, in a worker process."""
    place, record = task
    table = run.steps(record.id)
    if table is None or len(table) != record.steps:
        got = f"got {len(table)}" if table is not None else f"but it {run.why_no_steps(record.id)}"
        raise InputError(f"{record.id}: expected the {record.steps} steps of its record, {got}")
    episode = Episode(record, table, contents, run.inputs)
    details = form.write(folder, place, episode)
    remarks = tuple(f"{record.id}: {remark}" for remark in episode.remarks)
    return Written(place, record, len(episode), episode.rate_hz, task_of(record), remarks, episode.is_verified, details)


def _placed(records: Sequence[Record]) -> list[Task]:
    """Each record with its place in the set."""
    tasks: list[Task] = []
    indices: dict[str, int] = {}
    first = 0
    for index, record in enumerate(records):
        task_index = indices.setdefault(task_of(record), len(indices))
        tasks.append((Place(index, first, task_index), record))
        first += record.steps
    return tasks


def _check_rate(written: Sequence[Written]) -> None:
    rates = sorted({one.rate_hz for one in written})
    if len(rates) > 1:
        got = " and ".join(f"{rate:g}" for rate in rates)
        raise InputError(f"{option('format')}: expected episodes of one step rate, got {got} Hz")


def _remarks(data: RunData, written: Sequence[Written]) -> list[str]:
    """How the set differs from the run, and the run from its plan."""
    remarks = [remark for one in written for remark in one.remarks]
    drawn = {*data.plan.scenario, *data.plan.weather}
    remarks += [f"{name}: changed since the run" for name in sorted(drawn & data.changed())]
    if len(data.records) < len(data.jobs):
        remarks.append(f"the run is not complete: {len(data.records)} of {len(data.jobs)} episodes are driven")
    return remarks


def as_json(found: Exported) -> Json:
    """What the command line prints."""
    return {
        "out": str(found.path),
        "format": found.format,
        "episodes": found.episodes,
        "frames": found.frames,
        "left_out": found.left_out,
        "remarks": found.remarks,
    }
