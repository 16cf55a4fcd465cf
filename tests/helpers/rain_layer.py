"""What rain adds to the picture of a standing camera, and whether it comes again."""

import cv2
import numpy as np

from vpf_sim.envs.camera import Weather
from vpf_sim.evaluation.rendering.shimmer import course
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.types import Floats

REDUCTION = 2  # the size of a pixel that is compared
MOST_LEVELS = 2.0  # of one pixel's change, so that a bright thing's mirror that trembles does not outweigh the rain


def layers(weather: Weather, seed: int, count: int) -> Floats:
    """(count, M) what changes from frame to frame: each frame less the mean of its second, without sensor noise.

    Grey levels, at most MOST_LEVELS to both sides.
    """
    greys = []
    for shot in course("straight", 0.0).shots(weather, seed, count):
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
