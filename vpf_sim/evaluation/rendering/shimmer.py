"""Shimmer of rendered frames: changed pixels of a static scene, and track errors on distant ground.

A texture that does not move with the road, or is rendered too coarsely for its distance, violates the geometry, and
trackers would follow it.
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

NEAREST_M, FARTHEST_M = 15.0, 60.0  # range of the scored ground
STARTS_M = {"bend": 90.0, "straight": 200.0}  # of town04
LANE = 2


@dataclass(frozen=True, slots=True)
class Creep:
    """Tracks on distant ground at one speed; shares with an error above OFF_PX."""

    road: str
    speed_mps: float
    tracks: int
    off_1: float  # over one frame
    off_6: float  # over 0.1 s
    p99_1_px: float  # 99th percentile of the error over one frame


def course(road: str, speed_mps: float, noise_sd: float = 0.0) -> ScriptedDrive:
    """A drive along a lane of town04 without obstacles, in its bend or on its straight."""
    scenario = scenarios.drawn_road("town04-clean", 0)
    offset_m = scenario.road.lane_offset_m(LANE)
    path = Path(STARTS_M[road], speed_mps, lambda _: offset_m)
    return ScriptedDrive(scenario, path, Rig(noise_sd=noise_sd))


def changes_standing(weather: Weather, road: str, seed: int, count: int) -> int:
    """Number of pixels in `count` frames that differ from the first, with a stationary car and no sensor noise."""
    shots = [shot.image for shot in course(road, 0.0).shots(weather, seed, count)]
    return sum(int(np.count_nonzero((image != shots[0]).any(axis=2))) for image in shots[1:])


def creep(weather: Weather, road: str, speed_mps: float, seed: int, count: int, every: int = 10) -> Creep:
    """Drive `count` frames; every `every`-th is scored."""
    drive = course(road, speed_mps)
    motion = TrueMotion(drive.rig.camera, frame_statistics.FRAMES_ON)
    greys: list[Image] = []
    single, chained = [np.empty(0)], [np.empty(0)]
    for shot in drive.shots(weather, seed, count):
        motion.add(shot)
        greys = [*greys[-frame_statistics.FRAMES_ON :], grey(shot.image)]
        if len(greys) > frame_statistics.FRAMES_ON and shot.index % every == 0:
            truth = shot.renderer.truth(("depth", "instance"))
            single.append(_errors(greys[-2:], motion, truth))
            chained.append(_errors(greys, motion, truth))
    one, six = np.concatenate(single), np.concatenate(chained)
    p99 = float(np.percentile(one, 99.0)) if len(one) else np.nan
    return Creep(road, speed_mps, len(one), _share(one), _share(six), p99)


def _errors(greys: list[Image], motion: TrueMotion, truth: Truth) -> Floats:
    """(N,) px, errors of corners on the last frame's distant ground, tracked back to the first frame."""
    now_px = frame_statistics.corners(greys[-1], distant_ground(truth))
    start_px, alive = frame_statistics.follow(greys[::-1], now_px)
    start_px, now_px = start_px[alive[-1]], now_px[alive[-1]]
    return motion.errors_px(now_px, now_px - start_px, np.full(len(now_px), len(greys) - 1), truth)


def distant_ground(truth: Truth) -> Bools:
    """(H, W) ground between NEAREST_M and FARTHEST_M, at least a tracking window from objects and sky."""
    depth, instance = truth["depth"].astype(np.float64), truth["instance"]
    other = (instance != 0) | ~np.isfinite(depth)
    window = np.ones((frame_statistics.WINDOW_PX, frame_statistics.WINDOW_PX), np.uint8)
    clear = cv2.dilate(other.astype(np.uint8), window) == 0
    return np.asarray((depth > NEAREST_M) & (depth < FARTHEST_M) & clear, np.bool_)


def _share(errors_px: Floats) -> float:
    return float(np.mean(errors_px > OFF_PX)) if len(errors_px) else np.nan
