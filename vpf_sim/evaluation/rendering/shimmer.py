"""Whether a picture shimmers: what changes in it though nothing moves, and what its ground does as the car creeps.

A pattern that is not carried with the road, or is drawn too coarsely for its distance, moves otherwise than the
geometry says; trackers would follow it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig, Weather
from vpf_sim.evaluation.rendering import frame_statistics
from vpf_sim.evaluation.rendering.scripted import Path, ScriptedDrive
from vpf_sim.evaluation.truth.true_motion import OFF_PX, TrueMotion, Truth
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.types import Bools, Floats, Image

NEAREST_M, FARTHEST_M = 15.0, 60.0  # the ground that is looked at
STARTS_M = {"bend": 90.0, "straight": 200.0}  # of town04
LANE = 2


@dataclass(frozen=True, slots=True)
class Creep:
    """Tracks on the distant ground at one speed; shares of those off the true flow by more than OFF_PX."""

    road: str
    speed_mps: float
    tracks: int
    off_1: float  # over one frame
    off_6: float  # over 0.1 s
    p99_1_px: float  # 99th percentile of the error over one frame


def course(road: str, speed_mps: float, noise_sd: float = 0.0) -> ScriptedDrive:
    """The middle of a lane of town04 without bodies, in its bend or on its straight."""
    scenario = scenarios.load("town04-clean").draw(0)
    offset_m = scenario.road.lane_offset_m(LANE)
    path = Path(STARTS_M[road], speed_mps, lambda _: offset_m)
    return ScriptedDrive(scenario, path, Rig(noise_sd=noise_sd))


def changes_standing(weather: Weather, road: str, seed: int, count: int) -> int:
    """Pixels of `count` frames that differ from the first, with the car still and the sensor without noise."""
    shots = [shot.image for shot in course(road, 0.0).shots(weather, seed, count)]
    return sum(int(np.count_nonzero((image != shots[0]).any(axis=2))) for image in shots[1:])


def creep(weather: Weather, road: str, speed_mps: float, seed: int, count: int, every: int = 10) -> Creep:
    """Drive `count` frames; every `every`-th is compared with the truth."""
    drive = course(road, speed_mps)
    motion = TrueMotion(drive.rig.camera, frame_statistics.FRAMES_ON)
    greys: list[Image] = []
    single, chained = [np.empty(0)], [np.empty(0)]
    for shot in drive.shots(weather, seed, count):
        motion.note(shot)
        greys = [*greys[-frame_statistics.FRAMES_ON :], grey(shot.image)]
        if len(greys) > frame_statistics.FRAMES_ON and shot.index % every == 0:
            truth = shot.renderer.truth(("depth", "instance"))
            single.append(_errors(greys[-2:], motion, truth))
            chained.append(_errors(greys, motion, truth))
    one, six = np.concatenate(single), np.concatenate(chained)
    p99 = float(np.percentile(one, 99.0)) if len(one) else np.nan
    return Creep(road, speed_mps, len(one), _share(one), _share(six), p99)


def _errors(greys: list[Image], motion: TrueMotion, truth: Truth) -> Floats:
    """(N,) px by which corners of the last frame's distant ground, followed back to the first, miss the truth."""
    now_px = frame_statistics.corners(greys[-1], distant_ground(truth))
    start_px, alive = frame_statistics.follow(greys[::-1], now_px)
    start_px, now_px = start_px[alive[-1]], now_px[alive[-1]]
    return motion.errors_px(now_px, now_px - start_px, np.full(len(now_px), len(greys) - 1), truth)


def distant_ground(truth: Truth) -> Bools:
    """(H, W) ground NEAREST_M to FARTHEST_M away, a tracker's window off whatever stands up or is nearer or farther."""
    depth, instance = truth["depth"].astype(np.float64), truth["instance"]
    other = (instance != 0) | ~np.isfinite(depth)
    window = np.ones((frame_statistics.WINDOW_PX, frame_statistics.WINDOW_PX), np.uint8)
    clear = cv2.dilate(other.astype(np.uint8), window) == 0
    return np.asarray((depth > NEAREST_M) & (depth < FARTHEST_M) & clear, np.bool_)


def _share(errors_px: Floats) -> float:
    return float(np.mean(errors_px > OFF_PX)) if len(errors_px) else np.nan
