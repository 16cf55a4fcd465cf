"""Perception at every step: a pipeline on the frames that are due, and prediction in between."""

from collections import deque
from dataclasses import replace
from math import inf

import numpy as np

from vpf_sim.braking import comfortable_speed
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.frame_state import FrameState
from vpf_sim.drivers.paper_pipeline import FrameTrackers, paper_pipeline
from vpf_sim.drivers.robust_pipeline import robust_pipeline
from vpf_sim.perception.egomotion.odometry import Odometry
from vpf_sim.perception.frame_gate import FrameGate
from vpf_sim.perception.obstacles.prediction import predict
from vpf_sim.perception.plausible import Plausibility
from vpf_sim.perception.schedule import Schedule
from vpf_sim.planning.variant import FrameConfig, Variant
from vpf_sim.scene.evidence import Evidence
from vpf_sim.timing import timed
from vpf_sim.types import Image, LowObstacleRange, Obstacles, Perception

NO_IMAGE: Image = np.empty((0, 0, 3), np.uint8)


class OwnMotion:
    """What the car knows of its own motion: signals that can be, and the pose that the odometry makes of them."""

    def __init__(self, setup: DriverSetup, variant: Variant) -> None:
        self._plausibility = Plausibility(variant.plausibility, setup.vehicle)
        self._odometry = Odometry(variant.odometry, setup.vehicle) if variant.odometry else None

    def update(self, observation: Observation) -> Observation:
        """The observation with them; called once for each."""
        observation = self._plausibility.update(observation)
        return observation if self._odometry is None else self._odometry.update(observation)


class FrameSelection:
    """Waits for a frame that is due, and pairs it with the pose of the moment at which it was taken."""

    def __init__(self, config: FrameConfig, schedule: Schedule, gate: FrameGate) -> None:
        self._config, self._schedule, self._gate = config, schedule, gate
        self._past: deque[Observation] = deque()  # without images, oldest first
        self._waited = 0  # frames since one was due that could not be processed
        self.late = 0.0  # share of a period by which the selected frame was taken after its turn

    @property
    def needs_next_frame(self) -> bool:
        """Whether the next frame is due."""
        return self._waited > 0 or self._schedule.is_due

    @property
    def has_missed(self) -> bool:
        """Whether the last frame that was due was none, or not a valid one."""
        return self._waited > 0

    def select(self, observation: Observation) -> Observation | None:
        """The observation of the moment at which a valid frame was taken; None where no frame is to be processed.

        The first frame is always processed. Frames that are not due are not checked: a drive that is watched must be
        the same as one that is not.
        """
        is_first, is_due = not self._past, self.needs_next_frame
        self._schedule.step()
        self._remember(observation)
        if not is_due:
            return None
        taken = self._valid(observation) or (observation if is_first else None)
        self.late = min(self._waited / self._schedule.frames, self._config.latest_share)
        self._waited = self._waited + 1 if taken is None else 0
        return taken

    def _valid(self, observation: Observation) -> Observation | None:
        """The observation of the moment at which its frame was taken, if that is new and whole."""
        if not observation.image.size:
            return None
        taken = self._when_taken(observation)
        return taken if self._gate.passes(taken.image, taken.frame_time_s, (taken.x_m, taken.y_m)) else None

    def _remember(self, observation: Observation) -> None:
        oldest_s = observation.time_s - self._config.remembered_s
        while self._past and self._past[0].time_s < oldest_s:
            self._past.popleft()
        self._past.append(replace(observation, image=NO_IMAGE))

    def _when_taken(self, observation: Observation) -> Observation:
        """The observation at the time stamp of its frame."""
        if observation.frame_time_s >= observation.time_s:
            return observation
        then = [past for past in self._past if past.time_s <= observation.frame_time_s + 1e-6]
        return replace(then[-1] if then else self._past[0], image=observation.image)


class Perceiver:
    """What one variant perceives during one episode."""

    def __init__(self, setup: DriverSetup, variant: Variant, trackers: FrameTrackers | None = None) -> None:
        schedule = Schedule(variant.flow.period_s, setup.rate_hz, at_least_as_often=True)
        self._config, self._period_s = variant.frames, 1.0 / schedule.rate_hz
        self._selection = FrameSelection(variant.frames, schedule, FrameGate(variant.frame_gate))
        self._trackers = trackers or FrameTrackers.create(setup, variant, schedule.rate_hz)
        self.pipeline = (
            robust_pipeline(setup, variant, self._trackers, variant.static_obstacles)
            if variant.static_obstacles is not None
            else paper_pipeline(setup, variant, self._trackers)
        )
        self._state = FrameState()
        self._last: Perception | None = None  # of the last frame that was processed,
        self._last_s = 0.0  # and the time at which it was taken
        self._has_processed = False  # a frame at the last step

    @property
    def needs_next_frame(self) -> bool:
        """Whether it processes the next frame."""
        return self._selection.needs_next_frame

    @property
    def evidence(self) -> Evidence | None:
        """What the frame of the last step shows beside obstacles; None if it was not processed."""
        frame = self._state
        return Evidence(frame.crossers, frame.points, frame.motions, frame.relief) if self._has_processed else None

    @property
    def has_missed(self) -> bool:
        """Whether the last frame that it was to process was none, or not a valid one."""
        return self._selection.has_missed

    def perceive(self, observation: Observation) -> Perception:
        """What is known at this observation: from its frame if one is due and valid, else predicted.

        A frame that arrives late is processed at the pose at which it was taken.
        """
        taken = self._selection.select(observation)
        self._has_processed = taken is not None
        if taken is not None:
            self._last = self._process(taken)
            self._last_s = taken.time_s
            if taken is observation:
                return self._last
        assert self._last is not None  # the first frame is always processed
        return self._predicted(self._last, observation)

    def limit_mps(self, observation: Observation) -> float:
        """The speed limit: inf, or after too long without a new frame one that brakes to a stop."""
        if observation.time_s - self._last_s <= self._config.blind_s:
            return inf
        return max(comfortable_speed(observation.speed_mps), 0.0)

    def _process(self, taken: Observation) -> Perception:
        """Run the pipeline on a frame."""
        state = self._state
        state.observation, state.pose, state.late = taken, taken.pose, self._selection.late
        state.gap_s = taken.time_s - self._last_s
        if self._last is not None:
            state.obstacles = self._moved(self._last, taken)
        self.pipeline.run(state)
        assert state.foe is not None
        return Perception(
            flow=state.flow,
            expansion=state.foe,
            features=state.features,
            obstacles=state.obstacles,
            road=state.road,
            pose=state.pose,
            low_range_m=state.low_range_m,
        )

    @timed("prediction")
    def _predicted(self, last: Perception, observation: Observation) -> Perception:
        """The last frame's perception at another pose, by the car's own motion and the obstacles' motion."""
        road = self._trackers.road.predicted(observation.pose, observation.speed_mps, observation.yaw_rate_radps)
        return replace(
            last,
            obstacles=self._moved(last, observation),
            road=road,
            pose=observation.pose,
            low_range_m=self._low_range(last, observation),
        )

    def _low_range(self, last: Perception, observation: Observation) -> LowObstacleRange:
        """The sensing range of low obstacles, less the distance driven since a late frame."""
        since_s = observation.time_s - self._last_s
        if since_s <= 1.5 * self._period_s:
            return last.low_range_m
        now_m, best_m = last.low_range_m
        return LowObstacleRange(max(now_m - observation.speed_mps * (since_s - self._period_s), 0.0), best_m)

    def _moved(self, last: Perception, observation: Observation) -> Obstacles:
        """The last frame's obstacles in the axes at an observation, the moving ones where they are by then."""
        since_s = observation.time_s - self._last_s
        return predict(last.obstacles, last.pose, observation.pose, last.road, since_s)
