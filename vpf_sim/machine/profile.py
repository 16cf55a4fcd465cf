"""Time of a step and its stages, in multiples of a yardstick on frames of the same drive."""

from contextlib import closing
from dataclasses import dataclass
from hashlib import sha256
from itertools import pairwise
from math import ceil
from typing import Any

import cv2
import numpy as np

from vpf_sim import drivers
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.system import limit_opencv
from vpf_sim.timing import WINDOW_STEPS, Stopwatch
from vpf_sim.types import Image

WARM_UP_STEPS = 30
WHOLE = ("step", "world", "driver")  # these are made of the other stages
PAIRS = 6  # of consecutive frames for the yardstick, after each WINDOW_STEPS


@dataclass(frozen=True, slots=True)
class Profile:
    """Times of a step, its stages and the yardstick, in ms and in yardsticks."""

    step_ms: float
    yardstick_ms: float
    step_ratio: float
    camera_ratio: float  # of rendering
    stages_ms: dict[str, float]  # a step's share, by stage
    once_ms: dict[str, float]  # by stage, over the steps in which it runs


def profile(scenario: str, weather: str, steps: int) -> Profile:
    """Times of a step of the driver `vpf`, its stages and the yardstick, in ms and in yardsticks.

    `steps` is rounded up to whole half seconds. A step is act and step: render, perceive, plan, control, physics, as in
    an episode without a viewer. Its time and those of its stages are medians of the means over half seconds, since two
    steps of three use no frame. `once_ms` is a stage's median over the steps in which it runs, `camera_ratio` that of
    rendering in yardsticks.

    After each half second the yardstick is timed on consecutive frames. `hash`, which runs on a thread in an episode,
    is timed separately.
    """
    limit_opencv()
    watch, yardstick = Stopwatch(), Stopwatch()
    with closing(FourLane(scenario, weather)) as env, watch.running():
        drive = _Drive(env)
        for number in range(WINDOW_STEPS * ceil(steps / WINDOW_STEPS)):
            if drive.ended:
                drive.begin()
                watch.skip_step()
            with watch.stage("step"):
                image = drive.step()
            if image is not None:
                with watch.stage("hash"):
                    sha256(image.data).digest()
            watch.end_step()
            if number % WINDOW_STEPS == WINDOW_STEPS - 1:
                for before, now in pairwise(drive.frames(PAIRS + 1)):
                    with yardstick.stage("yardstick"):
                        _yardstick(before, now)
                    yardstick.end_step()
                watch.skip_step()
    return _report(watch, yardstick)


class _Drive:
    """Drives the driver `vpf` through consecutive episodes."""

    def __init__(self, env: FourLane) -> None:
        self._env, self._driver, self._seed = env, drivers.create("vpf"), 0
        self.ended = True

    def begin(self) -> None:
        """Start the next episode, with some warm-up steps."""
        self._observed, _ = self._env.reset(seed=self._seed)
        self._driver.reset(setup_for(self._driver, self._env, self._seed))
        self._seed, self.ended = self._seed + 1, False
        for _ in range(WARM_UP_STEPS):
            self.step()

    def step(self, with_frame: bool = False) -> Image | None:
        """Act and step; returns the frame if the driver uses it or `with_frame` is set."""
        command = drivers.command_of(self._driver, read(self._observed))
        action = np.array([command.throttle, command.steering])
        with_frame |= drivers.needs_next_frame(self._driver)
        self._observed, _, *ends, _ = self._env.step(action, with_frame=with_frame)
        self.ended = any(ends)
        return self._observed.get("image")

    def frames(self, number: int) -> list[Image]:
        """Consecutive grey frames; fewer where the episode ends."""
        found: list[Image] = []
        while len(found) < number and not self.ended:
            image = self.step(with_frame=True)
            assert image is not None
            found.append(grey(image))
        return found


def _yardstick(before: Image, now: Image) -> None:
    """Detect corners and track them into the next frame, the least work of any visual odometry."""
    corners = cv2.goodFeaturesToTrack(before, 300, 0.01, 8)
    if corners is not None:
        none: Any = None
        cv2.calcOpticalFlowPyrLK(before, now, corners, none, winSize=(25, 25), maxLevel=2, criteria=(3, 30, 0.03))


def _report(watch: Stopwatch, yardstick: Stopwatch) -> Profile:
    a_step, once = watch.typical_ms(), watch.medians_ms()
    names = [name for name in a_step if name not in WHOLE]
    step_ms, yardstick_ms = a_step["step"], yardstick.typical_ms(PAIRS)["yardstick"]
    return Profile(
        step_ms,
        yardstick_ms,
        step_ratio=step_ms / yardstick_ms,
        camera_ratio=once["render"] / yardstick_ms,
        stages_ms={name: a_step[name] for name in names},
        once_ms={name: once[name] for name in names},
    )
