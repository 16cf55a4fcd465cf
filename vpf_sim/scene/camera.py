"""The scene as a camera shows it: the perceived road, and tracks in road coordinates that last from frame to frame.

The reference line is the middle of the lane in which the car started, so d = 0 is the route. s counts the metres
that the car has come along it.
"""

from math import cos, hypot, sin, sqrt

import numpy as np

from vpf_sim.driver_interface import Observation
from vpf_sim.geometry import bounded, rotation, vehicle_from_world, wrap_angle
from vpf_sim.perception.obstacles.point_motion import PointMotions
from vpf_sim.perception.obstacles.prediction import none
from vpf_sim.scene.bounds import ASIDE_M, plausible_obstacles, plausible_road
from vpf_sim.scene.evidence import NO_EVIDENCE, Evidence
from vpf_sim.scene.measurements import BEARING, of_crossers, of_obstacles, support
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.scene.scene_settings import SceneConfig
from vpf_sim.scene.tracker import Detections, SceneTracker, TrackTable
from vpf_sim.scene.tracks import Tracks, probability
from vpf_sim.scene.unseen import UnseenTraffic
from vpf_sim.scene.vehicle_motion import STANDING_MPS, seen_motion
from vpf_sim.types import Bools, Camera, Floats, Obstacles, Perception, RoadEdges, VehicleModel

STEP_M = 0.5  # between the stations of the tables
BEHIND_M, BENDS_M, AHEAD_M = 40.0, 40.0, 200.0  # of the tables; beyond BENDS_M the road goes straight on
MOST_LANES = 12
MOST_BEND = 0.8  # of 1 - d * curvature that the own place may take away
OUT_OF_SIGHT = 0.02  # of what a track loses where it should be detected
SIGHT_M = (3.0, 20.0)  # where a track is expected to be detected, within the bearing
STANDING_SIGMAS = 1.0  # a track whose velocity is not surely more stands
ACTOR_M = np.array([2.5, 1.5])  # along and across: what stands so near to an actor that crosses is the actor
NEWEST = 0.5  # of the mean relief
NEARER_SIGMA = 0.15  # of the distance at which a vehicle stands, as a share of it
FOLLOWED_M, FORGOTTEN_S = (3.0, 25.0), 1.0  # where, and how long after the last detection, points show a velocity
UNDER_M = 1.0, 0.3  # within the car's ends and sides, from which a face's middle is under the car
CROSSING = 1.0  # across over along, from which a track shows its side


class CameraScene:
    """Keeps road coordinates and tracks of one episode."""

    def __init__(self, camera: Camera, vehicle: VehicleModel, config: SceneConfig) -> None:
        self._camera, self._vehicle, self._config = camera, vehicle, config.existence
        self._tracker, self._unseen = SceneTracker(config.tracker), UnseenTraffic(config.unseen)
        self._last: Observation | None = None  # of the last frame
        self._s_m = 0.0  # at the last frame: what is perceived does not depend on what is planned in between
        self._relief: dict[int, float] = {}  # of the last frame's obstacles, by identity
        self._actors: set[int] = set()  # identities of static obstacles that are actors who crossed
        self.road: Road | None = None

    def observe(self, perception: Perception, observation: Observation, evidence: Evidence = NO_EVIDENCE) -> None:
        """Bring road and tracks to a processed frame."""
        self._s_m = s = self.place(observation)[0]
        before, self.road = self.road, road_of(plausible_road(perception.road), observation.pose, s)
        dt_s = way_m = 0.0
        if before is not None and self._last is not None:
            dt_s = observation.time_s - self._last.time_s
            way_m = hypot(observation.x_m - self._last.x_m, observation.y_m - self._last.y_m)
            self._tracker.carry(before, self.road)
            self._tracker.predict(dt_s)
        self._last = observation
        found = self._detections(plausible_obstacles(perception.obstacles), observation, evidence, s)
        by_way, by_time = way_m / self._config.look_m, dt_s / self._config.look_s
        static = found.stands & (found.gain > 0.0)  # a car that stands sees them from one place
        fresh = np.minimum(np.where(static, by_way, max(by_way, by_time)), 1.0)
        self._tracker.update(found, fresh, dt_s * self._visible(observation), s)
        if evidence.motions is not None:
            self._follow(evidence.motions, observation)
        self._tracker.end(self._under_the_car(observation))
        self._unseen.update(observation.time_s, observation.speed_mps, self._tracker.traffic_mps)

    def _under_the_car(self, observation: Observation) -> Bools:
        """(K,) tracks that stand, with their face's middle under the car by now: it would have hit them."""
        assert self.road is not None
        table, (ends_m, sides_m) = self._tracker.table, UNDER_M
        forward, right, _ = _from_car(self.road, observation, *table.state[:, :2].T)
        under = np.abs(forward) < 0.5 * self._vehicle.length_m - ends_m
        under &= np.abs(right) < 0.5 * self._vehicle.width_m - sides_m
        return np.asarray(under & ~_moving(table))

    def _detections(self, obstacles: Obstacles, observation: Observation, evidence: Evidence, s_m: float) -> Detections:
        """All that was found in the last frame."""
        assert self.road is not None
        pose, camera_m = observation.pose, self._camera.forward_m
        odds = np.full(len(obstacles), np.nan)
        if evidence.points is not None and len(obstacles):
            odds = support(obstacles, evidence.points, camera_m, observation.speed_mps, self._config)
        relief = self._mean_relief(obstacles, evidence.relief)
        found = of_obstacles(obstacles, odds, relief, pose, self.road, s_m, self._config)
        found = self._without_actors(found, obstacles, np.isnan(odds))
        if evidence.crossers is None or not len(evidence.crossers):
            return found
        return found.concatenate(of_crossers(evidence.crossers, camera_m, pose, self.road, s_m, self._config))

    def _without_actors(self, found: Detections, obstacles: Obstacles, unjudged: Bools) -> Detections:
        """Leave out what is found standing where an actor crosses: it has the actor's points, and keeps its place.

        When the actor has gone, it counts by its points only; `unjudged` (K,) obstacles have none now.
        """
        crossing = self._tracker.crossing_m
        near = np.abs(found.state[:, None, :2] - crossing) < ACTOR_M
        stands = obstacles.speed_mps == 0.0
        here = stands & np.any(np.all(near, axis=2), axis=1)
        self._actors |= set(obstacles.identity[here].tolist())
        known = np.array([identity in self._actors for identity in obstacles.identity.tolist()], np.bool_)
        found.gain[known & unjudged] = 0.0
        return found.select(~here)

    def scene(self, observation: Observation, speed_reference_mps: float) -> Scene:
        """The scene at an observation, on the road as last perceived."""
        assert self.road is not None
        s, d = self.place(observation)
        motion = observation.speed_mps, observation.yaw_rate_radps
        ego = EgoState(observation.x_m, observation.y_m, observation.yaw_rad, *motion, s, d)
        table = self._tracker.table.select(self._tracker.reported)
        tracks = tracks_of(table, self.road).concatenate(self._unseen.tracks(self.road, ego, observation.time_s))
        return Scene(observation.time_s, ego, self.road, tracks, speed_reference_mps)

    def obstacles(self, observation: Observation) -> Obstacles:
        """The reported tracks in vehicle axes at an observation, where they are by then."""
        table = self._tracker.table.select(self._tracker.reported)
        if self.road is None or self._last is None or not len(table):
            return none()
        s, d, along, across = table.state.T
        moves, since_s = np.hypot(along, across) > STANDING_MPS, observation.time_s - self._last.time_s
        forward, right, _ = _from_car(self.road, observation, s + along * since_s, d + across * since_s)
        speed, half = np.where(moves, along, 0.0), 0.5 * table.width_m
        with np.errstate(divide="ignore", invalid="ignore"):
            closing = observation.speed_mps - speed
            ttc = np.where((forward > 0.0) & (closing > 0.0), forward / closing, np.inf)
        sigma = np.sqrt(table.covariance[:, 0, 0])
        identity = np.where(moves, -1 - table.identity, table.identity)
        existence = probability(table.gain)
        return Obstacles(forward, right - half, right + half, sigma, ttc, identity, speed, existence)

    def place(self, observation: Observation) -> tuple[float, float]:
        """s and d of the car, m, on the road as last perceived; of a pose that jumps, at an end of its tables."""
        if self.road is None:
            return 0.0, 0.0
        s, d = self.road.place_at(np.array([observation.x_m]), np.array([observation.y_m]), np.array([self._s_m]))
        on_road = min(max(float(s[0]), float(self.road.station_m[0])), float(self.road.station_m[-1]))
        return on_road, bounded(float(d[0]), ASIDE_M)

    def _mean_relief(self, obstacles: Obstacles, relief: Floats | None) -> Floats:
        """(K,) relief of obstacles over the last frames that showed it; 0 of those never shown."""
        before, now = self._relief, np.full(len(obstacles), np.nan) if relief is None else relief
        identities = obstacles.identity.tolist()
        last = np.array([before.get(identity, 0.0) for identity in identities])
        mean: Floats = np.where(np.isnan(now), last, last + NEWEST * (now - last))
        self._relief = dict(zip(identities, mean.tolist(), strict=True))
        return mean

    def _follow(self, motions: PointMotions, observation: Observation) -> None:
        """Correct the velocities of tracks by the motion of the points on them."""
        assert self.road is not None
        table = self._tracker.table
        forward, right, turn = _from_car(self.road, observation, *table.state[:, :2].T)
        ahead = (forward > FOLLOWED_M[0]) & (forward < FOLLOWED_M[1]) & (np.abs(right) < BEARING * forward)
        for row in np.flatnonzero(ahead & (table.unseen_s < FORGOTTEN_S)).tolist():
            road_axes = rotation(turn[row])  # in the vehicle's
            place = forward[row], right[row], table.width_m[row], sqrt(table.covariance[row, 0, 0])
            expected = road_axes @ table.state[row, 2:]
            found = seen_motion(*place, expected, observation.speed_mps, motions, self._camera)
            if found is None:
                continue
            velocity = found.velocity_mps @ road_axes
            if hypot(*table.state[row, 2:]) < STANDING_MPS:
                self._tracker.see_motion(row, velocity, found.sigma_mps, observation.speed_mps)
                continue
            self._tracker.correct_velocity(row, velocity, found.sigma_mps)
            if found.nearer < 1.0:
                self._tracker.correct_place(row, (found.nearer - 1.0) * forward[row], NEARER_SIGMA * forward[row])

    def _visible(self, observation: Observation) -> Floats:
        """(K,) 1 for tracks that should be detected, a little for those that cannot be."""
        assert self.road is not None
        forward, right, _ = _from_car(self.road, observation, *self._tracker.table.state[:, :2].T)
        visible = (forward > SIGHT_M[0]) & (forward < SIGHT_M[1]) & (np.abs(right) < BEARING * forward)
        return np.where(visible, 1.0, OUT_OF_SIGHT)


def _from_car(road: Road, observation: Observation, s_m: Floats, d_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(K,) each: places on the road in vehicle axes, m forward and right, and how far the road is turned there, rad."""
    x, y, heading = road.world(s_m, d_m)
    forward, right = vehicle_from_world(np.column_stack([x, y]), observation.pose).T
    return forward, right, heading - observation.yaw_rad


def road_of(edges: RoadEdges, pose: Floats, s_m: float) -> Road:
    """The road about a car at a pose (x m, y m, yaw rad), which is `s_m` along it: an arc, then straight."""
    station = np.arange(s_m - BEHIND_M, s_m + AHEAD_M, STEP_M)
    along = station - s_m
    bend = edges.curvature_per_m / max(1.0 - edges.curvature_per_m * edges.lane_m, 1.0 - MOST_BEND)
    course, arc = wrap_angle(float(pose[2]) + edges.heading_rad), np.minimum(along, BENDS_M)
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
        lanes[:, None] * same,
        lane_width_m=edges.lane_width_m,
        route_m=0.0,
    )


def _lane_middles(left_m: float, right_m: float, width_m: float) -> Floats:
    """(L,) d of the middles of the lanes in our direction."""
    count = min(max(round((right_m - left_m) / width_m), 1), MOST_LANES)
    return left_m + (right_m - left_m) * (np.arange(count) + 0.5) / count


def tracks_of(table: TrackTable, road: Road) -> Tracks:
    """Faces in road coordinates as rectangles in the world; what crosses shows its side."""
    s, d, along, across = table.state.T
    speed, moving = np.hypot(along, across), _moving(table)
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
        _in_track_axes(table.covariance, turn, moving),
    )


def _moving(table: TrackTable) -> Bools:
    """(K,) tracks whose velocity is surely not 0."""
    speed = np.hypot(*table.state[:, 2:].T)
    sigma = np.sqrt(np.diagonal(table.covariance, axis1=1, axis2=2))
    return np.asarray((speed > STANDING_MPS) & (speed > STANDING_SIGMAS * np.hypot(sigma[:, 2], sigma[:, 3])))


def _in_track_axes(covariance: Floats, turn_rad: Floats, moving: Bools) -> Floats:
    """(K, 4, 4) covariances (K, 4, 4) in axes turned by (K,); what stands has no velocity."""
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    turned = np.zeros_like(covariance)
    for first in (0, 2):
        turned[:, first, first] = turned[:, first + 1, first + 1] = cosine
        turned[:, first, first + 1], turned[:, first + 1, first] = sine, -sine
    turned[:, 2:] *= moving[:, None, None]
    return turned @ covariance @ turned.transpose(0, 2, 1)
