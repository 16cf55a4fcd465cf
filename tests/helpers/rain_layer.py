"""What rain adds to the picture of a standing camera, and whether it comes again."""

import cv2
import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig, Weather
from vpf_sim.gallery.poses import Path, ScriptedDrive
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.types import Floats

REDUCTION = 2  # the size of a pixel that is compared
MOST_LEVELS = 2.0  # of one pixel's change, so that a bright thing's mirror that trembles does not outweigh the rain


def standing(s_m: float) -> ScriptedDrive:
    """A camera that stands at s on a lane of town04 without obstacles, without sensor noise."""
    scenario = scenarios.drawn_road("town04-clean", 0)
    offset_m = scenario.road.lane_offset_m(2)
    return ScriptedDrive(scenario, Path(s_m, 0.0, lambda _: offset_m), Rig(noise_sd=0.0))


def layers(weather: Weather, seed: int, count: int) -> Floats:
    """(count, M) what changes from frame to frame: each frame less the mean of its second, without sensor noise.

    Grey levels, at most MOST_LEVELS to both sides.
    """
    greys = []
    for shot in standing(200.0).shots(weather, seed, count):
        height, width = shot.image.shape[:2]
        size = (width // REDUCTION, height // REDUCTION)
        greys.append(cv2.resize(grey(shot.image), size, interpolation=cv2.INTER_AREA).ravel())
    frames = np.array(greys, np.float64)
    for start in range(0, count, 60):
        frames[start : start + 60] -= frames[start : start + 60].mean(axis=0)
    return np.clip(frames, -MOST_LEVELS, MOST_LEVELS)


def likeness(first: Floats, second: Floats) -> Floats:
    """(K, L) correlation of each of K layers with each of L; 1: the same, 0: nothing in common."""
    units = [part / np.maximum(np.linalg.norm(part, axis=1, keepdims=True), 1e-9) for part in (first, second)]
    result: Floats = units[0] @ units[1].T
    return result


def greatest_likeness(frames: Floats, least_gap: int) -> float:
    """The largest correlation of two layers at least so many frames apart."""
    alike = likeness(frames, frames)
    first, second = np.indices(alike.shape)
    return float(alike[second - first >= least_gap].max())
