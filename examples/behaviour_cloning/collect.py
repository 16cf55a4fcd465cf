"""Training drives: teacher and learner take turns at the wheel, the teacher labels every decision."""

import gc
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from behaviour_cloning import scenes
from behaviour_cloning.teacher import Teacher
from vpf_sim.driver_interface import Command, Driver, Observation
from vpf_sim.drivers.learned.driver import OnnxDriver, shrink, state_vector
from vpf_sim.drivers.learned.manifest import Manifest
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.seeding import stream
from vpf_sim.system import limit_opencv, limited_environment
from vpf_sim.types import Image, Singles

TURN = (20, 120)  # decisions, before the wheel may pass to the other
PUSH_SHARE, PUSH, PUSH_LENGTH = 0.03, 0.15, (6, 14)  # disturbances: how often one begins, steering, decisions
STANDING_MPS, MOST_STANDING = 0.1, 30  # decisions at a standstill while the teacher would drive: more teach no more
LANE_M = 1.75  # off the lane's centre: in another lane, where on an empty road the learner shall stay


@dataclass(frozen=True, slots=True)
class Settings:
    """How a round's drives are driven."""

    teacher: str  # a driver by name
    manifest: Manifest  # of the learner
    decisions: int  # of the longest drive
    learner_share: float = 0.0  # of the turns at the wheel
    model: Path | None = None  # of the learner; None where it has not learned anything yet


Task = tuple[int, Settings]


@dataclass(frozen=True, slots=True)
class Drive:
    """T decisions of one drive."""

    pictures: Image  # (T, channels of a frame, H, W)
    states: Singles  # (T, values)
    labels: Singles  # (T, 2) throttle and steering of the teacher
    status: str

    def __len__(self) -> int:
        return len(self.labels)


def collect(seeds: range, settings: Settings, workers: int) -> Iterator[Drive]:
    """A drive for each seed, in processes that drive side by side."""
    with limited_environment():
        pool = get_context("spawn").Pool(workers, limit_opencv)
    with pool:
        yield from pool.imap(drive, [(seed, settings) for seed in seeds])


def drive(task: Task) -> Drive:
    """The drive of a task; all that is random follows from its seed."""
    gc.collect()  # the objects of the last environment reference each other
    seed, settings = task
    scene, rng = scenes.draw(seed), stream(seed, "training drive")
    learner = [] if settings.model is None else [OnnxDriver(settings.model)]
    asked: list[Driver] = [Teacher(settings.teacher), *learner]
    with closing(FourLane(scene.scenario, scene.weather)) as env:
        observed, info = env.reset(seed=seed)
        for driver in asked:
            driver.reset(setup_for(driver, env, seed))
        wheel, log = _Wheel(settings.learner_share, rng), _Log(settings.manifest)
        repeat, standing = round(env.rate_hz / settings.manifest.rate_hz), 0
        while len(log) < settings.decisions and standing < MOST_STANDING and _stays(info, scene):
            observation = read(observed)
            commands = [driver.act(observation) for driver in asked]
            label, command = commands[0], wheel.next(commands[0], commands[-1])
            log.add(observation, label, command)
            is_stuck = observation.speed_mps < STANDING_MPS and label.throttle > 0.0
            standing = standing + 1 if is_stuck else 0
            for tick in range(1, repeat + 1):
                action = np.array([command.throttle, command.steering])
                observed, _, terminated, truncated, info = env.step(action, with_frame=tick == repeat)
                if terminated or truncated:
                    return log.drive(info["status"])
                if tick < repeat:  # they keep their own time
                    for driver in asked:
                        driver.act(read(observed))
    return log.drive(info["status"])


def _stays(info: dict[str, Any], scene: scenes.Scene) -> bool:
    """Whether the drive still teaches its lane."""
    return scene.has_obstacles or abs(info["lane_offset_m"]) < LANE_M


class _Wheel:
    """Who steers, and the disturbances of the steering."""

    def __init__(self, learner_share: float, rng: np.random.Generator) -> None:
        self._share, self._rng = learner_share, rng
        self._turn, self._is_learners = 0, False
        self._push, self._pushed = 0.0, 0

    def next(self, teacher: Command, learner: Command) -> Command:
        """The command that is carried out."""
        if self._turn == 0:
            self._turn = int(self._rng.integers(*TURN))
            self._is_learners = self._rng.random() < self._share
        self._turn -= 1
        if self._pushed == 0 and self._rng.random() < PUSH_SHARE:
            self._pushed = int(self._rng.integers(*PUSH_LENGTH))
            self._push = float(self._rng.uniform(-PUSH, PUSH))
        self._pushed = max(0, self._pushed - 1)
        chosen = learner if self._is_learners else teacher
        return Command(chosen.throttle, chosen.steering + (self._push if self._pushed else 0.0))


class _Log:
    """The decisions of a drive."""

    def __init__(self, manifest: Manifest) -> None:
        assert manifest.image is not None
        assert manifest.state is not None
        self._image, self._state = manifest.image, manifest.state
        self._rows: list[tuple[Image, Singles, list[float]]] = []
        self._action = np.zeros(2)

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, observation: Observation, label: Command, command: Command) -> None:
        """A decision: what the policy gets, what the teacher would do, and what is done."""
        state = state_vector(observation, self._action, self._state)[0]
        self._rows.append((shrink(observation.image, self._image), state, [label.throttle, label.steering]))
        self._action = np.clip([command.throttle, command.steering], -1.0, 1.0)

    def drive(self, status: str) -> Drive:
        """The drive with all its decisions."""
        pictures, states, labels = ([*column] for column in zip(*self._rows, strict=True))
        return Drive(np.array(pictures), np.array(states), np.array(labels, np.float32), status)
