"""The paper's pipeline: flow, focus of expansion, road edges, time to contact and obstacle map of each frame."""

from dataclasses import dataclass

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.frame_state import FrameState
from vpf_sim.perception.egomotion import focus_of_expansion
from vpf_sim.perception.egomotion.camera_pitch import PitchEstimator
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.perception.egomotion.focus_of_expansion import Derotated
from vpf_sim.perception.paper.features import FrameFeatures
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.pipeline import Pipeline, Stage, stage
from vpf_sim.planning.variant import Variant
from vpf_sim.seeding import stream
from vpf_sim.types import Expansion, Floats, Flow, Image, Obstacles, PointFeatures, RoadEdges

INPUTS = "observation pose gap_s late"
FEEDBACK = "foe obstacles"


@dataclass(frozen=True, slots=True)
class FrameTrackers:
    """What both pipelines remember from frame to frame."""

    flow: FlowTracker
    road: RoadEdgeTracker
    pitch: PitchEstimator | None

    @classmethod
    def create(cls, setup: DriverSetup, variant: Variant, rate_hz: float) -> "FrameTrackers":
        """New trackers for frames that come at `rate_hz`."""
        camera = setup.camera
        return cls(
            FlowTracker(camera, variant.flow, rate_hz),
            RoadEdgeTracker(camera, variant.road_edges, rate_hz, variant.verges),
            PitchEstimator(camera, variant.camera_pitch, rate_hz) if variant.camera_pitch else None,
        )


def paper_pipeline(setup: DriverSetup, variant: Variant, trackers: FrameTrackers) -> Pipeline[FrameState]:
    """The stages from a frame to what the paper's planner needs."""
    common = CommonStages(setup, variant, trackers)
    stages = [
        *common.egomotion(),
        common.road(),
        common.point_features(),
        common.mount_pitch(),
    ]
    return Pipeline(FrameState, stages, INPUTS, FEEDBACK)


class CommonStages:
    """The stages that both pipelines share."""

    def __init__(self, setup: DriverSetup, variant: Variant, trackers: FrameTrackers) -> None:
        self.camera, self.variant, self.trackers = setup.camera, variant, trackers
        self._random = stream(setup.seed, "focus of expansion")

    def egomotion(self) -> list[Stage]:
        """From the frame to its optical flow, focus of expansion and camera pitch."""
        return [
            stage("grey", self._grey, "observation", "grey"),
            stage("flow", self._flow, "grey pose gap_s late", "flow"),
            stage("derotation", self._derotated, "flow", "derotated"),
            stage("focus_of_expansion", self._foe, "flow foe derotated", "foe"),
            stage("camera_pitch", self._pitch, "flow foe derotated", "steady_flow pitch_change_rad"),
        ]

    def road(self) -> Stage:
        """The carriageway; obstacles of the last frame hide its lines."""
        return stage("road", self._road, "observation grey pose pitch_change_rad obstacles", "road road_pitch")

    def point_features(self) -> Stage:
        """Obstacle map and time to contact of the flow's points, worked out when they are read."""
        return stage("point_features", self._features, "flow steady_flow foe derotated road observation", "features")

    def mount_pitch(self) -> Stage:
        """What the road's lines tell of the camera's mounting: the next frame's pitch starts from it."""
        return stage("mount_pitch", self._mount_pitch, "road_pitch observation")

    def _grey(self, observation: Observation) -> Image:
        return grey(observation.image)

    def _flow(self, image: Image, pose: Floats, gap_s: float, late: float) -> Flow:
        tracker = self.trackers.flow
        if gap_s > max(self.variant.frames.longest_gap_s, 2.5 / tracker.rate_hz):
            tracker.restart()
        return tracker.update(image, pose, late=late)

    def _derotated(self, flow: Flow) -> Derotated:
        return focus_of_expansion.derotated(flow, self.camera)

    def _foe(self, flow: Flow, before: Expansion | None, derotated: Derotated) -> Expansion:
        config = self.variant.focus_of_expansion
        return focus_of_expansion.estimate(flow, self.camera, config, self._random, before, derotated)

    def _pitch(self, flow: Flow, foe: Expansion, derotated: Derotated) -> tuple[Flow, float]:
        pitch = self.trackers.pitch
        if pitch is None:
            return flow, 0.0
        before_rad = pitch.dynamic_rad
        steady = pitch.update(flow, foe, derotated)
        return steady, pitch.dynamic_rad - before_rad

    def _mount_pitch(self, road_pitch: tuple[float, float] | None, observation: Observation) -> None:
        if self.trackers.pitch is not None and road_pitch is not None:
            self.trackers.pitch.update_mount_pitch(*road_pitch, observation.time_s)

    def _road(
        self, observation: Observation, grey: Image, pose: Floats, pitch_change_rad: float, hiding: Obstacles
    ) -> tuple[RoadEdges, tuple[float, float] | None]:
        road = self.trackers.road
        if self.trackers.pitch is not None:
            road.turn(pitch_change_rad)
        motion = (observation.speed_mps, observation.yaw_rate_radps)
        return road.update(observation.image, grey, pose, *motion, hiding), road.pitch

    def _features(
        self,
        flow: Flow,
        steady: Flow,
        foe: Expansion,
        derotated: Derotated,
        road: RoadEdges,
        observation: Observation,
    ) -> PointFeatures:
        variant, speed_mps = self.variant, observation.speed_mps
        return FrameFeatures(
            flow, steady, foe, derotated, road, speed_mps, self.camera, variant.obstacle_map, variant.time_to_contact
        )
