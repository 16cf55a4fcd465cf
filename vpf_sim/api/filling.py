"""Drive the missing episodes of a plan into a run folder."""

import sys
from collections.abc import Iterable
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.api.execution import Execution, is_by_hand, of_this_process
from vpf_sim.api.progress import Notify, progress, say
from vpf_sim.errors import InputError
from vpf_sim.evaluation.processes.threads import one_thread
from vpf_sim.evaluation.sweeps.plan import Plan

if TYPE_CHECKING:
    from vpf_sim.evaluation.job import Job
    from vpf_sim.evaluation.metrics.records import Record
    from vpf_sim.evaluation.outcome import InvalidFrame
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder
    from vpf_sim.evaluation.sweeps.sweep import Results


def fill(command: str, plan: Plan, how: Execution, show: bool = True) -> Path:
    """Drive the missing episodes of a plan, write the summary, and return the run folder.

    `show` prints progress on stderr.
    """
    from vpf_sim.evaluation.sweeps import cluster, run_folder, sweep
    from vpf_sim.evaluation.sweeps.manifest import Manifest

    how.check(plan)
    limit_s = sweep.limits(how.timeout)
    asked, bound = Manifest.of(command, plan), of_this_process(plan)
    is_theirs = how.out is not None and how.out.exists()
    with cluster.connected(how.cluster, asked, how.mixed) as client, one_thread():
        folder = run_folder.RunFolder(how.out or run_folder.new_path(command), asked, how.resume, how.mixed)
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
    folder.write_json("summary.json", summarize(jobs, records, folder.asked.privileged).as_json())
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
