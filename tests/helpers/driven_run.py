"""Runs whose episodes are driven in this process, one after the other."""

from collections.abc import Callable
from pathlib import Path

from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.metrics.records import Timing, unscored
from vpf_sim.evaluation.sweeps.manifest import Manifest
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder
from vpf_sim.types import Image
from vpf_sim.types import Plan as DrivingPlan

Watch = Callable[[Image, DrivingPlan | None], None]


def drive_run(path: Path, plan: Plan, watch: Watch | None = None, lost: int = 0) -> Path:
    """The folder of a plan's episodes, of which the last `lost` ended by a worker's death."""
    folder, jobs = RunFolder(path, Manifest.of("sweep", plan)), plan.jobs()
    for job in jobs[: len(jobs) - lost]:
        result = episode.run(*job, watch=watch)
        steps.write(result.steps, path / "steps" / f"{job.id}.parquet")
        folder.add(result.record, result.timing)
    for job in jobs[len(jobs) - lost :]:
        folder.add(unscored(job), Timing(id=job.id))
    folder.write_json("summary.json", summarize(jobs, folder.records()).as_json())
    folder.close()
    return path
