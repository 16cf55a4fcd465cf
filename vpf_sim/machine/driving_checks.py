"""Checks for `vpf-sim doctor`: valid frames, sufficient speed, and reproducible episodes."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import pairwise
from time import perf_counter

import cv2
import numpy as np

from vpf_sim import drivers, scenarios
from vpf_sim.envs.ending import frame_fault
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation import pool
from vpf_sim.evaluation.episode.episode import roll_out
from vpf_sim.machine import equal_frames
from vpf_sim.machine.installation import BROKEN, Check
from vpf_sim.scenarios.parts import Limits
from vpf_sim.system import limit_opencv
from vpf_sim.types import Camera, Image

SCENARIO, DRIVER, SEED = "town04", "vpf", 7
EPISODE_S = 1.5
FRAMES = 12
FEWEST_CORNERS = 100  # of 300 requested; a driver cannot steer by fewer
SLOWEST_HZ = 5.0
UNSTEADY = "sweeps cannot be compared or resumed here; try another OpenCV or CPU, or report it"


@dataclass(frozen=True, slots=True)
class Run:
    """A short episode: its reproducible results, and its speed."""

    status: str
    states_sha256: str
    frames_sha256: str
    steps: int
    wall_s: float


def checks() -> dict[str, Callable[[], Check]]:
    """The checks by name, in order of dependence; they share frames and an episode."""
    limit_opencv()
    samples = _Samples()
    return {
        "frames": lambda: frames(samples.frames, samples.shape),
        "corners": lambda: corners(samples.frames[-1]),
        "speed": lambda: speed(samples.run),
        "same again": lambda: same("same again", samples.run, short_episode(SEED)),
        "same elsewhere": lambda: same("same elsewhere", samples.run, in_fresh_process(SEED)),
        "equal frames": equal_frames.check,
    }


def frames(taken: Sequence[Image], shape: tuple[int, ...]) -> Check:
    """Whether frames of a moving car have the camera's shape, more than one colour, and change."""
    faults = [frame_fault(taken[0], shape), *(frame_fault(now, shape, before) for before, now in pairwise(taken))]
    wrong = [f"frame {number} is {fault}" for number, fault in enumerate(faults) if fault]
    if wrong:
        return Check("frames", False, f"{wrong[0]} ({len(wrong)} of {len(taken)} frames are wrong)", BROKEN)
    found = f"{len(taken)} frames, not black, constant or stale; mean grey level {np.mean(taken[-1]):.0f}"
    return Check("frames", True, found)


def corners(frame: Image) -> Check:
    """Whether a frame has enough corners to track."""
    found = cv2.goodFeaturesToTrack(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), 300, 0.01, 8)
    count = 0 if found is None else len(found)
    if count < FEWEST_CORNERS:
        return Check("corners", False, f"{count}, expected at least {FEWEST_CORNERS}", BROKEN)
    return Check("corners", True, f"{count} to track")


def speed(run: Run) -> Check:
    """Whether the whole loop in hard rain is fast enough."""
    rate_hz = run.steps / run.wall_s
    found = f"{rate_hz:.0f} steps a second in hard rain; the camera takes 60"
    if rate_hz < SLOWEST_HZ:
        return Check("speed", False, found, "see what else runs; vpf-sim doctor --profile shows where the time goes")
    return Check("speed", True, found)


def same(name: str, first: Run, again: Run) -> Check:
    """Whether two runs of one episode have equal states and frames, bit by bit."""
    for run in (first, again):
        if run.status in ("error", "invalid_frame"):
            return Check(name, False, f"the short episode ended by {run.status}", BROKEN)
    keys = ("status", "states_sha256", "frames_sha256")
    differ = [key.removesuffix("_sha256") for key in keys if getattr(first, key) != getattr(again, key)]
    if differ:
        return Check(name, False, f"{' and '.join(differ)} of the short episode differ", UNSTEADY)
    return Check(
        name, True, f"{first.steps} steps, states {first.states_sha256[:12]}, frames {first.frames_sha256[:12]}"
    )


def short_episode(seed: int) -> Run:
    """Drive the beginning of an episode in hard rain, which uses the most random streams."""
    scenario = scenarios.load(SCENARIO).draw(seed).model_copy(update={"limits": Limits(time_s=EPISODE_S)})
    with closing(FourLane(scenario, "rain", truth=("foe",))) as env:
        started_s = perf_counter()
        outcome = roll_out(env, drivers.create(DRIVER), drivers.create("pid"), seed)
        wall_s = perf_counter() - started_s
    table = outcome.steps
    return Run(outcome.status, sha256(table.states()).hexdigest(), outcome.frames_sha256 or "", len(table), wall_s)


def in_fresh_process(seed: int) -> Run:
    """The short episode in a new process."""
    done = next(iter(pool.run(short_episode, [seed], 1)))
    if done.result is None:
        raise RuntimeError("the other process died")
    return done.result


class _Samples:
    """Frames and an episode that several checks share, created on first use."""

    camera = Camera()
    shape = (camera.height_px, camera.width_px, 3)

    @cached_property
    def frames(self) -> list[Image]:
        """Frames of a rolling car in clear weather."""
        with closing(FourLane(SCENARIO, "clear")) as env:
            observed, _ = env.reset(seed=SEED)
            return [observed["image"], *(env.step(np.zeros(2, np.float32))[0]["image"] for _ in range(FRAMES - 1))]

    @cached_property
    def run(self) -> Run:
        return short_episode(SEED)
