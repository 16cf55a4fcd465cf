"""Frame statistics that matter to a tracker: corners, gradients, contrast, and track survival.

Used to compare rendered with recorded frames. Frames are scaled to one width, so that cameras are comparable.
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from typing import Any

import cv2
import numpy as np

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.types import Bools, Floats, Image

WIDTH_PX = 640
CORNERS, QUALITY, MIN_DISTANCE_PX = 400, 0.01, 7.0  # of Shi and Tomasi
WINDOW_PX, MAX_LEVEL, RETURN_PX = 25, 2, 1.0  # of Lucas-Kanade: three levels, forward-backward check
CONTRAST_PX = 31
FRAMES_ON = 6  # the longer survival horizon
SOBEL_GAIN = 8.0  # of the 3 x 3 operator for a gradient of one grey level per px


@dataclass(frozen=True, slots=True)
class FrameStatistics:
    """Means over the sampled frames."""

    corners_top: float  # corners in the upper third; at most CORNERS in a frame
    corners_middle: float
    corners_bottom: float
    gradient_p50: float  # grey levels per px, percentiles over the pixels of a frame
    gradient_p90: float
    gradient_p99: float
    contrast: float  # grey levels: median of the local standard deviation in CONTRAST_PX x CONTRAST_PX
    survive_1: float  # share of the corners tracked for one frame
    survive_6: float  # and for FRAMES_ON

    @classmethod
    def mean(cls, parts: Sequence["FrameStatistics"]) -> "FrameStatistics":
        """The mean of each statistic."""
        return cls(*np.mean([astuple(part) for part in parts], axis=0).tolist())

    def ratio(self, other: "FrameStatistics") -> dict[str, float]:
        """Each statistic divided by that of `other`; inf for a divisor of 0."""
        pairs = {field.name: (getattr(self, field.name), getattr(other, field.name)) for field in fields(self)}
        return {name: mine / theirs if theirs else np.inf for name, (mine, theirs) in pairs.items()}


def scaled_grey(image_rgb: Image) -> Image:
    """(h, WIDTH_PX) grey image of an (H, W, 3) RGB image, area-averaged."""
    height = round(image_rgb.shape[0] * WIDTH_PX / image_rgb.shape[1])
    scaled = cv2.resize(grey(image_rgb), (WIDTH_PX, height), interpolation=cv2.INTER_AREA)
    return scaled.astype(np.uint8, copy=False)


def measure(greys: Sequence[Image], every: int = 1) -> FrameStatistics:
    """The statistics of consecutive (h, w) grey frames, sampled at every `every`-th."""
    starts = range(0, len(greys) - FRAMES_ON, every)
    if not starts:
        raise ValueError(f"greys: expected more than {FRAMES_ON} frames, got {len(greys)}")
    rows = [
        [*corner_counts(greys[k]), *gradient_percentiles(greys[k]), contrast(greys[k]), *survival(greys[k:])]
        for k in starts
    ]
    return FrameStatistics(*np.mean(rows, axis=0).tolist())


def corners(image: Image, mask: Bools | None = None) -> Floats:
    """(N, 2) px, the corners of a grey frame inside an (H, W) mask."""
    allowed = None if mask is None else mask.astype(np.uint8)
    found = cv2.goodFeaturesToTrack(image, CORNERS, QUALITY, MIN_DISTANCE_PX, mask=allowed)
    return np.empty((0, 2)) if found is None else found[:, 0].astype(np.float64)


def corner_counts(image: Image) -> list[int]:
    """Number of corners in the upper, middle and lower third of a grey frame."""
    third = np.minimum(3 * corners(image)[:, 1] / image.shape[0], 2).astype(np.intp)
    return [int(count) for count in np.bincount(third, minlength=3)]


def gradient_percentiles(image: Image) -> list[float]:
    """50th, 90th and 99th percentile of |grad I|, grey levels per px, by Sobel's operator."""
    across, down = (cv2.Sobel(image, cv2.CV_32F, *order) / SOBEL_GAIN for order in ((1, 0), (0, 1)))
    return [float(value) for value in np.percentile(np.hypot(across, down), [50.0, 90.0, 99.0])]


def contrast(image: Image) -> float:
    """Median over the frame of the standard deviation in a square window, grey levels."""
    values = image.astype(np.float32)
    mean, square = (cv2.blur(part, (CONTRAST_PX, CONTRAST_PX)) for part in (values, values * values))
    return float(np.median(np.sqrt(np.maximum(square - mean * mean, 0.0))))


def survival(greys: Sequence[Image]) -> tuple[float, float]:
    """Shares of the first frame's corners that are tracked for one frame, and for FRAMES_ON."""
    _, alive = follow(greys[: FRAMES_ON + 1], corners(greys[0]))
    shares = alive.mean(axis=1) if alive.shape[1] else np.zeros(len(alive))
    return float(shares[0]), float(shares[-1])


def follow(greys: Sequence[Image], points_px: Floats) -> tuple[Floats, Bools]:
    """Tracks N points (N, 2) through K grey frames: positions in the last (N, 2), and survival (K - 1, N).

    A point is lost where tracking back misses its start by RETURN_PX.
    """
    points = points_px.astype(np.float32)
    alive = np.ones((len(greys) - 1, len(points)), np.bool_)
    if not len(points):
        return points_px, alive
    for k in range(1, len(greys)):
        moved, found = _lucas_kanade(greys[k - 1], greys[k], points)
        back, returned = _lucas_kanade(greys[k], greys[k - 1], moved)
        good = found & returned & (np.hypot(*(back - points).T) < RETURN_PX)
        alive[k - 1] = good if k == 1 else good & alive[k - 2]
        points = moved
    return points.astype(np.float64), alive


def _lucas_kanade(before: Image, after: Image, points: Any) -> tuple[Any, Bools]:
    none: Any = None
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before, after, points, none, winSize=(WINDOW_PX, WINDOW_PX), maxLevel=MAX_LEVEL, criteria=(3, 30, 0.03)
    )
    return moved, status.ravel() == 1
