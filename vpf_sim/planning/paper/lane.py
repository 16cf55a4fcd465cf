"""Lane coordinates, in which the paper's planner works.

`y` is measured across the road from the middle of the own lane, + is right. The camera's road edges give the
transformation; no map is used.
"""

from dataclasses import dataclass

from vpf_sim.geometry import bounded
from vpf_sim.types import RoadEdges

# Bounds of lane coordinates, far beyond any road: sums and squares of them stay finite.
FAR_M, SHARPEST_PER_M, TURNED_RAD = 1e4, 1.0, 4.0


@dataclass(frozen=True, slots=True)
class Lane:
    """Pose of the vehicle on the road, as the camera sees it."""

    y_m: float  # of the pose
    right_m: float  # y of the right edge
    left_m: float  # y of the left edge
    heading_rad: float  # direction of the road minus yaw
    curvature_per_m: float  # of the road at the pose, + bends right


def locate(road: RoadEdges) -> Lane:
    """Pose on the road; the preferred position is the middle of the own lane."""
    lane_m = bounded(road.lane_m, FAR_M)
    left, right = bounded(road.left_m, FAR_M) - lane_m, bounded(road.right_m, FAR_M) - lane_m
    heading, curvature = bounded(road.heading_rad, TURNED_RAD), bounded(road.curvature_per_m, SHARPEST_PER_M)
    return Lane(-lane_m, right, left, heading, curvature)
