"""Where the time of a step goes, in multiples of a yardstick on the same frames, in the same run and thread."""

from collections.abc import Iterator
from contextlib import closing
from hashlib import sha256
from itertools import count
from typing import Any

import cv2
import numpy as np

from vpf_sim import drivers
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.evaluation.episode.stages import STAGES
from vpf_sim.evaluation.episode.stopwatch import Stopwatch
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.types import Image

WARM_UP_STEPS = 30


def profile(scenario: str, weather: str, steps: int) -> dict[str, Any]:
    """What a step of the driver `vpf`, its stages and the yardstick take, in ms, and in yardsticks, over `steps` steps.

    Medians, of a stage over the steps in which it runs; and under `mean` what each takes a step on average, as the
    median of the means over half seconds: two steps of three look at no frame.

    A step is act and step: render, perceive, plan, control, physics. `hash`, done by a helper thread in an episode, and
    the yardstick are timed apart from it.
    """
    limit_opencv()
    watch = Stopwatch()
    grey_before: Image | None = None
    with watch.watching(STAGES):
        for frame in _frames(scenario, weather, steps + 1, watch):  # the first has none before it
            with watch.stage("hash"):
                sha256(frame.data).digest()
            grey = np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)
            if grey_before is None:
                watch.skip_step()
            else:
                with watch.stage("yardstick"):
                    _yardstick(grey_before, grey)
                watch.end_step()
            grey_before = grey
    return _report(watch.medians_ms()) | {"mean": _report(watch.typical_ms())}


def _frames(scenario: str, weather: str, steps: int, watch: Stopwatch) -> Iterator[Image]:
    """The frame of each step, after the step was timed; episodes follow each other until there are enough."""
    left = steps
    driver = drivers.create("vpf")
    with closing(FourLane(scenario, weather)) as env:
        for seed in count():
            observed, _ = env.reset(seed=seed)
            driver.reset(setup_for(driver, env, seed))
            ended, step = False, 0
            while not ended:
                with watch.stage("step"):
                    command = drivers.command_of(driver, read(observed))
                    observed, _, *ends, _ = env.step(np.array([command.throttle, command.steering]))
                ended, step = any(ends), step + 1
                if step <= WARM_UP_STEPS:
                    watch.skip_step()
                    continue
                yield observed["image"]
                left -= 1
                if left == 0:
                    return


def _yardstick(before: Image, now: Image) -> None:
    """Corners of a frame, and where they went in the next: about what any visual odometry spends on a frame."""
    corners = cv2.goodFeaturesToTrack(before, 300, 0.01, 8)
    if corners is not None:
        none: Any = None
        cv2.calcOpticalFlowPyrLK(before, now, corners, none, winSize=(25, 25), maxLevel=2, criteria=(3, 30, 0.03))


def _report(times_ms: dict[str, float]) -> dict[str, Any]:
    step_ms, yardstick_ms = times_ms["step"], times_ms["yardstick"]
    return {
        "step_ms": step_ms,
        "yardstick_ms": yardstick_ms,
        "step_ratio": step_ms / yardstick_ms,
        "camera_ratio": times_ms["render"] / yardstick_ms,
        "stages_ms": {name: times_ms[name] for name in (*STAGES, "hash") if name in times_ms},
    }
