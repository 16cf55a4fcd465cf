"""Bodies in the way, as the driver sees them, and the time to contact with the one that the lidar has."""

from math import inf, nan

import numpy as np

from vpf_sim.geometry import project
from vpf_sim.replay.looming import GrowthConfig, GrowthTracker
from vpf_sim.types import Camera, Floats, Image, Perception

REACH_M = 25.0  # of a body that counts, from the pose
HALF_CORRIDOR_M = 1.5  # about the way along the lane: half a car and the clearance that the driver keeps
LASTING_S = 1.0  # a part with obstacles shows one in half of the frames about it
HALF_BODY_M, LOW_M, HIGH_M = 0.8, 0.3, 1.3  # of the body ahead: where its image is looked at


def is_in_the_way(seen: Perception) -> bool:
    """Whether a body is believed to stand in the corridor along the lane, at most REACH_M ahead."""
    bodies, road = seen.obstacles, seen.road
    way = bodies.forward_m * np.sin(road.heading_rad) + 0.5 * road.curvature_per_m * bodies.forward_m**2
    beside = np.maximum(bodies.left_m - way, way - bodies.right_m)
    return bool(np.any((bodies.forward_m > 0.0) & (bodies.forward_m < REACH_M) & (beside < HALF_CORRIDOR_M)))


def lasting(seen: Floats, rate_hz: float) -> Floats:
    """(N,) 1 where a body was seen in half of the frames of the LASTING_S about it, else 0; nan where nothing looks."""
    if not np.isfinite(seen).any():
        return np.full(len(seen), nan)
    half = round(0.5 * LASTING_S * rate_hz)
    known = np.isfinite(seen)
    share = _sums(np.where(known, seen, 0.0), half) / np.maximum(_sums(known.astype(float), half), 1.0)
    return (share >= 0.5).astype(float)


def _sums(values: Floats, half: int) -> Floats:
    """(N,) sums over the `half` values before and after each, of a drive that may be shorter."""
    return np.convolve(values, np.ones(2 * half + 1))[half : half + len(values)]


class LeadBody:
    """The body straight ahead, of which the lidar has the gap: that says where to look, the picture how it grows."""

    def __init__(self, camera: Camera, rate_hz: float) -> None:
        self._camera = camera
        self._growth = GrowthTracker(GrowthConfig(), rate_hz)

    def ttc_s(self, image: Image, gap_m: float) -> float:
        """s, at the grey (H, W) frame; inf where the body's image does not grow, nan where too little is seen of it."""
        if not np.isfinite(gap_m) or gap_m <= 0.0:
            return self._growth.update(image, None).ttc_s
        forward = self._camera.forward_m + gap_m
        corners = np.array([(forward, -HALF_BODY_M, LOW_M), (forward, HALF_BODY_M, HIGH_M)])
        (left, bottom), (right, top) = project(self._camera, corners)
        return self._growth.update(image, (left, top, right, bottom)).ttc_s


def closing_mps(gap_m: Floats, times_s: Floats, window_s: float = 1.0) -> Floats:
    """(N,) m/s at which a gap closes, by a straight line through the half second before and after; nan without one."""
    result = np.full(len(gap_m), nan)
    known = np.isfinite(gap_m)
    for k in np.flatnonzero(known):
        near = known & (np.abs(times_s - times_s[k]) <= 0.5 * window_s + 1e-9)
        if np.count_nonzero(near) >= 4:
            result[k] = -np.polyfit(times_s[near] - times_s[k], gap_m[near], 1)[0]
    return result


def true_ttc_s(gap_m: Floats, closing: Floats) -> Floats:
    """(N,) s; inf where the gap does not close, nan where it is unknown."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isfinite(closing), np.where(closing > 0.0, gap_m / closing, inf), nan)
