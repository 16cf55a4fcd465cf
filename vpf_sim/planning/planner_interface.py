"""What a vision driver plans with."""

from abc import ABC, abstractmethod
from math import inf

from vpf_sim.driver_interface import Observation
from vpf_sim.scene.evidence import Evidence
from vpf_sim.types import Force, Perception, PlanDetails, Reference

Planned = tuple[Force, Reference, PlanDetails]


class Planner(ABC):
    """A planner during one episode; each step calls `observe`, then `step`."""

    def observe(self, perception: Perception, observation: Observation, evidence: Evidence | None) -> Perception:  # noqa: ARG002
        """The perception as it is planned on; `evidence` is that of a frame processed now, else None."""
        return perception

    @abstractmethod
    def step(self, perception: Perception, observation: Observation, limit_mps: float = inf) -> Planned:
        """Fields at the vehicle, and heading and speed reference, whose target is at most `limit_mps`."""
