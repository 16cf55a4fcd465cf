"""The outcome of an episode, before scoring."""

from dataclasses import dataclass
from typing import Any

from vpf_sim.evaluation.steps import StepTable


@dataclass(frozen=True, slots=True)
class Outcome:
    """The closed loop's result."""

    status: str
    steps: StepTable
    collided_with: str | None
    frames_sha256: str | None  # None: the driver uses no frames
    traceback: str | None = None  # of an exception in the driver or the harness
    invalid_frame: dict[str, Any] | None = None  # its number, `time_s` and fault
