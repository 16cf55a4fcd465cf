"""Ideal perception: what a camera would tell of a road and its bodies, from their geometry, for loops without one."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, sin

import numpy as np
from bicycle import Bicycle

from vpf_sim.geometry import vehicle_from_world, wrap_angle
from vpf_sim.types import Expansion, Floats, Flow, KnownFeatures, ObstacleMap, Obstacles, Perception, RoadEdges

HALF_ROAD_M = 7.0
LANE_M = 1.75  # the preferred lane's middle, right of the carriageway's


@dataclass(frozen=True)
class Body:
    """A car of 5 x 2 m along the road; `lateral_m` from the preferred lane's middle."""

    s_m: float
    lateral_m: float
    length_m: float = 5.0
    width_m: float = 2.0
    told_m: float = inf  # from the bumper at most


@dataclass(frozen=True)
class Road:
    """A straight along X from (0, 0), or an arc from there; the reference line is the preferred lane's middle."""

    curvature_per_m: float = 0.0

    def point(self, s_m: float, lateral_m: float) -> Floats:
        k = self.curvature_per_m
        angle = k * s_m
        x, y = (s_m, 0.0) if k == 0.0 else (sin(angle) / k, (1.0 - cos(angle)) / k)
        return np.array([x - lateral_m * sin(angle), y + lateral_m * cos(angle)])

    def local(self, x_m: float, y_m: float) -> tuple[float, float]:
        """(s, lateral) of a point."""
        k = self.curvature_per_m
        if k == 0.0:
            return x_m, y_m
        side = 1.0 if k > 0.0 else -1.0
        angle = atan2(side * x_m, side * (1.0 / k - y_m))
        return angle / k, side * (abs(1.0 / k) - hypot(x_m, y_m - 1.0 / k))

    def edges(self, car: Bicycle, noise_rad: float = 0.0) -> RoadEdges:
        s, lateral = self.local(car.x_m, car.y_m)
        place = LANE_M + lateral
        heading = wrap_angle(self.curvature_per_m * s - car.yaw_rad + noise_rad)
        left, right = -HALF_ROAD_M - place, HALF_ROAD_M - place
        return RoadEdges(left, right, heading, self.curvature_per_m, 0.02, 1.0, -lateral, 3.5)

    def corners(self, body: Body) -> Floats:
        """(4, 2) m in the world: face left, face right, rear right, rear left."""
        along, across = 0.5 * body.length_m, 0.5 * body.width_m
        angle = self.curvature_per_m * body.s_m
        forward, right = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
        centre = self.point(body.s_m, body.lateral_m)
        signs = ((-1, -1), (-1, 1), (1, 1), (1, -1))
        return np.array([centre + a * along * forward + b * across * right for a, b in signs])


class Eyes:
    """Bodies come into sight within a range of the bumper, or their own, and stay known until they are 11 m behind."""

    def __init__(self, road: Road, bodies: Sequence[Body], range_m: float) -> None:
        self._corners = [road.corners(body) for body in bodies]
        self._ranges_m = [min(range_m, body.told_m) for body in bodies]
        self._seen = [False] * len(bodies)

    def look(self, car: Bicycle) -> Obstacles:
        pose = np.array([car.x_m, car.y_m, car.yaw_rad])
        rows = []
        for index, corners in enumerate(self._corners):
            face = vehicle_from_world(corners[:2], pose)
            forward = float(face[:, 0].mean())
            self._seen[index] |= 0.0 < forward - 0.5 * car.model.length_m < self._ranges_m[index]
            if self._seen[index] and forward > -11.0:
                rows.append((forward, face[:, 1].min(), face[:, 1].max(), 0.1, max(forward, 0.0) / 5.0, index))
        table = np.array(rows).reshape(-1, 6).T
        return Obstacles(*table[:5], identity=table[5].astype(np.int64))


def perception(road: RoadEdges, obstacles: Obstacles) -> Perception:
    """A frame's perception without flow."""
    none, whole = np.empty(0), np.empty(0, np.int64)
    pairs, poses = np.empty((0, 2)), np.empty((0, 3))
    flow = Flow(pairs, pairs, none, poses, np.zeros(3), whole, pairs, poses, whole, np.empty((0, 2, 2)))
    expansion = Expansion(319.5, 239.5, np.eye(2), np.empty(0, np.bool_), 1.0)
    plane = ObstacleMap(np.empty(0, np.bool_), np.zeros((60, 80)), np.zeros((2, 60, 80)), 8)
    return Perception(flow, expansion, KnownFeatures(plane, none), obstacles, road, flow.pose)


def clearance(car: Bicycle, corners: Floats) -> float:
    """m between the car's outline and a body's, both sampled every few centimetres; 0 where they touch."""
    half_length, half_width = 0.5 * car.model.length_m, 0.5 * car.model.width_m
    share = np.linspace(0.0, 1.0, 60)[:, None]
    outline = np.concatenate([corners[i] + share * (corners[(i + 1) % 4] - corners[i]) for i in range(4)])
    own = np.abs(vehicle_from_world(outline, np.array([car.x_m, car.y_m, car.yaw_rad])))
    beyond = np.maximum(own - [half_length, half_width], 0.0)
    return float(np.hypot(*beyond.T).min())
