"""What a frame shows of the scene beside the obstacles that perception reports."""

from dataclasses import dataclass

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.perception.obstacles.point_motion import PointMotions
from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a frame shows beside the obstacles that perception reports."""

    crossers: Crossers | None = None  # actors that cross or come
    points: Triangulation | None = None  # of its flow
    motions: PointMotions | None = None  # of the same points
    relief: Floats | None = None  # (K,) of the obstacles, by planar parallax; nan where it is not shown


NO_EVIDENCE = Evidence()
