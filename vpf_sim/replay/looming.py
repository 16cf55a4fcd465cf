"""The time to contact with one body by the growth of its image, from corners of its own."""

from dataclasses import dataclass
from math import inf, nan
from typing import Any

import cv2
import numpy as np

from vpf_sim.perception.quantiles import quantile
from vpf_sim.types import Bools, Floats, Image

LEAST_POINTS = 6  # of a body
MOST_PAIRS = 400  # of them, that are tried
LEAST_AGE_SHARE = 0.5  # of the baseline, over which a point was followed
CORNERS, QUALITY, APART_PX = 100, 0.003, 4.0  # looked for on a body: dark paint has weak ones
WINDOW_PX, LEVELS = 21, 3
NONE: Any = None  # for arguments of OpenCV that its stubs want to be arrays

Box = tuple[float, float, float, float]  # left, top, right, bottom px


@dataclass(frozen=True, slots=True)
class GrowthConfig:
    baseline_s: float = 0.5  # over which growth is measured; it is as old as half of it
    noise_px: float = 0.12  # standard deviation of a point's place, a step between frames
    sure: float = 3.0  # standard deviations, above which growth is no noise
    cap_s: float = 20.0  # longest time that is told apart from never

    def __post_init__(self) -> None:
        if min(self.baseline_s, self.noise_px, self.sure, self.cap_s) <= 0.0:
            raise ValueError("baseline_s, noise_px, sure, cap_s: expected > 0")


@dataclass(frozen=True, slots=True)
class Contact:
    """With one body. `ttc_s` is inf where its image does not grow beyond doubt, nan where too few points tell."""

    ttc_s: float
    growth_per_s: float
    sigma_per_s: float  # standard deviation of the growth
    points: int  # that agree


UNKNOWN = Contact(nan, nan, nan, 0)


class GrowthTracker:
    """Follows a body whose place in the picture is known roughly, and tells how fast it comes nearer.

    The image of a body moves as v = a + g (p - c), by the growth g = 1 / TTC; it need not stand, and no focus of
    expansion is needed. Each point tells of v by its way over the baseline, at the middle of that way. The growth with
    which most points agree is refined by least squares over these; the others are what shines in its panes, or is seen
    past it.
    """

    def __init__(self, config: GrowthConfig, rate_hz: float) -> None:
        self._config = config
        self._rate_hz = rate_hz
        self._frames = max(1, round(config.baseline_s * rate_hz))
        self._previous: Image | None = None
        self._trail = np.empty((self._frames + 1, 0, 2), np.float32)  # newest first
        self._age = np.empty(0, np.int64)  # frames

    def update(self, image: Image, box: Box | None) -> Contact:
        """The contact with the body that fills most of a box of the grey (H, W) frame; None: it is not seen."""
        if self._previous is not None and len(self._age):
            self._follow(self._previous, image)
        self._previous = image
        if box is None:
            return UNKNOWN
        left, top, right, bottom = box
        x, y = self._trail[0].T
        self._keep((x > left) & (x < right) & (y > top) & (y < bottom))
        contact = self._contact()
        self._add(image, box)
        return contact

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
        wanted = CORNERS - len(self._age)
        if wanted <= 0 or right - left < WINDOW_PX or bottom - top < WINDOW_PX:
            return
        mask = np.full((bottom - top, right - left), 255, np.uint8)
        for x, y in self._trail[0]:
            cv2.circle(mask, (int(x) - left, int(y) - top), int(APART_PX), 0, -1)
        found = cv2.goodFeaturesToTrack(image[top:bottom, left:right], wanted, QUALITY, APART_PX, mask=mask)
        if found is None:
            return
        corners = found.reshape(-1, 2) + np.array([left, top], np.float32)
        more = np.broadcast_to(corners, (len(self._trail), len(corners), 2)).astype(np.float32)
        self._trail = np.concatenate([self._trail, more], axis=1)
        self._age = np.concatenate([self._age, np.zeros(len(corners), np.int64)])

    def _contact(self) -> Contact:
        age = np.minimum(self._age, self._frames)
        rows = np.flatnonzero(age >= max(1.0, LEAST_AGE_SHARE * self._frames))
        if len(rows) < LEAST_POINTS:
            return UNKNOWN
        now, before = self._trail[0, rows].astype(np.float64), self._trail[age[rows], rows].astype(np.float64)
        span_s = age[rows] / self._rate_hz
        middle, speed = 0.5 * (now + before), (now - before) / span_s[:, None]
        tolerance = self._config.noise_px * np.sqrt(age[rows]) / span_s
        agree = _most_alike(middle, speed, tolerance)
        count = int(np.count_nonzero(agree))
        if count < LEAST_POINTS:
            return UNKNOWN
        growth, sigma = _growth(middle[agree], speed[agree], tolerance[agree])
        # Growth is that at the middle of the way, since when the body came nearer.
        since_s = 0.5 * float(np.average(span_s[agree], weights=tolerance[agree] ** -2))
        return Contact(self._ttc_s(growth, sigma, since_s), growth, sigma, count)

    def _ttc_s(self, growth: float, sigma: float, since_s: float) -> float:
        if not growth > self._config.sure * sigma:
            return inf
        ttc = max(0.0, 1.0 / growth - since_s)
        return ttc if ttc < self._config.cap_s else inf


def _most_alike(middle_px: Floats, speed: Floats, tolerance: Floats) -> Bools:
    """(N,) the points that agree with the growth and shift of the pair with which most of them do."""
    first, second = np.triu_indices(len(middle_px), 1)
    apart = middle_px[second] - middle_px[first]
    distance = np.sum(apart**2, axis=1)
    wide = np.flatnonzero(distance >= quantile(distance, 0.5))
    wide = wide[:: 1 + len(wide) // MOST_PAIRS]
    first, second, apart, distance = first[wide], second[wide], apart[wide], distance[wide]
    growth = np.sum((speed[second] - speed[first]) * apart, axis=1) / np.maximum(distance, 1e-9)
    shift = speed[first] - growth[:, None] * middle_px[first]
    left = speed[None] - shift[:, None] - growth[:, None, None] * middle_px[None]
    agree = np.hypot(left[..., 0], left[..., 1]) < 3.0 * tolerance
    best: Bools = agree[int(np.argmax(agree.sum(axis=1)))]
    return best


def _growth(middle_px: Floats, speed: Floats, tolerance: Floats) -> tuple[float, float]:
    """1/s, the growth by weighted least squares and its standard deviation."""
    weight = tolerance**-2
    away = middle_px - np.average(middle_px, axis=0, weights=weight)
    spread = float(weight @ np.sum(away**2, axis=1)) + 1e-12
    growth = float(weight @ np.sum(away * speed, axis=1)) / spread
    left = speed - np.average(speed, axis=0, weights=weight) - growth * away
    noise = float(weight @ np.sum(left**2, axis=1)) / (2 * len(speed))  # in tolerances, squared
    return growth, float(np.sqrt(max(noise, 0.1) / spread))
