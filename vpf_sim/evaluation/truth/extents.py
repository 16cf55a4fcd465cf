"""Errors of a correct detection in distance, sides and speed.

The true extent of an object is the end of its box that faces the ego, in the ego's axes: the nearest corner ahead and
the corners to the left and right. A row that is detected as one has the extent of all its objects.
"""

from collections.abc import Iterable, Sequence
from math import cos, nan
from typing import Any, NamedTuple

from vpf_sim.envs.rectangles import corners, to_local
from vpf_sim.evaluation.truth.detections import Detection
from vpf_sim.types import Obstacles


class Extent(NamedTuple):
    """Nearest distance and lateral sides in the ego's axes, m from its centre."""

    forward_m: float
    left_m: float
    right_m: float


class ExtentErrors(NamedTuple):
    """Detected - true: distance + is too far, a side + is too far out, speed + is too fast."""

    distance_m: float
    left_m: float
    right_m: float
    speed_mps: float  # nan where both detected and true speed are 0


def errors(detection: Detection, detections: Iterable[Detection], reported: Obstacles, ego: Any) -> ExtentErrors:
    """Errors of a correct detection; `detections` are all of its frame."""
    k, true, obj = detection.index, true_extent(detection, detections, ego), detection.owners[0]
    speed_mps, seen_mps = float(obj.speed), float(reported.speed_mps[k])
    return ExtentErrors(
        float(reported.forward_m[k]) - true.forward_m,
        true.left_m - float(reported.left_m[k]),
        float(reported.right_m[k]) - true.right_m,
        seen_mps - speed_mps if speed_mps or seen_mps else nan,
    )


def true_extent(detection: Detection, detections: Iterable[Detection], ego: Any) -> Extent:
    """Extent of the nearest object and of the objects of its row that no other detection matches."""
    taken = {id(other.owners[0]) for other in detections if other.owners}
    objects = [detection.owners[0], *(obj for obj in detection.passed if id(obj) not in taken)]
    return _union([near_end(obj, ego) for obj in objects])


def near_end(obj: Any, ego: Any) -> Extent:
    """The extent of an object's face towards the ego."""
    front_left, front_right, rear_right, rear_left = to_local(ego, corners(obj))
    runs_away = cos(obj.heading - ego.heading) >= 0.0
    end = (rear_left, rear_right) if runs_away else (front_left, front_right)
    return Extent(min(x for x, _ in end), min(y for _, y in end), max(y for _, y in end))


def _union(extents: Sequence[Extent]) -> Extent:
    forward, left, right = zip(*extents, strict=True)
    return Extent(min(forward), min(left), max(right))
