"""The outcome of an episode, before scoring."""

from dataclasses import dataclass

from pydantic import BaseModel

from vpf_sim.evaluation.steps import StepTable


class InvalidFrame(BaseModel, frozen=True, strict=True):
    """The camera frame that ended an episode."""

    frame: int
    time_s: float
    fault: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """The closed loop's result."""

    status: str
    steps: StepTable
    collided_with: str | None
    frames_sha256: str | None  # None: the driver uses no frames
    traceback: str | None = None  # of an exception in the driver or the harness
    invalid_frame: InvalidFrame | None = None
