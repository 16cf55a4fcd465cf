"""The objects that a driver reports, against the bodies that stand or drive there, frame by frame.

The corridor is the strip of the road within CORRIDOR_M of the ego's centre, to both sides, ahead of its front bumper. A
report is right if its foot, the middle of the face that it says is nearest, is within FOOT_M of a body's outline. Only
reports in the corridor are counted; but a body is confirmed by the first that is right, wherever the ego was then: it
may turn into the body's way later. Bodies that stand in a row may be reported as one: where that is right, it confirms
all whose middles its face passes, as near.
"""

from collections import deque
from dataclasses import dataclass
from math import cos, hypot, nan, sin
from typing import Any

from vpf_sim.envs.rectangles import seen_from, solid_bodies
from vpf_sim.evaluation.metrics.perception import KINDS
from vpf_sim.types import Obstacles

CORRIDOR_M = 3.0
FOOT_M = 1.5
REACHED_M = 0.3  # a body so near to the bumper, along the road, is met: where it is hit the episode ends


@dataclass(frozen=True, slots=True)
class Detection:
    """A report ahead of the ego, and the bodies that it is right about."""

    index: int  # its row in the driver's obstacles
    ahead_m: float  # along the road from the front bumper to its foot
    in_corridor: bool
    owners: tuple[Any, ...]  # the bodies within FOOT_M of its foot, the nearest first; none: it is wrong
    passed: tuple[Any, ...]  # the bodies of a row whose middles its face passes
    is_new: bool  # wrong, and not wrong before


class DetectionScorer:
    """Remembers which body was first confirmed where, and which reports were wrong."""

    def __init__(self) -> None:
        self.detections: list[Detection] = []  # of the last frame
        self._confirmed_m: dict[Any, float] = {}  # of a body: bumper to face
        self._ahead: set[Any] = set()  # bodies
        self._wrong: set[int] = set()  # identities of reports
        self._met: deque[tuple[float, float]] = deque()

    def columns(self, reported: Obstacles, ego: Any, network: Any) -> dict[str, float]:
        """How many reports in the corridor are right and wrong, how many of the wrong are new, and what body was met.

        `met_kind` is the body's place in KINDS, `met_confirmed_m` where it was first confirmed, nan if never. Of
        several that are met in one frame the others come in the next.
        """
        bodies = solid_bodies(ego)
        self.detections = [self._judged(reported, *foot, ego, bodies) for foot in self._feet(reported, ego, network)]
        for detection in self.detections:
            for body in (*detection.owners, *detection.passed):
                self._confirmed_m.setdefault(body, _ahead_m(ego, body))
        self._meet(ego, bodies)
        kind, confirmed_m = self._met.popleft() if self._met else (nan, nan)
        counted = [detection for detection in self.detections if detection.in_corridor]
        right = sum(bool(detection.owners) for detection in counted)
        return {
            "objects_right": right,
            "objects_wrong": len(counted) - right,
            "new_wrong_objects": sum(detection.is_new for detection in counted),
            "met_kind": kind,
            "met_confirmed_m": confirmed_m,
        }

    def _judged(
        self,
        reported: Obstacles,
        index: int,
        foot: tuple[float, float],
        ahead_m: float,
        in_corridor: bool,
        ego: Any,
        bodies: list[Any],
    ) -> Detection:
        gaps_m = [(_gap_m(body, foot), body) for body in bodies]
        owners = [body for gap_m, body in sorted(gaps_m, key=lambda pair: pair[0]) if gap_m <= FOOT_M]
        passed = _passed(reported, index, ego, bodies) if owners else []
        wrong, identity = in_corridor and not owners, int(reported.identity[index])
        is_new = wrong and identity not in self._wrong
        self._wrong |= {identity} if wrong else set()
        return Detection(index, ahead_m, in_corridor, tuple(owners), tuple(passed), is_new)

    def _feet(self, reported: Obstacles, ego: Any, network: Any) -> list[tuple[int, tuple[float, float], float, bool]]:
        """Which reports are ahead, their feet in the world and from the bumper, m, and whether in the corridor."""
        feet = []
        s, lateral = ego.place
        for index in range(len(reported)):
            right = 0.5 * float(reported.left_m[index] + reported.right_m[index])
            foot = _in_world(ego, float(reported.forward_m[index]), right)
            foot_s, foot_lateral = network.centre.local_at(*foot)
            ahead_m = foot_s - s - 0.5 * ego.LENGTH
            if ahead_m > 0.0:
                feet.append((index, foot, ahead_m, abs(foot_lateral - lateral) <= CORRIDOR_M))
        return feet

    def _meet(self, ego: Any, bodies: list[Any]) -> None:
        """Note the bodies that the bumper reaches in this frame in the corridor."""
        for body in bodies:
            ahead_m = _ahead_m(ego, body)
            if ahead_m > REACHED_M:
                self._ahead.add(body)
            elif body in self._ahead:
                self._ahead.remove(body)
                if abs(body.place[1] - ego.place[1]) <= CORRIDOR_M:
                    self._met.append((float(KINDS.index(body.kind)), self._confirmed_m.get(body, nan)))


def _passed(reported: Obstacles, index: int, ego: Any, bodies: list[Any]) -> list[Any]:
    """The bodies whose middles lie behind a report's face, along the ego's heading, which there is within FOOT_M."""
    face, left, right = (float(side[index]) for side in (reported.forward_m, reported.left_m, reported.right_m))
    passed = []
    for body in bodies:
        ((_, aside),) = seen_from(ego, [tuple(body.position.tolist())])
        if left <= aside <= right and _gap_m(body, _in_world(ego, face, aside)) <= FOOT_M:
            passed.append(body)
    return passed


def _in_world(ego: Any, forward: float, right: float) -> tuple[float, float]:
    """A place in the ego's axes, m."""
    x, y = ego.position.tolist()
    cosine, sine = cos(ego.heading), sin(ego.heading)
    return x + cosine * forward - sine * right, y + sine * forward + cosine * right


def _ahead_m(ego: Any, body: Any) -> float:
    """m along the road from the front bumper to a body's nearest face."""
    return float(body.place[0] - ego.place[0] - 0.5 * (body.LENGTH + ego.LENGTH))


def _gap_m(body: Any, point: tuple[float, float]) -> float:
    """m from a point to a body's outline, 0 inside."""
    ((along, right),) = seen_from(body, [point])
    return hypot(max(abs(along) - 0.5 * body.LENGTH, 0.0), max(abs(right) - 0.5 * body.WIDTH, 0.0))
