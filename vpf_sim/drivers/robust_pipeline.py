"""The robust pipeline: as the paper's to the road, then obstacles that stand, lie low and move, tracked over frames."""

from functools import partial

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.frame_state import FrameState
from vpf_sim.drivers.paper_pipeline import FEEDBACK, INPUTS, CommonStages, FrameTrackers
from vpf_sim.perception.contrast import contrast
from vpf_sim.perception.egomotion.keyframes import KeyframeBuffer
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.crossing import Crossers, CrossingDetector, nobody
from vpf_sim.perception.obstacles.moving.tracker import MovingObstacleTracker
from vpf_sim.perception.obstacles.point_motion import PointMotions, point_motions
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.perception.obstacles.static_tracker import StaticObstacleTracker
from vpf_sim.pipeline import Pipeline, stage
from vpf_sim.planning.variant import Variant
from vpf_sim.types import Bools, Camera, Floats, Flow, Image, LowObstacleRange, Obstacles, RoadEdges


def robust_pipeline(
    setup: DriverSetup, variant: Variant, trackers: FrameTrackers, config: StaticObstacleConfig
) -> Pipeline[FrameState]:
    """The stages from a frame to obstacles and road.

    `obstacles` of the last frame hide the road in this one.
    """
    common = CommonStages(setup, variant, trackers)
    its = ObstacleStages(setup, variant, trackers, config)
    stages = [
        *common.egomotion(),
        stage("keyframe", its.remember_frame, "grey"),
        common.road(),
        stage("planar_parallax", its.compare_road, "observation grey pose road"),
        stage("triangulation", its.static.triangulate, "steady_flow", "points"),
        stage("moving_obstacles", its.track_moving, "steady_flow points road observation", "on_moving"),
        stage("crossing", its.find_crossers, "steady_flow on_moving observation", "motions crossers on_moving"),
        stage("track_refinement", its.refine, "flow steady_flow points road observation", "points"),
        stage("static_obstacles", its.track_static, "steady_flow road observation points on_moving", "obstacles"),
        stage("oncoming", its.find_oncoming, "points road observation crossers", "crossers"),
        stage("relief", its.static.relief, "obstacles", "relief"),
        stage("sensing_range", its.sensing_range, "observation", "low_range_m"),
        common.point_features(),
        common.mount_pitch(),
    ]
    if variant.crossing is None:
        stages = [one for one in stages if one.name not in ("crossing", "oncoming", "relief")]
    return Pipeline(FrameState, stages, INPUTS, FEEDBACK)


class ObstacleStages:
    """The stages that find and track obstacles."""

    def __init__(
        self, setup: DriverSetup, variant: Variant, trackers: FrameTrackers, config: StaticObstacleConfig
    ) -> None:
        camera, rate_hz, window_px = setup.camera, trackers.flow.rate_hz, variant.flow.window_px
        self._trackers, self._speed_reference_mps = trackers, setup.speed_reference_mps
        self.static = StaticObstacleTracker(camera, config, rate_hz, window_px)
        moving = variant.moving_obstacles
        self._moving = MovingObstacleTracker(camera, moving, rate_hz, window_px, config.noise) if moving else None
        self._crossing = CrossingDetector(camera, variant.crossing) if variant.crossing else None
        self._point_motions = partial(point_motions, camera=camera, window_px=window_px, noise=config.noise)
        self._keyframes = _keyframes(camera, variant, rate_hz)

    def remember_frame(self, grey: Image) -> None:
        """Keep the frame, for points that are compared with their first observation."""
        if self._keyframes is not None:
            self._keyframes.push(grey)

    def compare_road(self, observation: Observation, grey: Image, pose: Floats, road: RoadEdges) -> None:
        """Compare the road ahead with how it looked before, for low obstacles: in colour, without the camera's pitch.

        No road is expected where moving obstacles are by now.
        """
        view = moving = None
        if self.static.parallax.looks and not self._trackers.flow.is_swept:
            view, pitch = contrast(observation.image, grey), self._trackers.pitch
            view = view if pitch is None else pitch.frame(view)
            moving = self._moving.moving(pose) if self._moving else None
        self.static.compare_road(view, pose, road, moving, observation.speed_mps)

    def track_moving(
        self, steady: Flow, points: Triangulation, road: RoadEdges, observation: Observation
    ) -> Bools | None:
        """(N,) points of the flow on moving obstacles."""
        if self._moving is None:
            return None
        return self._moving.update(steady, points, road, observation.speed_mps, observation.time_s)

    def find_crossers(
        self, steady: Flow, on_moving: Bools | None, observation: Observation
    ) -> tuple[PointMotions | None, Crossers, Bools | None]:
        """Motions of points outside, actors that cross, and (N,) points on what moves; none beneath the wiper."""
        if self._crossing is None or self._trackers.flow.is_swept:
            return None, nobody(), on_moving
        motions = self._point_motions(steady)
        crossers, near = self._crossing.find(steady, motions, observation.speed_mps)
        outside = motions.select(~steady.on_glass)
        return outside, crossers, near if on_moving is None else near | on_moving

    def refine(
        self, flow: Flow, steady: Flow, points: Triangulation, road: RoadEdges, observation: Observation
    ) -> Triangulation:
        """The points, those above the road matched again with the frame of their first observation."""
        if self._keyframes is None:
            return points
        return self.static.refined(steady, points, road, partial(self._keyframes.register, flow), observation.speed_mps)

    def track_static(
        self, steady: Flow, road: RoadEdges, observation: Observation, points: Triangulation, on_moving: Bools | None
    ) -> Obstacles:
        """Static obstacles after this frame, and moving ones."""
        motion = observation.speed_mps, observation.time_s
        static = self.static.update(steady, road, *motion, points, on_moving)
        return static.concatenate(self._moving.moving(steady.pose)) if self._moving else static

    def find_oncoming(
        self, points: Triangulation, road: RoadEdges, observation: Observation, crossers: Crossers
    ) -> Crossers:
        """Actors that cross, and vehicles that come."""
        return crossers.concatenate(self.static.oncoming(points, road, observation.speed_mps))

    def sensing_range(self, observation: Observation) -> LowObstacleRange:
        """How far low obstacles are tentative by now at this speed, and with a good view at the reference speed."""
        sight, needed = self.static.parallax.sight, self.static.config.low_tracks.hits
        now_m, best_m = sight.distance_m(observation.speed_mps, needed), sight.good_m(self._speed_reference_mps, needed)
        return LowObstacleRange(now_m, best_m)


def _keyframes(camera: Camera, variant: Variant, rate_hz: float) -> KeyframeBuffer | None:
    """The frames of first observations, where points are compared with them."""
    if variant.flow.keyframe_s is None:
        return None
    return KeyframeBuffer(camera, variant.flow.window_px, round(2.0 * variant.flow.keyframe_s * rate_hz))
