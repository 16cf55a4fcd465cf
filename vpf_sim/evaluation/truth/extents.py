"""What a right report is off by: distance, sides and speed against those of the body that it is about.

The truth of a body is the end of its box that is turned to the ego, in the ego's axes: its nearest corner ahead, its
corners to the left and to the right. A row that is reported as one has the extent of all its bodies.
"""

from collections.abc import Iterable, Sequence
from math import cos, nan
from typing import Any, NamedTuple

from vpf_sim.envs.rectangles import corners, seen_from
from vpf_sim.evaluation.truth.detections import Detection
from vpf_sim.types import Obstacles


class Extent(NamedTuple):
    """In the ego's axes, m from its centre."""

    forward_m: float
    left_m: float
    right_m: float


class ExtentErrors(NamedTuple):
    """Reported less true: distance + is told too far, a side + is told too far out, speed + is told too fast."""

    distance_m: float
    left_m: float
    right_m: float
    speed_mps: float  # nan where the body stands and is reported so


def errors(detection: Detection, detections: Iterable[Detection], reported: Obstacles, ego: Any) -> ExtentErrors:
    """Of a right report; `reports` are all of its frame."""
    k, true, body = detection.index, true_extent(detection, detections, ego), detection.owners[0]
    speed_mps, seen_mps = float(body.speed), float(reported.speed_mps[k])
    return ExtentErrors(
        float(reported.forward_m[k]) - true.forward_m,
        true.left_m - float(reported.left_m[k]),
        float(reported.right_m[k]) - true.right_m,
        seen_mps - speed_mps if speed_mps or seen_mps else nan,
    )


def true_extent(detection: Detection, detections: Iterable[Detection], ego: Any) -> Extent:
    """Of the body nearest to the report's foot, with those of its row that no other report is nearest to."""
    taken = {id(other.owners[0]) for other in detections if other.owners}
    bodies = [detection.owners[0], *(body for body in detection.passed if id(body) not in taken)]
    return _union([near_end(body, ego) for body in bodies])


def near_end(body: Any, ego: Any) -> Extent:
    """The end of a body's box that is turned to the ego."""
    front_left, front_right, rear_right, rear_left = seen_from(ego, corners(body))
    runs_away = cos(body.heading - ego.heading) >= 0.0
    end = (rear_left, rear_right) if runs_away else (front_left, front_right)
    return Extent(min(x for x, _ in end), min(y for _, y in end), max(y for _, y in end))


def _union(extents: Sequence[Extent]) -> Extent:
    forward, left, right = zip(*extents, strict=True)
    return Extent(min(forward), min(left), max(right))
