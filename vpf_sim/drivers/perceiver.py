"""Perception at every step: a pipeline on the frames that are due, and prediction in between."""

from dataclasses import replace

from vpf_sim.braking import comfortable_speed
from vpf_sim.drivers.frame_selection import FrameSelection
from vpf_sim.drivers.frame_state import FrameState
from vpf_sim.drivers.paper_pipeline import FrameTrackers, paper_pipeline
from vpf_sim.drivers.robust_pipeline import robust_pipeline
from vpf_sim.perception.frame_gate import FrameGate
from vpf_sim.perception.obstacles.prediction import predict
from vpf_sim.perception.schedule import Schedule
from vpf_sim.planning.variant import Variant
from vpf_sim.timing import timed
from vpf_sim.types import DriverSetup, Floats, LowObstacleRange, Observation, Obstacles, Perception, Reference


class Perceiver:
    """What one variant perceives during one episode."""

    def __init__(
        self,
        setup: DriverSetup,
        variant: Variant,
        trackers: FrameTrackers | None = None,
        gate: FrameGate | None = None,
    ) -> None:
        schedule = Schedule(variant.flow.period_s, setup.rate_hz, at_least_as_often=True)
        self.frame_rate_hz = schedule.rate_hz  # of the frames that are processed
        self._config, self._period_s = variant.frames, 1.0 / schedule.rate_hz
        self._selection = FrameSelection(variant.frames, schedule, gate or FrameGate(variant.frame_gate))
        self._trackers = trackers or FrameTrackers.create(setup, variant, schedule.rate_hz)
        self.pipeline = (
            robust_pipeline(setup, variant, self._trackers, variant.static_obstacles)
            if variant.static_obstacles is not None
            else paper_pipeline(setup, variant, self._trackers)
        )
        self._state = FrameState()
        self._last: Perception | None = None  # of the last frame that was processed,
        self._last_s = 0.0  # and the time at which it was taken
        self.has_processed = False  # a frame at the last step

    @property
    def needs_next_frame(self) -> bool:
        """Whether it processes the next frame."""
        return self._selection.needs_next_frame

    @property
    def has_missed(self) -> bool:
        """Whether the last frame that it was to process was none, or not a valid one."""
        return self._selection.has_missed

    def perceive(self, observation: Observation) -> Perception:
        """What is known at this observation: from its frame if one is due and valid, else predicted.

        A frame that arrives late is processed at the pose at which it was taken.
        """
        taken = self._selection.select(observation)
        self.has_processed = taken is not None
        if taken is not None:
            self._last = self._process(taken, taken.pose)
            self._last_s = taken.time_s
            if taken is observation:
                return self._last
        assert self._last is not None  # the first frame is always processed
        return self._predicted(self._last, observation, observation.pose)

    def stop_when_blind(self, reference: Reference, observation: Observation) -> Reference:
        """The reference; after too long without a new frame, one that brakes to a stop."""
        if observation.time_s - self._last_s <= self._config.blind_s:
            return reference
        slower = max(comfortable_speed(observation.speed_mps), 0.0)
        return replace(reference, speed_mps=min(reference.speed_mps, slower))

    def _process(self, taken: Observation, pose: Floats) -> Perception:
        """Run the pipeline on a frame."""
        state = self._state
        state.observation, state.pose, state.late = taken, pose, self._selection.late
        state.gap_s = taken.time_s - self._last_s
        if self._last is not None:
            state.obstacles = self._moved(self._last, taken, pose)
        self.pipeline.run(state)
        assert state.foe is not None
        return Perception(
            flow=state.flow,
            expansion=state.foe,
            features=state.features,
            obstacles=state.obstacles,
            road=state.road,
            pose=pose,
            low_range_m=state.low_range_m,
        )

    @timed("prediction")
    def _predicted(self, last: Perception, observation: Observation, pose: Floats) -> Perception:
        """The last frame's perception at another pose, by the car's own motion and the obstacles' motion."""
        road = self._trackers.road.carried(pose, observation.speed_mps, observation.yaw_rate_radps)
        return replace(
            last,
            obstacles=self._moved(last, observation, pose),
            road=road,
            pose=pose,
            low_range_m=self._low_range(last, observation),
        )

    def _low_range(self, last: Perception, observation: Observation) -> LowObstacleRange:
        """The sensing range of low obstacles, less the way that was driven since a frame that is late."""
        since_s = observation.time_s - self._last_s
        if since_s <= 1.5 * self._period_s:
            return last.low_range_m
        now_m, best_m = last.low_range_m
        return LowObstacleRange(max(now_m - observation.speed_mps * (since_s - self._period_s), 0.0), best_m)

    def _moved(self, last: Perception, observation: Observation, pose: Floats) -> Obstacles:
        """The last frame's obstacles in the axes of another pose, the moving ones where they are by now."""
        since_s = observation.time_s - self._last_s
        return predict(last.obstacles, last.pose, pose, observation.speed_mps, last.road, since_s)
