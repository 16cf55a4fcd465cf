"""The scene as a camera shows it: the perceived road and obstacles in road coordinates that last from frame to frame.

The reference line is the middle of the lane in which the car started, so d = 0 is the route. s counts the metres
that the car has come along it.
"""

from math import cos, sin

import numpy as np

from vpf_sim.perception.object_sizes import ObjectSizes
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.scene.tracks import Tracks
from vpf_sim.types import Floats, Observation, Obstacles, Perception, RoadEdges

STEP_M = 0.5  # between the stations of the tables
BEHIND_M, BENDS_M, AHEAD_M = 40.0, 40.0, 200.0  # of the tables; beyond BENDS_M the road goes straight on
MOST_BEND = 0.8  # of 1 - d * curvature that the own place may take away
CONFIRMED = 3.0  # log-odds of an obstacle that perception reports
ACROSS_SIGMA_M = 0.06
SPEED_SIGMA_MPS = (0.4, 0.1)  # along, across, of what moves


class CameraScene:
    """Keeps the road coordinates of one episode."""

    def __init__(self, sizes: ObjectSizes | None = None) -> None:
        self._sizes = sizes or ObjectSizes()
        self._s_m = 0.0
        self.road: Road | None = None

    def update(self, perception: Perception, observation: Observation, speed_reference_mps: float) -> Scene:
        """The scene at an observation, by what is perceived then."""
        s, _ = self.place(observation)
        edges = perception.road
        self.road = road = road_of(edges, observation.pose, s)
        ego = EgoState(
            observation.x_m,
            observation.y_m,
            observation.yaw_rad,
            observation.speed_mps,
            observation.yaw_rate_radps,
            s,
            -edges.lane_m,
        )
        tracks = tracks_of(perception.obstacles, observation.pose, road, s, self._sizes)
        return Scene(observation.time_s, ego, road, tracks, speed_reference_mps)

    def place(self, observation: Observation) -> tuple[float, float]:
        """s and d of the car, m, on the road as last perceived."""
        if self.road is None:
            return 0.0, 0.0
        s, d = self.road.place_at(np.array([observation.x_m]), np.array([observation.y_m]), np.array([self._s_m]))
        self._s_m = float(s[0])
        return self._s_m, float(d[0])


def road_of(edges: RoadEdges, pose: Floats, s_m: float) -> Road:
    """The road about a car at a pose (x m, y m, yaw rad), which is `s_m` along it: an arc, then straight."""
    station = np.arange(s_m - BEHIND_M, s_m + AHEAD_M, STEP_M)
    lane = edges.lane_m
    stretch = max(1.0 - edges.curvature_per_m * lane, 1.0 - MOST_BEND)
    bend = edges.curvature_per_m / stretch
    along = station - s_m
    curvature = np.where(along < BENDS_M, bend, 0.0)
    course = float(pose[2]) + edges.heading_rad
    turned = bend * np.minimum(along, BENDS_M)
    heading = course + turned
    chord = np.minimum(along, BENDS_M)
    length = chord * np.sinc(0.5 * turned / np.pi)
    beyond = along - chord
    x, y = pose[0] - lane * sin(course), pose[1] + lane * cos(course)
    left, right = np.full_like(station, edges.left_m - lane), np.full_like(station, edges.right_m - lane)
    lanes = _lane_middles(left[0], right[0], edges.lane_width_m)
    return Road(
        station,
        x + length * np.cos(course + 0.5 * turned) + beyond * np.cos(heading),
        y + length * np.sin(course + 0.5 * turned) + beyond * np.sin(heading),
        heading,
        curvature,
        left - edges.oncoming_m,
        right,
        left,
        np.full_like(station, edges.sigma_m),
        np.repeat(lanes[:, None], len(station), axis=1),
        lane_width_m=edges.lane_width_m,
        route_m=0.0,
    )


def _lane_middles(left_m: float, right_m: float, width_m: float) -> Floats:
    """(L,) d of the middles of the lanes in our direction."""
    count = max(round((right_m - left_m) / width_m), 1)
    return left_m + (right_m - left_m) * (np.arange(count) + 0.5) / count


def tracks_of(obstacles: Obstacles, pose: Floats, road: Road, s_m: float, sizes: ObjectSizes) -> Tracks:
    """Obstacles in vehicle axes as tracks that stand or move along the road; their lengths are those of their class."""
    count, width = len(obstacles), obstacles.width_m
    cosine, sine = cos(pose[2]), sin(pose[2])
    x = pose[0] + cosine * obstacles.forward_m - sine * obstacles.middle_m
    y = pose[1] + sine * obstacles.forward_m + cosine * obstacles.middle_m
    s, d = road.place_at(x, y, s_m + obstacles.forward_m)
    length = sizes.lengths_m(width)
    heading = road.at(s).heading_rad
    moving = obstacles.speed_mps != 0.0
    covariance = np.zeros((count, 4, 4))
    covariance[:, 0, 0], covariance[:, 1, 1] = np.minimum(obstacles.sigma_m, 1.0) ** 2, ACROSS_SIGMA_M**2
    for axis, sigma in enumerate(SPEED_SIGMA_MPS):
        covariance[:, axis + 2, axis + 2] = np.where(moving, sigma**2, 0.0)
    return Tracks(
        x + 0.5 * length * np.cos(heading),
        y + 0.5 * length * np.sin(heading),
        heading,
        obstacles.speed_mps,
        np.zeros(count),
        length,
        width,
        s + 0.5 * length,
        d,
        np.full(count, CONFIRMED),
        covariance,
        obstacles.identity,
    )
