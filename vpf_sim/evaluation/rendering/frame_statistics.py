"""What a tracker finds in a sequence of frames: corners, gradients, contrast, and how long its tracks live.

The numbers by which rendered frames are compared with real ones. All frames are scaled to one width first, so that the
numbers of different cameras compare.
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
WINDOW_PX, MAX_LEVEL, RETURN_PX = 25, 2, 1.0  # of Lucas-Kanade: three levels, tracked there and back
CONTRAST_PX = 31
FRAMES_ON = 6  # the longer life that is looked at
SOBEL_GAIN = 8.0  # of the 3 x 3 operator on a slope of one grey level per px


@dataclass(frozen=True, slots=True)
class FrameStatistics:
    """Means over the frames that were looked at."""

    corners_top: float  # in the upper third of the frame, of CORNERS at most in the whole of it
    corners_middle: float
    corners_bottom: float
    gradient_p50: float  # grey levels per px, percentiles over the pixels of a frame
    gradient_p90: float
    gradient_p99: float
    contrast: float  # grey levels, median over the frame of the standard deviation in CONTRAST_PX x CONTRAST_PX
    survive_1: float  # share of the corners that are still followed after one frame
    survive_6: float  # and after FRAMES_ON

    @classmethod
    def mean(cls, parts: Sequence["FrameStatistics"]) -> "FrameStatistics":
        """Number by number."""
        return cls(*np.mean([astuple(part) for part in parts], axis=0).tolist())

    def ratio(self, other: "FrameStatistics") -> dict[str, float]:
        """Each number over that of `other`; inf over nothing."""
        pairs = {field.name: (getattr(self, field.name), getattr(other, field.name)) for field in fields(self)}
        return {name: mine / theirs if theirs else np.inf for name, (mine, theirs) in pairs.items()}


def scaled_grey(image_rgb: Image) -> Image:
    """(h, WIDTH_PX) grey of an (H, W, 3) RGB image, every pixel the mean of what it covers."""
    height = round(image_rgb.shape[0] * WIDTH_PX / image_rgb.shape[1])
    scaled = cv2.resize(grey(image_rgb), (WIDTH_PX, height), interpolation=cv2.INTER_AREA)
    return scaled.astype(np.uint8, copy=False)


def measure(greys: Sequence[Image], every: int = 1) -> FrameStatistics:
    """The statistics of (h, w) grey frames in their order, looked at in every `every`-th."""
    starts = range(0, len(greys) - FRAMES_ON, every)
    if not starts:
        raise ValueError(f"greys: expected more than {FRAMES_ON} frames, got {len(greys)}")
    rows = [
        [*corner_counts(greys[k]), *gradient_percentiles(greys[k]), contrast(greys[k]), *survival(greys[k:])]
        for k in starts
    ]
    return FrameStatistics(*np.mean(rows, axis=0).tolist())


def corners(image: Image, mask: Bools | None = None) -> Floats:
    """(N, 2) px, the corners of a grey frame, where an (H, W) mask allows."""
    allowed = None if mask is None else mask.astype(np.uint8)
    found = cv2.goodFeaturesToTrack(image, CORNERS, QUALITY, MIN_DISTANCE_PX, mask=allowed)
    return np.empty((0, 2)) if found is None else found[:, 0].astype(np.float64)


def corner_counts(image: Image) -> list[int]:
    """How many corners lie in the upper, the middle and the lower third of a grey frame."""
    third = np.minimum(3 * corners(image)[:, 1] / image.shape[0], 2).astype(np.intp)
    return [int(count) for count in np.bincount(third, minlength=3)]


def gradient_percentiles(image: Image) -> list[float]:
    """50th, 90th and 99th percentile of |grad I|, grey levels per px, by Sobel's operator."""
    across, down = (cv2.Sobel(image, cv2.CV_32F, *order) / SOBEL_GAIN for order in ((1, 0), (0, 1)))
    return [float(value) for value in np.percentile(np.hypot(across, down), [50.0, 90.0, 99.0])]


def contrast(image: Image) -> float:
    """Grey levels, the median over the frame of the standard deviation in a square window."""
    values = image.astype(np.float32)
    mean, square = (cv2.blur(part, (CONTRAST_PX, CONTRAST_PX)) for part in (values, values * values))
    return float(np.median(np.sqrt(np.maximum(square - mean * mean, 0.0))))


def survival(greys: Sequence[Image]) -> tuple[float, float]:
    """Shares of the first frame's corners that are followed for one frame, and for FRAMES_ON."""
    _, alive = follow(greys[: FRAMES_ON + 1], corners(greys[0]))
    shares = alive.mean(axis=1) if alive.shape[1] else np.zeros(len(alive))
    return float(shares[0]), float(shares[-1])


def follow(greys: Sequence[Image], points_px: Floats) -> tuple[Floats, Bools]:
    """Where N points (N, 2) of the first of K grey frames are in the last, (N, 2), and which of them are followed.

    (K - 1, N): so far, frame by frame. A point is lost where Lucas-Kanade back again misses its start by RETURN_PX.
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
