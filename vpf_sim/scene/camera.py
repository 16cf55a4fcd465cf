"""The scene as a camera shows it: the perceived road, and tracks in road coordinates that last from frame to frame.

The reference line is the middle of the lane in which the car started, so d = 0 is the route. s counts the metres
that the car has come along it.
"""

from math import cos, hypot, sin

import numpy as np

from vpf_sim.driver_interface import Observation
from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.object_sizes import ObjectSizes
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.scene.measurements import of_crossers, of_obstacles, support
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.scene.tracker import SceneTracker, TrackTable
from vpf_sim.scene.tracks import Tracks
from vpf_sim.types import Camera, Floats, Perception, RoadEdges

STEP_M = 0.5  # between the stations of the tables
BEHIND_M, BENDS_M, AHEAD_M = 40.0, 40.0, 200.0  # of the tables; beyond BENDS_M the road goes straight on
MOST_BEND = 0.8  # of 1 - d * curvature that the own place may take away
LOOK_M, LOOK_S = 0.5, 0.5  # way or time after which an observation is independent of the last
OUT_OF_SIGHT = 0.02  # of what a track loses where it should be detected
SIGHT_M, BEARING = (3.0, 20.0), 0.8  # where a track is expected to be detected; tangent of its bearing
STANDING_MPS, STANDING_SIGMAS = 0.4, 1.0  # a track whose velocity is not surely more stands
CROSSING = 1.0  # across over along, from which a track shows its side


class CameraScene:
    """Keeps road coordinates and tracks of one episode."""

    def __init__(self, camera_m: float = Camera().forward_m, sizes: ObjectSizes | None = None) -> None:
        """The camera is `camera_m` ahead of the pose."""
        self._camera_m, self._sizes = camera_m, sizes or ObjectSizes()
        self._tracker = SceneTracker()
        self._last: Observation | None = None  # of the last frame
        self._s_m = 0.0
        self.road: Road | None = None

    def observe(
        self,
        perception: Perception,
        observation: Observation,
        crossers: Crossers | None = None,
        points: Triangulation | None = None,
    ) -> None:
        """Bring road and tracks to a processed frame; `points` are those of its flow, triangulated."""
        s, _ = self.place(observation)
        before, self.road = self.road, road_of(perception.road, observation.pose, s)
        dt_s = way_m = 0.0
        if before is not None and self._last is not None:
            dt_s = observation.time_s - self._last.time_s
            way_m = hypot(observation.x_m - self._last.x_m, observation.y_m - self._last.y_m)
            self._tracker.carry(before, self.road)
            self._tracker.predict(dt_s)
        self._last = observation
        obstacles = perception.obstacles
        odds = np.full(len(obstacles), np.nan)
        if points is not None and len(obstacles):
            odds = support(obstacles, points, self._camera_m, observation.speed_mps)
        found = of_obstacles(obstacles, odds, observation.pose, self.road, s, self._sizes)
        if crossers is not None and len(crossers):
            found = found.joined(of_crossers(crossers, self._camera_m, observation.pose, self.road, s))
        fresh = min(max(way_m / LOOK_M, dt_s / LOOK_S), 1.0)
        self._tracker.update(found, fresh, dt_s * self._visible(observation), s)

    def scene(self, observation: Observation, speed_reference_mps: float) -> Scene:
        """The scene at an observation, on the road as last perceived."""
        assert self.road is not None
        s, d = self.place(observation)
        motion = observation.speed_mps, observation.yaw_rate_radps
        ego = EgoState(observation.x_m, observation.y_m, observation.yaw_rad, *motion, s, d)
        table = self._tracker.table.chosen(self._tracker.reported)
        return Scene(observation.time_s, ego, self.road, tracks_of(table, self.road), speed_reference_mps)

    def place(self, observation: Observation) -> tuple[float, float]:
        """s and d of the car, m, on the road as last perceived."""
        if self.road is None:
            return 0.0, 0.0
        s, d = self.road.place_at(np.array([observation.x_m]), np.array([observation.y_m]), np.array([self._s_m]))
        self._s_m = float(s[0])
        return self._s_m, float(d[0])

    def _visible(self, observation: Observation) -> Floats:
        """(K,) 1 for tracks that should be detected, a little for those that cannot be."""
        assert self.road is not None
        state = self._tracker.table.state
        x, y, _ = self.road.world(state[:, 0], state[:, 1])
        forward, right = vehicle_from_world(np.column_stack([x, y]), observation.pose).T
        visible = (forward > SIGHT_M[0]) & (forward < SIGHT_M[1]) & (np.abs(right) < BEARING * forward)
        return np.where(visible, 1.0, OUT_OF_SIGHT)


def road_of(edges: RoadEdges, pose: Floats, s_m: float) -> Road:
    """The road about a car at a pose (x m, y m, yaw rad), which is `s_m` along it: an arc, then straight."""
    station = np.arange(s_m - BEHIND_M, s_m + AHEAD_M, STEP_M)
    along = station - s_m
    bend = edges.curvature_per_m / max(1.0 - edges.curvature_per_m * edges.lane_m, 1.0 - MOST_BEND)
    course, arc = float(pose[2]) + edges.heading_rad, np.minimum(along, BENDS_M)
    turned = bend * arc
    heading, beyond = course + turned, along - arc
    chord = arc * np.sinc(0.5 * turned / np.pi)
    x, y = pose[0] - edges.lane_m * sin(course), pose[1] + edges.lane_m * cos(course)
    left, right, same = edges.left_m - edges.lane_m, edges.right_m - edges.lane_m, np.ones_like(station)
    lanes = _lane_middles(left, right, edges.lane_width_m)
    return Road(
        station,
        x + chord * np.cos(course + 0.5 * turned) + beyond * np.cos(heading),
        y + chord * np.sin(course + 0.5 * turned) + beyond * np.sin(heading),
        heading,
        np.where(along < BENDS_M, bend, 0.0),
        (left - edges.oncoming_m) * same,
        right * same,
        left * same,
        edges.sigma_m * same,
        lanes[:, None] * same,
        lane_width_m=edges.lane_width_m,
        route_m=0.0,
    )


def _lane_middles(left_m: float, right_m: float, width_m: float) -> Floats:
    """(L,) d of the middles of the lanes in our direction."""
    count = max(round((right_m - left_m) / width_m), 1)
    return left_m + (right_m - left_m) * (np.arange(count) + 0.5) / count


def tracks_of(table: TrackTable, road: Road) -> Tracks:
    """Faces in road coordinates as rectangles in the world; what crosses shows its side."""
    s, d, along, across = table.state.T
    sigma = np.sqrt(np.diagonal(table.covariance, axis1=1, axis2=2))
    speed = np.hypot(along, across)
    moving = (speed > STANDING_MPS) & (speed > STANDING_SIGMAS * np.hypot(sigma[:, 2], sigma[:, 3]))
    crosses = moving & (np.abs(across) > CROSSING * np.abs(along))
    depth = np.where(crosses, np.minimum(table.length_m, table.width_m), table.length_m)
    x, y, direction = road.world(s + 0.5 * depth, d)
    turn = np.where(moving, np.arctan2(across, along), 0.0)
    return Tracks(
        x,
        y,
        direction + turn,
        np.where(moving, speed, 0.0),
        np.zeros(len(s)),
        np.where(crosses, table.width_m, table.length_m),
        np.where(crosses, depth, table.width_m),
        s + 0.5 * depth,
        d,
        table.gain,
        _in_track_axes(table.covariance, turn, moving),
        table.identity,
    )


def _in_track_axes(covariance: Floats, turn_rad: Floats, moving: Floats) -> Floats:
    """(K, 4, 4) covariances (K, 4, 4) in axes turned by (K,); what stands has no velocity."""
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    turned = np.zeros_like(covariance)
    for first in (0, 2):
        turned[:, first, first] = turned[:, first + 1, first + 1] = cosine
        turned[:, first, first + 1], turned[:, first + 1, first] = sine, -sine
    turned[:, 2:] *= moving[:, None, None]
    return turned @ covariance @ turned.transpose(0, 2, 1)
