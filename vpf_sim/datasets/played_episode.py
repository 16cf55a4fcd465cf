"""A stored episode, drawn again frame by frame, with its states, actions and rewards."""

from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.driver_interface import Observation
from vpf_sim.envs.ending import TERMINATED
from vpf_sim.envs.four_lane import TRUTHS
from vpf_sim.errors import InputError, option, shown, unknown_name
from vpf_sim.evaluation.environment import Info
from vpf_sim.evaluation.episode.episode import read
from vpf_sim.evaluation.episode.pose_playback import PosePlayback, rate_of
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.reporting import main_table
from vpf_sim.types import Bools, Camera, Floats, Image

STATE = ("speed_mps", "yaw_rate_radps", "x_m", "y_m", "yaw_rad", "goal_forward_m", "goal_right_m")
ACTION = ("throttle", "steering")
CAMERA = Camera()  # of every run
LEAST_PX = 16


def state_of(observation: Observation) -> Floats:
    """(7,) the state vector of a data set, by the names in `STATE`: the goal is in vehicle axes.

    A driver of a learned policy calls it, too, so that it sees what the policy was trained on.
    """
    goal_m = vehicle_from_world(np.array(observation.goal_m), observation.pose)
    return np.array([observation.speed_mps, observation.yaw_rate_radps, *observation.pose, *goal_m])


@dataclass(frozen=True, slots=True)
class Contents:
    """How the frames of a data set are stored."""

    width_px: int = CAMERA.width_px
    height_px: int = CAMERA.height_px
    grey: bool = False
    truth: tuple[str, ...] = ()

    @classmethod
    def of(cls, size: object, grey: object, truth: object) -> "Contents":
        """The requested contents; InputError for others."""
        if not isinstance(grey, bool):
            raise InputError(f"{option('grey')}: expected True or False, got {shown(grey)}")
        if isinstance(truth, str) or not isinstance(truth, Iterable):
            raise InputError(f"{option('truth')}: expected names, such as ('depth',), got {shown(truth)}")
        names = tuple(dict.fromkeys(truth))
        for name in names:
            if name not in TRUTHS:
                raise unknown_name("truth", str(name), TRUTHS)
        return cls(*_checked_size(size), grey, names)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(H, W, C) of a picture."""
        return self.height_px, self.width_px, 1 if self.grey else 3

    @property
    def is_resized(self) -> bool:
        return (self.width_px, self.height_px) != (CAMERA.width_px, CAMERA.height_px)

    def picture(self, frame: Image) -> Image:
        """(H, W, C) a camera's frame as it is stored: the mean of the pixels that each one covers."""
        picture = grey(frame)[..., None] if self.grey else frame
        if self.is_resized:
            size = (self.width_px, self.height_px)
            picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
        return picture.reshape(self.shape)

    def truths(self, info: Info) -> dict[str, NDArray[Any]]:
        """The ground truth that the environment gave with a frame, at the picture's size."""
        return {name: self._resized(name, info[name]) for name in self.truth}

    def _resized(self, name: str, value: NDArray[Any]) -> NDArray[Any]:
        """Ground truth at the picture's size: the value of one pixel, in the units of the new pixels."""
        scale = np.array([self.width_px / CAMERA.width_px, self.height_px / CAMERA.height_px])
        if not self.is_resized:
            return value
        if name == "foe":
            return np.asarray((value + 0.5) * scale - 0.5)
        rows, columns = (
            np.minimum((np.arange(count) + 0.5) / factor, whole - 1).astype(int)
            for count, factor, whole in zip((self.height_px, self.width_px), scale[::-1], value.shape[:2], strict=True)
        )
        chosen: NDArray[Any] = value[rows[:, None], columns]
        return (chosen * scale).astype(np.float32) if name == "flow" else chosen


def _checked_size(size: object) -> tuple[int, int]:
    """(width, height) px; None is the camera's."""
    if size is None:
        return CAMERA.width_px, CAMERA.height_px
    highest = f"{CAMERA.width_px}x{CAMERA.height_px}"
    expected = f"{option('size')}: expected width and height in pixels, {LEAST_PX}x{LEAST_PX} to {highest}"
    if not isinstance(size, list | tuple) or len(size) != 2 or not all(type(side) is int for side in size):
        raise InputError(f"{expected}, got {shown(size)}")
    width_px, height_px = size
    if not (LEAST_PX <= width_px <= CAMERA.width_px and LEAST_PX <= height_px <= CAMERA.height_px):
        raise InputError(f"{expected}, got {width_px}x{height_px}")
    return width_px, height_px


def task_of(record: Record) -> str:
    """What is to be done in an episode, in words."""
    return f"Drive to the goal. Road: {main_table.shown(record.scenario)}. Weather: {main_table.shown(record.weather)}."


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
    states: list[Floats] = field(default_factory=list)  # n + 1 of (7,), as the driver observed them
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
