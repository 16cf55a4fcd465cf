"""Fill a run folder with workers, and print how to resume it after an interruption."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.cli import invalid_frames
from vpf_sim.cli.options import prints_on_stderr
from vpf_sim.cli.progress import progress, say
from vpf_sim.cli.run_options import RunOptions
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import Plan, parse_seeds

if TYPE_CHECKING:
    from vpf_sim.evaluation.job import Job
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder


def plan_of(run: RunOptions, asked: bool, make: Callable[[], Plan]) -> Plan:
    """The plan that `make` returns, or the stored one where a run is resumed and nothing else was asked."""
    from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, stored_plan

    if run.seeds is not None:
        parse_seeds(run.seeds)
    if not run.resume or asked or run.out is None or not run.out.exists():
        return make()
    if not (run.out / MANIFEST).exists():
        raise InputError(f"{run.out}: --resume: expected the {MANIFEST} of a run, found none; name what to drive")
    return stored_plan(run.out)


def fill(command: str, plan: Plan, run: RunOptions) -> Path:
    """Drive the missing episodes of a plan, write the summary, and return the run folder."""
    from vpf_sim.evaluation.sweeps import cluster, run_folder, sweep

    run.check()
    limit_s = sweep.limits(run.timeout)
    with prints_on_stderr():
        asked = run_folder.manifest(command, plan)
    with cluster.connected(run.cluster, asked, run.mixed) as client:
        folder = run_folder.RunFolder(run.out or run_folder.new_path(command), asked, run.resume, run.mixed)
        jobs = plan.jobs()
        missing = [job for job in jobs if job.id not in folder.done]
        try:
            if client is None:
                results = sweep.local(folder, missing, run.workers or sweep.default_workers(), limit_s)
            else:
                results = cluster.run(client, folder, missing, limit_s, run.mixed)
            with closing(results), progress(len(jobs), folder) as notify:
                sweep.store(folder, results, notify)
            _summarize(folder, jobs)
        except (KeyboardInterrupt, OSError, InputError):
            say(f"stopped with {len(folder.done)} of {len(jobs)} episodes stored")
            say(f"go on with: {run.resume_command(command, folder.path)}")
            raise
        finally:
            folder.close()
    return folder.path


def _summarize(folder: "RunFolder", jobs: "list[Job]") -> None:
    from vpf_sim.evaluation.analysis.benchmark import with_paper
    from vpf_sim.evaluation.analysis.summary import summarize

    records = folder.records()
    with prints_on_stderr():
        folder.write_json("summary.json", with_paper(summarize(jobs, records)))
    invalid_frames.warn(records)
