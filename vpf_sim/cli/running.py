"""What `sweep` and `benchmark` share: a run folder filled by workers, and a way back after whatever stopped it."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim import shell
from vpf_sim.cli import invalid_frames
from vpf_sim.cli.options import prints_on_stderr
from vpf_sim.cli.progress import progress, say
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import Plan

if TYPE_CHECKING:
    from vpf_sim.evaluation.job import Job
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder


@dataclass(frozen=True, slots=True)
class Means:
    """How a plan is to be driven: where to, and by whom."""

    out: Path | None = None
    resume: bool = False
    mixed: bool = False
    workers: int | None = None
    timeout_s: float | None = None
    cluster: str | None = None

    def check(self) -> None:
        """InputError where they do not fit together."""
        if self.resume and self.out is None:
            raise InputError("--resume: expected the folder of the run in --out, got none")
        if self.resume and self.out is not None and not self.out.exists():
            raise InputError(f"{self.out}: --resume: expected the folder of a run, found nothing")
        if self.cluster is not None and self.workers is not None:
            raise InputError("--workers: the cluster's workers drive, expected --workers or --cluster, got both")

    def way_back(self, command: str, folder: Path) -> str:
        """The command that goes on with the run."""
        return shell.command(
            command,
            out=folder,
            resume=True,
            workers=self.workers,
            cluster=self.cluster,
            timeout=self.timeout_s,
            mixed=self.mixed,
        )


def plan_of(out: Path | None, resume: bool, asked: bool, make: Callable[[], Plan]) -> Plan:
    """The plan that `make` gives; of a run that goes on without anything else asked, the one it was made for."""
    from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, stored_plan

    if not resume or asked or out is None or not out.exists():
        return make()
    if not (out / MANIFEST).exists():
        raise InputError(f"{out}: --resume: expected the {MANIFEST} of a run, found none; say what is to be driven")
    return stored_plan(out)


def fill(command: str, plan: Plan, means: Means) -> Path:
    """Drive what the run folder lacks of the plan, write its summary, and give its path."""
    from vpf_sim.evaluation.sweeps import cluster, run_folder, sweep

    means.check()
    limit_s = sweep.limits(means.timeout_s)
    with prints_on_stderr():
        asked = run_folder.manifest(command, plan)
    with cluster.connected(means.cluster, asked, means.mixed) as client:
        folder = run_folder.RunFolder(means.out or run_folder.new_path(command), asked, means.resume, means.mixed)
        jobs = plan.jobs()
        missing = [job for job in jobs if job.id not in folder.done]
        try:
            if client is None:
                results = sweep.local(folder, missing, means.workers or sweep.default_workers(), limit_s)
            else:
                results = cluster.run(client, folder, missing, limit_s, means.mixed)
            with closing(results), progress(len(jobs), folder) as tell:
                sweep.store(folder, results, tell)
            _summarize(folder, jobs)
        except (KeyboardInterrupt, OSError, InputError):
            say(f"stopped with {len(folder.done)} of {len(jobs)} episodes stored")
            say(f"go on with: {means.way_back(command, folder.path)}")
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
