"""Obstacles in the driver's corridor, and the time to contact with the lead vehicle by the expansion of its image."""

from math import inf, nan
from typing import Any

import cv2
import numpy as np

from vpf_sim.geometry import project
from vpf_sim.perception.quantiles import quantile
from vpf_sim.types import Bools, Camera, Floats, Image, Perception

REACH_M = 25.0  # of the corridor, from the pose
HALF_CORRIDOR_M = 1.5  # half a car and the clearance that the driver keeps
PERSISTENCE_S = 1.0  # window in which half of the frames must have a detection
HALF_WIDTH_M, LOW_M, HIGH_M = 0.8, 0.3, 1.3  # of the lead vehicle, for its box in the image
LEAST_POINTS = 6
MOST_PAIRS = 400  # of points, as hypotheses
LEAST_AGE_SHARE = 0.5  # least share of the baseline that a point was tracked over
CORNERS, QUALITY, APART_PX = 100, 0.003, 4.0  # on an object: dark paint has weak corners
WINDOW_PX, LEVELS = 21, 3
BASELINE_S = 0.5  # the measured rate is half as old
NOISE_PX = 0.12  # standard deviation of a point's position in each frame step
SIGNIFICANCE_SD = 3.0  # standard deviations of a significant expansion
CAP_S = 20.0  # longest finite time to contact


def has_obstacle_in_corridor(perception: Perception) -> bool:
    """Whether an obstacle is in the corridor along the lane, at most REACH_M ahead."""
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
        self._looming = LoomingTracker(rate_hz)

    def ttc_s(self, image: Image, gap_m: float) -> float:
        """s, at the grey (H, W) frame; inf without looming, nan with too few points."""
        if not np.isfinite(gap_m) or gap_m <= 0.0:
            return self._looming.update(image, None)
        forward = self._camera.forward_m + gap_m
        corners = np.array([(forward, -HALF_WIDTH_M, LOW_M), (forward, HALF_WIDTH_M, HIGH_M)])
        (left, bottom), (right, top) = project(self._camera, corners)
        return self._looming.update(image, (left, top, right, bottom))


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


NONE: Any = None  # for arguments of OpenCV that its stubs want to be arrays

Box = tuple[float, float, float, float]  # left, top, right, bottom px


class LoomingTracker:
    """Tracks an object whose image position is roughly known and measures its looming.

    Image points move as v = a + g (p - c), with the expansion rate g = 1 / TTC. The object may move, and no focus of
    expansion is needed. Each point gives v over the baseline, at the middle of its path. The expansion rate that most
    points agree with is refined by least squares over these. Other points are reflections or background.
    """

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._frames = max(1, round(BASELINE_S * rate_hz))
        self._previous: Image | None = None
        self._trail = np.empty((self._frames + 1, 0, 2), np.float32)  # newest first
        self._age = np.empty(0, np.int64)  # frames

    def update(self, image: Image, box: Box | None) -> float:
        """s, time to contact with the object that fills most of a box of the grey (H, W) frame; None: not visible.

        It is inf without significant expansion, nan with too few points.
        """
        if self._previous is not None and len(self._age):
            self._follow(self._previous, image)
        self._previous = image
        if box is None:
            return nan
        left, top, right, bottom = box
        x, y = self._trail[0].T
        self._keep((x > left) & (x < right) & (y > top) & (y < bottom))
        ttc_s = self._ttc_s()
        self._add(image, box)
        return ttc_s

    def _follow(self, before: Image, now: Image) -> None:
        points = np.ascontiguousarray(self._trail[0])
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            before, now, points, NONE, winSize=(WINDOW_PX, WINDOW_PX), maxLevel=LEVELS
        )
        self._trail = np.concatenate([np.asarray(moved, np.float32)[None], self._trail[:-1]])
        self._age += 1
        self._keep(status.ravel() == 1)

    def _keep(self, chosen: Bools) -> None:
        self._trail, self._age = self._trail[:, chosen], self._age[chosen]

    def _add(self, image: Image, box: Box) -> None:
        height, width = image.shape
        left, right = (int(np.clip(edge, 0, width)) for edge in (box[0], box[2]))
        top, bottom = (int(np.clip(edge, 0, height)) for edge in (box[1], box[3]))
        missing = CORNERS - len(self._age)
        if missing <= 0 or right - left < WINDOW_PX or bottom - top < WINDOW_PX:
            return
        mask = np.full((bottom - top, right - left), 255, np.uint8)
        for x, y in self._trail[0]:
            cv2.circle(mask, (int(x) - left, int(y) - top), int(APART_PX), 0, -1)
        found = cv2.goodFeaturesToTrack(image[top:bottom, left:right], missing, QUALITY, APART_PX, mask=mask)
        if found is None:
            return
        corners = found.reshape(-1, 2) + np.array([left, top], np.float32)
        more = np.broadcast_to(corners, (len(self._trail), len(corners), 2)).astype(np.float32)
        self._trail = np.concatenate([self._trail, more], axis=1)
        self._age = np.concatenate([self._age, np.zeros(len(corners), np.int64)])

    def _ttc_s(self) -> float:
        age = np.minimum(self._age, self._frames)
        rows = np.flatnonzero(age >= max(1.0, LEAST_AGE_SHARE * self._frames))
        if len(rows) < LEAST_POINTS:
            return nan
        now, before = self._trail[0, rows].astype(np.float64), self._trail[age[rows], rows].astype(np.float64)
        span_s = age[rows] / self._rate_hz
        middle, speed = 0.5 * (now + before), (now - before) / span_s[:, None]
        tolerance = NOISE_PX * np.sqrt(age[rows]) / span_s
        agree = _largest_consensus(middle, speed, tolerance)
        if np.count_nonzero(agree) < LEAST_POINTS:
            return nan
        rate, sigma = _expansion_rate(middle[agree], speed[agree], tolerance[agree])
        if not rate > SIGNIFICANCE_SD * sigma:
            return inf
        # The rate holds at the middle of the path; the object has come nearer since.
        since_s = 0.5 * float(np.average(span_s[agree], weights=tolerance[agree] ** -2))
        ttc = max(0.0, 1.0 / rate - since_s)
        return ttc if ttc < CAP_S else inf


def _largest_consensus(middle_px: Floats, speed: Floats, tolerance: Floats) -> Bools:
    """(N,) points that agree with the expansion rate and shift of the best pair."""
    first, second = np.triu_indices(len(middle_px), 1)
    apart = middle_px[second] - middle_px[first]
    distance = np.sum(apart**2, axis=1)
    wide = np.flatnonzero(distance >= quantile(distance, 0.5))
    wide = wide[:: 1 + len(wide) // MOST_PAIRS]
    first, second, apart, distance = first[wide], second[wide], apart[wide], distance[wide]
    rate = np.sum((speed[second] - speed[first]) * apart, axis=1) / np.maximum(distance, 1e-9)
    shift = speed[first] - rate[:, None] * middle_px[first]
    left = speed[None] - shift[:, None] - rate[:, None, None] * middle_px[None]
    agree = np.hypot(left[..., 0], left[..., 1]) < 3.0 * tolerance
    best: Bools = agree[int(np.argmax(agree.sum(axis=1)))]
    return best


def _expansion_rate(middle_px: Floats, speed: Floats, tolerance: Floats) -> tuple[float, float]:
    """1/s, expansion rate by weighted least squares and its standard deviation."""
    weight = tolerance**-2
    away = middle_px - np.average(middle_px, axis=0, weights=weight)
    spread = float(weight @ np.sum(away**2, axis=1)) + 1e-12
    rate = float(weight @ np.sum(away * speed, axis=1)) / spread
    left = speed - np.average(speed, axis=0, weights=weight) - rate * away
    noise = float(weight @ np.sum(left**2, axis=1)) / (2 * len(speed))  # in squared tolerances
    return rate, float(np.sqrt(max(noise, 0.1) / spread))
