"""How the episodes of a plan are driven."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim import shell
from vpf_sim.errors import InputError

if TYPE_CHECKING:
    from vpf_sim.evaluation.sweeps.plan import Plan


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
            raise InputError("--resume: expected the folder of the run in --out, got none")
        if self.resume and self.out is not None and not self.out.exists():
            raise InputError(f"{self.out}: --resume: expected the folder of a run, found nothing")

    def check(self, plan: "Plan") -> None:
        """InputError where options contradict each other or the drivers of the plan."""
        self.check_folder()
        if self.workers is not None and (type(self.workers) is not int or self.workers < 1):
            raise InputError(f"workers: expected a whole number >= 1, got {self.workers!r}")
        if self.timeout is not None and (type(self.timeout) not in (int, float) or not self.timeout > 0.0):
            raise InputError(f"timeout: expected seconds > 0, got {self.timeout!r}")
        if self.cluster is not None and self.workers is not None:
            raise InputError("--workers: expected --workers or --cluster, got both; the cluster has its own workers")
        bound = of_this_process(plan)
        if bound and (self.workers not in (None, 1) or self.timeout or self.cluster or self.resume):
            raise InputError(
                f"driver '{bound[0]}': other processes cannot import it, so it is driven in this one, without "
                "workers, timeout, cluster and resume; for these, put its class into a module"
            )

    def resume_command(self, command: str, folder: Path) -> str:
        """The shell command that continues the run."""
        return shell.command(
            command,
            out=folder,
            resume=True,
            workers=self.workers,
            cluster=self.cluster,
            timeout=self.timeout,
            mixed=self.mixed,
        )


def of_this_process(plan: "Plan") -> list[str]:
    """The drivers of a plan that only this process has: instances, and classes of a notebook or script."""
    from vpf_sim import drivers

    return [name for name in plan.driver if not drivers.is_importable(name)]
