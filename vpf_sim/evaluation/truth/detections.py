"""Matches a driver's detections with the true objects, frame by frame.

The corridor is the strip of road within CORRIDOR_M on both sides of the ego's centre, ahead of its front bumper. A
detection is correct if its foot, the middle of its nearest face, is within FOOT_M of an object's outline. Only
detections in the corridor are counted. An object is confirmed by the first correct detection anywhere, since the ego
may turn towards it later. A row of objects may be detected as one: a correct detection confirms every object whose
centre lies behind its face within FOOT_M.

Errors of a correct detection in distance, sides and speed.

The true extent of an object is the end of its box that faces the ego, in the ego's axes: the nearest corner ahead and
the corners to the left and right. A row that is detected as one has the extent of all its objects.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import cos, hypot, nan, sin
from typing import NamedTuple

import numpy as np

from vpf_sim.envs.contacts import corners, solid_objects, to_local
from vpf_sim.envs.network import Network, OnRoad
from vpf_sim.evaluation.environment import Surroundings
from vpf_sim.evaluation.metrics.perception import KINDS
from vpf_sim.types import Obstacles

CORRIDOR_M = 3.0
FOOT_M = 1.5
REACHED_M = 0.3  # along the road: a nearer object counts as met, since a collision ends the episode


@dataclass(frozen=True, slots=True)
class Detection:
    """A detection ahead of the ego, and its matching objects."""

    index: int  # row in the driver's obstacles
    ahead_m: float  # along the road from the front bumper to its foot
    in_corridor: bool
    owners: tuple[OnRoad, ...]  # objects within FOOT_M of its foot, nearest first; empty for a false positive
    passed: tuple[OnRoad, ...]  # objects of a row whose centres lie behind its face
    is_new: bool  # a false positive that was not false before


class DetectionScorer:
    """Scores the detections of every frame; remembers first confirmations and earlier false positives."""

    def __init__(self) -> None:
        self.detections: list[Detection] = []  # of the last frame
        self._confirmed_m: dict[OnRoad, float] = {}  # by object: bumper to face at its first confirmation
        self._ahead: set[OnRoad] = set()  # objects
        self._wrong: set[int] = set()  # identities of detections
        self._met: deque[tuple[float, float]] = deque()

    def columns(self, reported: Obstacles, world: Surroundings) -> dict[str, float]:
        """Step-table columns: correct, false and new false detections in the corridor, an object met, and the nearest.

        `met_kind` is the object's index in KINDS, `met_confirmed_m` the distance of its first confirmation, nan if
        never. Of several objects met in one frame, the others follow in the next frames.
        """
        ego, network, (_, near) = world.ego, world.road.network, world.nearest
        objects = solid_objects(ego)
        self.detections = [self._matched(reported, *foot, ego, objects) for foot in self._feet(reported, ego, network)]
        for detection in self.detections:
            for obj in (*detection.owners, *detection.passed):
                self._confirmed_m.setdefault(obj, _ahead_m(ego, obj))
        self._meet(ego, objects)
        kind, confirmed_m = self._met.popleft() if self._met else (nan, nan)
        counted = [detection for detection in self.detections if detection.in_corridor]
        right = sum(bool(detection.owners) for detection in counted)
        wrong_m = [detection.ahead_m for detection in counted if not detection.owners]
        return {
            "wrong_ahead_m": min(wrong_m, default=nan),
            "near_confirmed_m": nan if near is None else self._confirmed_m.get(near, nan),
            "near_sticks_out_m": nan if near is None else self._sticks_out_m(reported, ego, near),
            "objects_right": right,
            "objects_wrong": len(counted) - right,
            "new_wrong_objects": sum(detection.is_new for detection in counted),
            "met_kind": kind,
            "met_confirmed_m": confirmed_m,
        }

    def _sticks_out_m(self, reported: Obstacles, ego: OnRoad, obj: OnRoad) -> float:
        """How far an object reaches beyond all that is reported of it, m; nan where nothing is."""
        own = [one.index for one in self.detections if obj in one.owners or obj in one.passed]
        if not own:
            return nan
        forward, right = np.array(to_local(ego, corners(obj))).T
        left_m, right_m = reported.left_m[own].min() - right.min(), right.max() - reported.right_m[own].max()
        return max(float(left_m), float(right_m), float(reported.forward_m[own].min() - forward.min()), 0.0)

    def _matched(
        self,
        reported: Obstacles,
        index: int,
        foot: tuple[float, float],
        ahead_m: float,
        in_corridor: bool,
        ego: OnRoad,
        objects: list[OnRoad],
    ) -> Detection:
        gaps_m = [(_gap_m(obj, foot), obj) for obj in objects]
        owners = [obj for gap_m, obj in sorted(gaps_m, key=lambda pair: pair[0]) if gap_m <= FOOT_M]
        passed = _passed(reported, index, ego, objects) if owners else []
        wrong, identity = in_corridor and not owners, int(reported.identity[index])
        is_new = wrong and identity not in self._wrong
        self._wrong |= {identity} if wrong else set()
        return Detection(index, ahead_m, in_corridor, tuple(owners), tuple(passed), is_new)

    def _feet(
        self, reported: Obstacles, ego: OnRoad, network: Network
    ) -> list[tuple[int, tuple[float, float], float, bool]]:
        """Index, foot in the world, distance ahead (m) and corridor flag of each detection ahead of the bumper."""
        feet = []
        s, lateral = ego.place
        for index in range(len(reported)):
            right = 0.5 * float(reported.left_m[index] + reported.right_m[index])
            foot = _in_world(ego, float(reported.forward_m[index]), right)
            foot_s, foot_lateral = network.place_at(*foot, s)
            ahead_m = foot_s - s - 0.5 * ego.LENGTH
            if ahead_m > 0.0:
                feet.append((index, foot, ahead_m, abs(foot_lateral - lateral) <= CORRIDOR_M))
        return feet

    def _meet(self, ego: OnRoad, objects: list[OnRoad]) -> None:
        """Queue the objects in the corridor that the bumper reaches in this frame."""
        for obj in objects:
            ahead_m = _ahead_m(ego, obj)
            if ahead_m > REACHED_M:
                self._ahead.add(obj)
            elif obj in self._ahead:
                self._ahead.remove(obj)
                if abs(obj.place[1] - ego.place[1]) <= CORRIDOR_M:
                    self._met.append((float(KINDS.index(obj.kind)), self._confirmed_m.get(obj, nan)))


def _passed(reported: Obstacles, index: int, ego: OnRoad, objects: list[OnRoad]) -> list[OnRoad]:
    """The objects whose centres lie behind a detection's face, with the face within FOOT_M of their outline."""
    face, left, right = (float(side[index]) for side in (reported.forward_m, reported.left_m, reported.right_m))
    passed = []
    for obj in objects:
        ((_, right_m),) = to_local(ego, [tuple(obj.position.tolist())])
        if left <= right_m <= right and _gap_m(obj, _in_world(ego, face, right_m)) <= FOOT_M:
            passed.append(obj)
    return passed


def _in_world(ego: OnRoad, forward: float, right: float) -> tuple[float, float]:
    """World coordinates, m, of a point in the ego's axes."""
    x, y = ego.position.tolist()
    cosine, sine = cos(ego.heading), sin(ego.heading)
    return x + cosine * forward - sine * right, y + sine * forward + cosine * right


def _ahead_m(ego: OnRoad, obj: OnRoad) -> float:
    """Distance, m, along the road from the front bumper to an object's nearest face."""
    return float(obj.place[0] - ego.place[0] - 0.5 * (obj.LENGTH + ego.LENGTH))


def _gap_m(obj: OnRoad, point: tuple[float, float]) -> float:
    """Distance, m, from a point to an object's outline; 0 inside."""
    ((along, right),) = to_local(obj, [point])
    return hypot(max(abs(along) - 0.5 * obj.LENGTH, 0.0), max(abs(right) - 0.5 * obj.WIDTH, 0.0))


class Extent(NamedTuple):
    """Nearest distance and lateral sides in the ego's axes, m from its centre."""

    forward_m: float
    left_m: float
    right_m: float


class ExtentErrors(NamedTuple):
    """Detected - true: distance + is too far, a side + is too far out, speed + is too fast; and the overlap."""

    distance_m: float
    left_m: float
    right_m: float
    speed_mps: float  # nan where both detected and true speed are 0
    overlap: float  # across: what detected and true extent share, of what either covers


def errors(detection: Detection, detections: Iterable[Detection], reported: Obstacles, ego: OnRoad) -> ExtentErrors:
    """Errors of a correct detection; `detections` are all of its frame."""
    k, true, obj = detection.index, true_extent(detection, detections, ego), detection.owners[0]
    speed_mps, seen_mps = float(obj.speed), float(reported.speed_mps[k])
    left_m, right_m = float(reported.left_m[k]), float(reported.right_m[k])
    shared_m = max(min(right_m, true.right_m) - max(left_m, true.left_m), 0.0)
    covered_m = right_m - left_m + true.right_m - true.left_m - shared_m
    return ExtentErrors(
        float(reported.forward_m[k]) - true.forward_m,
        true.left_m - left_m,
        right_m - true.right_m,
        seen_mps - speed_mps if speed_mps or seen_mps else nan,
        shared_m / covered_m if covered_m else nan,
    )


def true_extent(detection: Detection, detections: Iterable[Detection], ego: OnRoad) -> Extent:
    """Extent of the nearest object and of the objects of its row that no other detection matches."""
    taken = {id(other.owners[0]) for other in detections if other.owners}
    objects = [detection.owners[0], *(obj for obj in detection.passed if id(obj) not in taken)]
    return _union([near_end(obj, ego) for obj in objects])


def near_end(obj: OnRoad, ego: OnRoad) -> Extent:
    """The extent of an object's face towards the ego."""
    front_left, front_right, rear_right, rear_left = to_local(ego, corners(obj))
    runs_away = cos(obj.heading - ego.heading) >= 0.0
    end = (rear_left, rear_right) if runs_away else (front_left, front_right)
    return Extent(min(x for x, _ in end), min(y for _, y in end), max(y for _, y in end))


def _union(extents: Sequence[Extent]) -> Extent:
    forward, left, right = zip(*extents, strict=True)
    return Extent(min(forward), min(left), max(right))
