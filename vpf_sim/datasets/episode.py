"""A stored episode, drawn again frame by frame, with its states, actions and rewards."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vpf_sim.datasets.contents import Contents, state_of
from vpf_sim.envs.ending import TERMINATED
from vpf_sim.evaluation.episode.episode import read
from vpf_sim.evaluation.episode.pose_playback import PosePlayback, rate_of
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting.cells import shown
from vpf_sim.types import Bools, Floats, Image


def task_of(record: Record) -> str:
    """What is to be done in an episode, in words."""
    return f"Drive to the goal. Road: {shown(record.scenario)}. Weather: {shown(record.weather)}."


class Frame(NamedTuple):
    """One frame as it is stored."""

    row: int  # of the step table
    picture: Image  # (H, W, C)
    truths: dict[str, NDArray[np.generic]]


@dataclass(slots=True)
class Episode:
    """An episode of n steps and n + 1 frames; what depends on frames is there when `frames` has ended."""

    record: Record
    table: StepTable
    contents: Contents
    inputs: RunInputs = field(default_factory=RunInputs)
    states: list[Floats] = field(default_factory=list)  # n + 1 of (7,), as the driver was told them
    rewards: list[float] = field(default_factory=list)  # n
    remarks: list[str] = field(default_factory=list)  # how the frames differ from those of the run
    is_verified: bool = False  # the frames have the hash of those that the driver saw

    def __len__(self) -> int:
        return len(self.table)

    @property
    def rate_hz(self) -> float:
        return rate_of(self.table)

    @property
    def task(self) -> str:
        return task_of(self.record)

    @property
    def actions(self) -> Floats:
        """(n, 2) throttle and steering, as recorded."""
        return np.column_stack([self.table.throttle, self.table.steering])[: len(self)]

    @property
    def terminations(self) -> Bools:
        """(n,) whether a step ended the episode at the goal, in a collision or off the road."""
        return self._last_is(self.record.status in TERMINATED)

    @property
    def truncations(self) -> Bools:
        """(n,) whether the episode was cut after a step, by a limit or an error."""
        return self._last_is(self.record.status not in TERMINATED)

    @property
    def successes(self) -> Bools:
        """(n,) whether a step reached the goal."""
        return self._last_is(self.record.succeeded)

    def frames(self) -> Iterator[Frame]:
        """Draw the n + 1 frames."""
        self.states.clear()
        self.rewards.clear()
        record = self.record
        with closing(PosePlayback.of(record, self.table, self.inputs, self.contents.truth)) as world:
            for played in world.play(record.seed):
                observation = read(played.observed)
                self.states.append(state_of(observation))
                if played.index:
                    self.rewards.append(played.reward)
                yield Frame(played.index, self.contents.picture(observation.image), self.contents.truths(played.info))
        self.remarks = world.deviations(record)
        self.is_verified = record.frames_sha256 is not None and world.has_frames_of(record)

    def _last_is(self, value: bool) -> Bools:
        flags = np.zeros(len(self), np.bool_)
        flags[-1] = value
        return flags
