"""The planner: the stages of the paper in their order, from a frame to a reference."""

from collections import deque
from dataclasses import replace
from functools import cache, partial

import numpy as np

from vpf_sim.perception.contrast import contrast
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.camera_pitch import PitchEstimator
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.perception.egomotion.focus_of_expansion import Derotated
from vpf_sim.perception.egomotion.keyframes import KeyframeBuffer
from vpf_sim.perception.frame_gate import FrameGate
from vpf_sim.perception.obstacles.close_range_verification import CloseRangeVerifier
from vpf_sim.perception.obstacles.extent import carried, to_current_frame
from vpf_sim.perception.obstacles.moving.tracker import MovingObstacleTracker
from vpf_sim.perception.obstacles.point_hypotheses import among
from vpf_sim.perception.obstacles.static_tracker import StaticObstacleTracker
from vpf_sim.perception.obstacles.track_refinement import Match
from vpf_sim.perception.paper import obstacle_map as obstacles
from vpf_sim.perception.paper import time_to_contact as contact
from vpf_sim.perception.paper.obstacle_region import Surroundings
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.planning.lane.planner import LanePlanner
from vpf_sim.planning.lane.speed.limits import eased
from vpf_sim.planning.paper.planner import PaperPlanner
from vpf_sim.planning.variant import Variant
from vpf_sim.seeding import stream
from vpf_sim.types import (
    Camera,
    DriverSetup,
    Expansion,
    Floats,
    Flow,
    Image,
    Observation,
    Obstacles,
    PaperFeatures,
    Perception,
    Plan,
    Reference,
    RoadEdges,
)

NO_IMAGE: Image = np.empty((0, 0, 3), np.uint8)
REMEMBERED_S = 2.5  # own motion, for frames that arrive late
FOLLOWED_S = 0.25  # between two frames, over which points are found again
BLIND_S = 0.5  # without a new frame, after which the car brakes to a stop
MOST_LATE = 0.45  # of a period: flow is counted in periods


class Planner:
    """One variant of the method during one episode."""

    def __init__(self, setup: DriverSetup, variant: Variant) -> None:
        # Frames from one look to the next, no more than asked.
        self._every = max(1, int(variant.flow.period_s * setup.rate_hz + 1e-6))
        camera, rate_hz = setup.camera, setup.rate_hz / self._every
        self._period_s = 1.0 / rate_hz
        self._camera = camera
        self._variant = variant
        self._flow = FlowTracker(camera, variant.flow, rate_hz)
        self._keyframes = self._remembered(camera, variant, rate_hz)
        self._road = RoadEdgeTracker(camera, variant.road_edges, rate_hz)
        self._static_obstacles = (
            StaticObstacleTracker(camera, variant.static_obstacles, rate_hz) if variant.static_obstacles else None
        )
        self._moving_obstacles = (
            MovingObstacleTracker(camera, variant.moving_obstacles, rate_hz) if variant.moving_obstacles else None
        )
        self._pitch_estimator = PitchEstimator(camera, variant.camera_pitch, rate_hz) if variant.camera_pitch else None
        self._verifier = (
            CloseRangeVerifier(camera, variant.close_range_verification) if variant.close_range_verification else None
        )
        self._speed_reference_mps = setup.speed_reference_mps
        self._random = stream(setup.seed, "focus of expansion")
        self._foe: Expansion | None = None
        self._gate = FrameGate()
        self._past: deque[Observation] = deque()  # without images, oldest first
        self._frame = 0  # the next one
        self._waits = 0  # frames since one was due that could not be looked at
        self._seen: Perception | None = None  # of the last frame that was looked at,
        self._seen_s = 0.0  # and when
        self._way = way(setup, variant)

    @property
    def looks(self) -> bool:
        """Whether it looks at the next frame."""
        return self._waits > 0 or self._frame % self._every == 0

    @property
    def has_missed(self) -> bool:
        """Whether the last frame that it was to look at was none, or not to be trusted."""
        return self._waits > 0

    def step(self, observation: Observation) -> Plan:
        """Perceive, then plan."""
        return self.plan(self.perceive(observation), observation)

    def perceive(self, observation: Observation) -> Perception:
        """Flow, focus of expansion, road edges, bodies of one frame; obstacle map and time to contact on request.

        Of a frame that is not looked at or is none, what was seen in the last one that was, from where the vehicle is
        now. A frame that arrives late is looked at from where it was taken.
        """
        is_due, self._frame = self.looks, self._frame + 1
        taken = self._taken(observation, is_due)
        if self._seen is None or (is_due and taken is not None):
            taken = taken or observation
            self._seen, self._seen_s = self._look(taken, _pose(taken)), taken.time_s
            self._waits = 0
            if taken is observation:
                return self._seen
        elif is_due:
            self._waits += 1
        return self._carried(self._seen, observation, _pose(observation))

    def unless_blind(self, reference: Reference, observation: Observation) -> Reference:
        """The reference; after too long without a new frame, one that brakes to a stop."""
        if observation.time_s - self._seen_s <= BLIND_S:
            return reference
        return replace(reference, speed_mps=min(reference.speed_mps, max(eased(observation.speed_mps), 0.0)))

    def _taken(self, observation: Observation, is_due: bool) -> Observation | None:
        """The observation of the moment at which the frame was taken; None without a frame to be trusted.

        Frames that are not due are not judged, either: a drive that is watched must be the same as one that is not.
        """
        oldest_s = observation.time_s - REMEMBERED_S
        while self._past and self._past[0].time_s < oldest_s:
            self._past.popleft()
        self._past.append(replace(observation, image=NO_IMAGE))
        if not is_due or not observation.image.size:
            return None
        if observation.frame_time_s < observation.time_s:
            then = [past for past in self._past if past.time_s <= observation.frame_time_s + 1e-6]
            taken = replace(then[-1] if then else self._past[0], image=observation.image)
        else:
            taken = observation
        return taken if self._gate.passes(taken.image, taken.frame_time_s, (taken.x_m, taken.y_m)) else None

    def _carried(self, seen: Perception, observation: Observation, pose: Floats) -> Perception:
        """What was seen, at another pose: by the own motion, and that of the bodies."""
        speed_mps, tentative = observation.speed_mps, seen.tentative
        road = self._road.carried(pose, speed_mps, observation.yaw_rate_radps)
        if tentative is not None:
            tentative = to_current_frame(tentative, seen.pose, pose, speed_mps)
        bodies = self._known(seen, observation, pose)
        sight_m = self._sight_m(seen, observation)
        return replace(seen, obstacles=bodies, road=road, pose=pose, tentative=tentative, low_sensing_range_m=sight_m)

    def _sight_m(self, seen: Perception, observation: Observation) -> tuple[float, float]:
        """How far low bodies would be suspected: less the way that was driven since a frame that is late."""
        since_s = observation.time_s - self._seen_s
        if since_s <= 1.5 * self._period_s:
            return seen.low_sensing_range_m
        now_m, best_m = seen.low_sensing_range_m
        return max(now_m - observation.speed_mps * (since_s - self._period_s), 0.0), best_m

    def _known(self, seen: Perception, observation: Observation, pose: Floats) -> Obstacles:
        """The bodies of the last look, in the axes of another pose and where those that move are by now."""
        since_s = observation.time_s - self._seen_s
        return carried(seen.obstacles, seen.pose, pose, observation.speed_mps, seen.road, since_s)

    def _look(self, observation: Observation, pose: Floats) -> Perception:
        """What one frame shows."""
        image = grey(observation.image)
        if observation.time_s - self._seen_s > max(FOLLOWED_S, 2.5 * self._period_s):
            self._flow.restart()
        flow = self._flow.update(image, pose, late=min(self._waits / self._every, MOST_LATE))
        if self._keyframes is not None:
            self._keyframes.note(image)
        turned = expansion.derotated(flow, self._camera)
        foe = expansion.estimate(flow, self._camera, self._variant.focus_of_expansion, self._random, self._foe, turned)
        self._foe = foe
        steady = self._steadied(flow, foe, turned)
        motion = (observation.speed_mps, observation.yaw_rate_radps)
        bodies = _nothing() if self._seen is None else self._known(self._seen, observation, pose)
        road = self._road.update(observation.image, image, pose, *motion, bodies)
        sight_m, tentative = (np.inf, np.inf), None
        if self._static_obstacles is not None:
            view = self._view(observation, image, pose, self._static_obstacles)
            bodies = self._bodies(self._static_obstacles, view, flow, steady, road, observation)
            sight_m = self._static_obstacles.low_sensing_range_m(observation.speed_mps, self._speed_reference_mps)
            tentative = self._static_obstacles.tentative(pose)
        if self._pitch_estimator is not None and self._road.pitch is not None:
            self._pitch_estimator.level(*self._road.pitch, observation.time_s)
        salience = cache(partial(self._salience, flow, steady, foe, turned, road, observation.speed_mps))
        return Perception(flow, foe, salience, bodies, road, pose, sight_m, tentative)

    def _steadied(self, flow: Flow, foe: Expansion, turned: Derotated) -> Flow:
        """The flow without the body's pitching, of which the road is told, too."""
        if self._pitch_estimator is None:
            return flow
        before_rad = self._pitch_estimator.passing_rad
        steady = self._pitch_estimator.update(flow, foe, turned)
        self._road.turn(self._pitch_estimator.passing_rad - before_rad)
        return steady

    def _view(
        self, observation: Observation, image: Image, pose: Floats, static_obstacles: StaticObstacleTracker
    ) -> Image | None:
        """The picture in which the road is compared, where it is in this frame; None beneath the wiper."""
        if self._flow.is_swept:
            return None
        second = self._verifier
        if not static_obstacles.looks and (second is None or not second.looks(pose, observation.speed_mps)):
            return image
        view = contrast(observation.image, image)
        return view if self._pitch_estimator is None else self._pitch_estimator.frame(view)

    def _bodies(
        self,
        static_obstacles: StaticObstacleTracker,
        view: Image | None,
        flow: Flow,
        steady: Flow,
        road: RoadEdges,
        observation: Observation,
    ) -> Obstacles:
        """Those that the look at the road and the flow tell of, and that a second look does not refute."""
        pose, speed_mps, moving = flow.pose, observation.speed_mps, None
        if self._moving_obstacles is not None and static_obstacles.looks:
            moving = self._moving_obstacles.moving(pose, speed_mps)
        static_obstacles.look(view, pose, road, moving, speed_mps)
        match = partial(self._keyframes.aside_px, flow) if self._keyframes is not None else None
        told = self._find_bodies(static_obstacles, steady, match, road, observation)
        if self._verifier is None:
            return told
        bodies = self._verifier.update(view, pose, told, speed_mps, static_obstacles.is_verified)
        static_obstacles.refute(told.identity[~among(told.identity, bodies.identity)])
        return bodies

    def _salience(
        self, flow: Flow, steady: Flow, foe: Expansion, turned: Derotated, road: RoadEdges, speed_mps: float
    ) -> PaperFeatures:
        """Obstacle map and time to contact of a frame's points."""
        config, around = self._variant.obstacle_map, None
        if config.needs_surroundings:
            ttc_s = contact.time_to_contact(flow, foe, self._camera, self._variant.time_to_contact, None, turned)
            around = Surroundings(road, speed_mps, ttc_s)
        obstacle_map = obstacles.detect(steady, self._camera, config, around)
        labels = obstacles.cluster_labels(obstacle_map, flow)
        ttc_s = contact.time_to_contact(flow, foe, self._camera, self._variant.time_to_contact, labels, turned)
        return PaperFeatures(obstacle_map, ttc_s)

    @staticmethod
    def _remembered(camera: Camera, variant: Variant, rate_hz: float) -> KeyframeBuffer | None:
        """The frames of first sightings, where bodies are told by them."""
        if variant.static_obstacles is None or variant.flow.keyframe_s is None:
            return None
        return KeyframeBuffer(
            camera, variant.static_obstacles.window_px, round(2.0 * variant.flow.keyframe_s * rate_hz)
        )

    def _find_bodies(
        self,
        static_obstacles: StaticObstacleTracker,
        flow: Flow,
        match: Match | None,
        road: RoadEdges,
        observation: Observation,
    ) -> Obstacles:
        """Those that stand, and those that move."""
        speed_mps, time_s = observation.speed_mps, observation.time_s
        moving, points = None, static_obstacles.triangulate(flow)
        if self._moving_obstacles is not None:
            moving = self._moving_obstacles.update(flow, points, road, speed_mps, time_s)
        if match is not None:
            points = static_obstacles.refined(flow, points, road, match)
        standing = static_obstacles.update(flow, road, speed_mps, time_s, points, moving)
        if self._moving_obstacles is None or not self._moving_obstacles.reports:
            return standing
        return self._moving_obstacles.obstacles(flow.pose, speed_mps, standing)

    def plan(self, perception: Perception, observation: Observation) -> Plan:
        """Target, obstacle and road field, their sum, heading and speed reference."""
        force, reference, extra = self._way.step(perception, observation)
        return Plan(perception, force, self.unless_blind(reference, observation), extra)


def way(setup: DriverSetup, variant: Variant) -> PaperPlanner | LanePlanner:
    """How the variant goes through its field."""
    if variant.lane_planner is not None:
        return LanePlanner(setup, variant.lane_planner)
    assert variant.paper_planner is not None  # Variant has checked
    return PaperPlanner(setup, variant.paper_planner)


def _pose(observation: Observation) -> Floats:
    """(3,) x m, y m, yaw rad."""
    return np.array([observation.x_m, observation.y_m, observation.yaw_rad])


def _nothing() -> Obstacles:
    none = np.empty(0)
    return Obstacles(none, none, none, none, none, np.empty(0, np.int64))
