"""Which frames are processed: those that are due, new and whole, each with the state of its moment."""

from collections import deque
from dataclasses import replace

import numpy as np

from vpf_sim.perception.frame_gate import FrameGate
from vpf_sim.perception.schedule import Schedule
from vpf_sim.planning.variant import FrameConfig
from vpf_sim.types import Image, Observation

NO_IMAGE: Image = np.empty((0, 0, 3), np.uint8)


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
