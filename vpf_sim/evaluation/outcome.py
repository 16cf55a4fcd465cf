"""How an episode went, before any score."""

from dataclasses import dataclass
from typing import Any

from vpf_sim.evaluation.steps import StepTable


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the loop leaves, and what a run folder keeps of it."""

    status: str
    steps: StepTable
    collided_with: str | None
    frames_sha256: str | None  # None: the driver was shown no frame
    traceback: str | None = None  # of our own or the driver's exception
    invalid_frame: dict[str, Any] | None = None  # its number, `time_s` and what was wrong with it
