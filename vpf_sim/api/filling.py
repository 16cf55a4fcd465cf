"""Drive the missing episodes of a plan into a run folder."""

import sys
from collections.abc import Iterable
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim import system
from vpf_sim.api.progress import Notify, progress, say
from vpf_sim.errors import InputError, is_on_command_line, option
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.system import one_thread

if TYPE_CHECKING:
    from vpf_sim.evaluation.job import Job
    from vpf_sim.evaluation.metrics.records import Record
    from vpf_sim.evaluation.steps import InvalidFrame
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder
    from vpf_sim.evaluation.sweeps.sweep import Results
if TYPE_CHECKING:
    from vpf_sim.evaluation.sweeps.plan import Plan

REMEDY = "give a class that a module defines, without a key"  # its name leads to it


@dataclass(frozen=True, slots=True)
class Execution:
    """By which workers, and into which folder."""

    workers: int | None = None
    timeout: float | None = None  # s, of an episode
    cluster: str | None = None
    out: Path | None = None
    resume: bool = False
    mixed: bool = False

    def check_folder(self) -> None:
        """InputError where there is nothing to resume."""
        if self.resume and self.out is None:
            raise InputError(f"{option('resume')}: expected the folder of the run in {option('out')}, got none")
        if self.resume and self.out is not None and not self.out.exists():
            raise InputError(f"{self.out}: {option('resume')}: expected the folder of a run, found nothing")

    def check(self, plan: "Plan") -> None:
        """InputError where options contradict each other or the drivers of the plan."""
        self.check_folder()
        if self.workers is not None and (type(self.workers) is not int or self.workers < 1):
            raise InputError(f"{option('workers')}: expected a whole number >= 1, got {self.workers!r}")
        if self.timeout is not None and (type(self.timeout) not in (int, float) or not self.timeout > 0.0):
            raise InputError(f"{option('timeout')}: expected seconds > 0, got {self.timeout!r}")
        if self.cluster is not None and not isinstance(self.cluster, str):
            raise InputError(f"{option('cluster')}: expected an address, got {self.cluster!r}")
        if self.cluster is not None and self.workers is not None:
            both = f"{option('workers')} or {option('cluster')}"
            raise InputError(f"{option('workers')}: expected {both}, got both; the cluster has its own workers")
        self._check_process()
        for name in of_this_process(plan)[:1]:
            self._check_bound(name)
        if is_by_hand(plan):
            self._check_by_hand()

    def _check_process(self) -> None:
        """InputError for an option that a process without others cannot meet."""
        from vpf_sim.evaluation import pool

        pool.check_workers(self.workers or 1)
        if self.timeout is not None and not pool.may_start():
            raise InputError(f"{option('timeout')}: expected none in {pool.DAEMONIC}, got {self.timeout:g}")

    def _check_bound(self, driver: str) -> None:
        """InputError for an option that cannot be met with a driver that only this process has."""
        if self.resume:
            raise InputError(
                f"resume: driver '{driver}': expected one whose code can be compared with that of the run; {REMEDY}"
            )
        requested = {"workers": self.workers not in (None, 1), "timeout": self.timeout, "cluster": self.cluster}
        for what in (name for name, value in requested.items() if value):
            raise InputError(f"{what}: driver '{driver}': other processes cannot make it; {REMEDY}")

    def _check_by_hand(self) -> None:
        """InputError for an option that does not suit a person, or without a display."""
        from vpf_sim.drivers import KEYBOARD
        from vpf_sim.window import require_display

        requested = {"workers": self.workers not in (None, 1), "timeout": self.timeout, "cluster": self.cluster}
        for what in (name for name, value in requested.items() if value):
            raise InputError(f"{option(what)}: driver '{KEYBOARD}': a person drives one car, in this process")
        require_display()

    def resume_command(self, command: str, folder: Path) -> str:
        """How to continue the run: a shell command, or the parameters of `vpf_sim.sweep`."""
        if not is_on_command_line():
            return f"vpf_sim.sweep(..., out={str(folder)!r}, resume=True)"
        return system.command(
            command,
            out=folder,
            resume=True,
            workers=self.workers,
            cluster=self.cluster,
            timeout=self.timeout,
            mixed=self.mixed,
        )


def is_by_hand(plan: "Plan") -> bool:
    """Whether a person drives, so that one episode runs at a time."""
    from vpf_sim import drivers

    return drivers.KEYBOARD in plan.driver


def of_this_process(plan: "Plan") -> list[str]:
    """The drivers of a plan that only this process has: instances, and classes of a notebook or script."""
    from vpf_sim import drivers

    return [name for name in plan.driver if not drivers.is_importable(name)]


def fill(command: str, plan: Plan, how: Execution, show: bool = True) -> Path:
    """Drive the missing episodes of a plan, write the summary, and return the run folder.

    `show` prints progress on stderr.
    """
    from vpf_sim.evaluation.sweeps import cluster, run_folder, sweep
    from vpf_sim.evaluation.sweeps.manifest import Manifest

    how.check(plan)
    limit_s = sweep.limits(how.timeout)
    requested, bound = Manifest.of(command, plan), of_this_process(plan)
    is_theirs = how.out is not None and how.out.exists()
    with cluster.connected(how.cluster, requested, how.mixed) as client, one_thread():
        folder = run_folder.RunFolder(how.out or run_folder.new_path(command), requested, how.resume, how.mixed)
        jobs = plan.jobs()
        missing = [job for job in jobs if job.id not in folder.done]
        try:
            results: Results
            if bound or is_by_hand(plan):
                results = sweep.here(folder, missing)
            elif client is None:
                results = sweep.local(folder, missing, how.workers or sweep.default_workers(), limit_s)
            else:
                results = cluster.run(client, folder, missing, limit_s, how.mixed)
            with closing(results), _display(len(jobs), folder, show) as notify:
                sweep.store(folder, results, notify)
            _summarize(folder, jobs)
        except BaseException as error:
            may_go_on = isinstance(error, KeyboardInterrupt | OSError)
            if not (may_go_on or folder.done or how.resume):
                folder.discard(keep_folder=is_theirs)
            elif may_go_on or isinstance(error, InputError):
                say(f"stopped with {len(folder.done)} of {len(jobs)} episodes stored")
                if not bound:
                    say(f"go on with: {how.resume_command(command, folder.path)}")
            raise
        finally:
            folder.close()
    return folder.path


def _display(total: int, folder: "RunFolder", show: bool) -> AbstractContextManager[Notify]:
    return progress(total, folder) if show else nullcontext(lambda _: None)


def _summarize(folder: "RunFolder", jobs: "list[Job]") -> None:
    from vpf_sim.evaluation.analysis.summary import summarize

    records = folder.records()
    folder.write_json("summary.json", summarize(jobs, records, folder.requested.privileged).as_json())
    warn(records)


MOST = 20  # printed lines
WORDS = {
    "black": "all black",
    "constant": "of one colour",
    "wrong shape": "of the wrong shape",
    "stale": "the same as the one before although the car had moved more than 2 cm",
}


def warn(records: Iterable["Record"]) -> None:
    """Print a warning on stderr for each record that ended by an invalid frame."""
    by_frame = (record for record in records if record.status == "invalid_frame")
    ended = [(record.id, invalid) for record in by_frame if (invalid := record.invalid_frame) is not None]
    for episode, invalid in ended[:MOST]:
        print(f"vpf-sim: WARNING: {episode}: {sentence(invalid)}", file=sys.stderr)
    if len(ended) > MOST:
        print(f"vpf-sim: WARNING: and {len(ended) - MOST} more episodes with an invalid frame", file=sys.stderr)
    if ended:
        print("vpf-sim: WARNING: the camera is broken; the scores of these episodes are invalid", file=sys.stderr)


def sentence(invalid: "InvalidFrame") -> str:
    """The number, time and fault of an invalid frame."""
    return f"invalid frame {invalid.frame}, at {invalid.time_s:.3f} s: {WORDS[invalid.fault]}"
