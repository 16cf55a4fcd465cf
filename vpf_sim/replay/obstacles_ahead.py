"""Obstacles in the driver's corridor, and the time to contact with the lead vehicle."""

from math import inf, nan

import numpy as np

from vpf_sim.geometry import project
from vpf_sim.replay.looming import LoomingConfig, LoomingTracker
from vpf_sim.types import Camera, Floats, Image, Perception

REACH_M = 25.0  # of the corridor, from the pose
HALF_CORRIDOR_M = 1.5  # half a car and the clearance that the driver keeps
PERSISTENCE_S = 1.0  # window in which half of the frames must have a detection
HALF_WIDTH_M, LOW_M, HIGH_M = 0.8, 0.3, 1.3  # of the lead vehicle, for its box in the image


def has_obstacle_in_corridor(perception: Perception) -> bool:
    """Whether an obstacle stands in the corridor along the lane, at most REACH_M ahead."""
    obstacles, road = perception.obstacles, perception.road
    lane_m = obstacles.forward_m * np.sin(road.heading_rad) + 0.5 * road.curvature_per_m * obstacles.forward_m**2
    beside = np.maximum(obstacles.left_m - lane_m, lane_m - obstacles.right_m)
    return bool(np.any((obstacles.forward_m > 0.0) & (obstacles.forward_m < REACH_M) & (beside < HALF_CORRIDOR_M)))


def persistent(detected: Floats, rate_hz: float) -> Floats:
    """(N,) 1 where half of the frames within PERSISTENCE_S have a detection, else 0; nan without perception."""
    if not np.isfinite(detected).any():
        return np.full(len(detected), nan)
    half = round(0.5 * PERSISTENCE_S * rate_hz)
    known = np.isfinite(detected)
    share = _sums(np.where(known, detected, 0.0), half) / np.maximum(_sums(known.astype(float), half), 1.0)
    return (share >= 0.5).astype(float)


def _sums(values: Floats, half: int) -> Floats:
    """(N,) sums over the `half` values before and after each; the drive may be shorter."""
    return np.convolve(values, np.ones(2 * half + 1))[half : half + len(values)]


class LeadVehicle:
    """Looming of the lead vehicle; the recorded gap says where in the image it is."""

    def __init__(self, camera: Camera, rate_hz: float) -> None:
        self._camera = camera
        self._expansion_rate = LoomingTracker(LoomingConfig(), rate_hz)

    def ttc_s(self, image: Image, gap_m: float) -> float:
        """s, at the grey (H, W) frame; inf without looming, nan with too few points."""
        if not np.isfinite(gap_m) or gap_m <= 0.0:
            return self._expansion_rate.update(image, None).ttc_s
        forward = self._camera.forward_m + gap_m
        corners = np.array([(forward, -HALF_WIDTH_M, LOW_M), (forward, HALF_WIDTH_M, HIGH_M)])
        (left, bottom), (right, top) = project(self._camera, corners)
        return self._expansion_rate.update(image, (left, top, right, bottom)).ttc_s


def closing_mps(gap_m: Floats, times_s: Floats, window_s: float = 1.0) -> Floats:
    """(N,) m/s, closing speed by a line fit over the half second before and after; nan without one."""
    result = np.full(len(gap_m), nan)
    known = np.isfinite(gap_m)
    for k in np.flatnonzero(known):
        near = known & (np.abs(times_s - times_s[k]) <= 0.5 * window_s + 1e-9)
        if np.count_nonzero(near) >= 4:
            result[k] = -np.polyfit(times_s[near] - times_s[k], gap_m[near], 1)[0]
    return result


def true_ttc_s(gap_m: Floats, closing: Floats) -> Floats:
    """(N,) s; inf where the gap does not close, nan where unknown."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isfinite(closing), np.where(closing > 0.0, gap_m / closing, inf), nan)
