"""Where an image shows what is fixed to the camera: a watermark, a bonnet, mirrors, drops on the glass, a date.

The scene changes from frame to frame while the car moves; brightness gradients that stay the same do not belong to it
(Dekel et al., CVPR 2017, find watermarks by them). Lines along the road stay the same as well while a car keeps its
lane, so only corners count.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.replay.image_files import Frame
from vpf_sim.types import Bools, Floats, Image

LONGEST_S, APART_S, MOST_FRAMES = 60.0, 0.15, 30  # of the sampled part, between samples, and samples
FEWEST_FRAMES = 6  # that differ, below which nothing is known
CELL_PX, CHANGED_LEVELS, CHANGED_SHARE = 16, 3.0, 0.1  # a frame differs if such a share of its cells has changed
LEAST_LEVELS, COHERENT = 3.0, 0.7  # grey levels a pixel; size of the mean gradient over the root mean square
WINDOW_PX, CORNER_LEVELS, CORNER_RATIO = 11, 1.0, 0.1  # of the structure tensor of the fixed gradients
MARGIN_PX, FILL_PX = 2, 31
MOST_SHARE = 0.6  # of the road's part of the image, above which it may be a stationary scene
MIDDLE = 0.19, 0.81, 0.17, 0.75  # left, right, top, bottom: where a lead vehicle or the far road may stay in place, too
LEAST_VISIBLE = 0.001  # of the image


@dataclass(frozen=True, slots=True)
class FixedStructure:
    """(H, W) pixels that show corners fixed to the camera."""

    mask: Bools

    @property
    def leaves_scene(self) -> bool:
        """Whether enough of the lower half of the image shows the scene."""
        return bool(self.mask[len(self.mask) // 2 :].mean() < MOST_SHARE)

    @property
    def off_centre(self) -> Bools:
        """(H, W) the mask without the middle of the image."""
        (height, width), (left, right, top, bottom) = self.mask.shape, MIDDLE
        result = self.mask.copy()
        result[round(top * height) : round(bottom * height), round(left * width) : round(right * width)] = False
        return result

    @property
    def is_visible(self) -> bool:
        """Whether a person would see it in the image."""
        return bool(self.off_centre.mean() > LEAST_VISIBLE)

    def rectified(self, rectify_image: Callable[[Image], Image]) -> "FixedStructure":
        """The same in images that this function rectifies."""
        return FixedStructure(rectify_image(self.hidden) > 127)

    def scene(self, points_px: Floats) -> Bools:
        """(N,) which points (N, 2) are not on what is fixed."""
        height, width = self.mask.shape
        columns, rows = np.clip(np.rint(points_px).astype(np.intp), 0, [width - 1, height - 1]).T
        on_fixed: Bools = self.mask[rows, columns]
        return ~on_fixed

    @property
    def hidden(self) -> Image:
        """(H, W) 255 where no corner of the scene can be found."""
        return self.mask.astype(np.uint8) * 255

    def filled(self, image: Image) -> Image:
        """The grey (H, W) image, with fixed pixels replaced by the mean of the scene around them."""
        if not self.mask.any():
            return image
        scene = (~self.mask).astype(np.float32)
        size = (FILL_PX, FILL_PX)
        weight = cv2.blur(scene, size)
        around = np.where(weight > 0.0, cv2.blur(image * scene, size) / np.maximum(weight, 1e-6), image.mean())
        return np.where(self.mask, np.clip(around, 0.0, 255.0), image).astype(np.uint8)


def find(frames: Iterator[Frame], times_s: Floats) -> FixedStructure | None:
    """What is fixed to the camera in the first minute; None if too few frames differ to distinguish the two."""
    total: Floats = np.zeros(1, np.float32)
    square: Floats = np.zeros(1, np.float32)
    count = 0
    for image in _differing(frames, times_s):
        gradient: Floats = np.stack([cv2.Sobel(image, cv2.CV_32F, *axis, scale=0.125) for axis in ((1, 0), (0, 1))])
        total, square = total + gradient, square + np.sum(gradient**2, axis=0)
        count += 1
    if count < FEWEST_FRAMES:
        return None
    mean = total / count
    size = np.hypot(*mean)
    stays = (size > LEAST_LEVELS) & (size > COHERENT * np.sqrt(square / count))
    corners = _has_corner(mean * stays)
    kernel = np.ones((2 * MARGIN_PX + 1,) * 2, np.uint8)
    return FixedStructure(cv2.dilate((stays & corners).astype(np.uint8), kernel) > 0)


def _differing(frames: Iterator[Frame], times_s: Floats) -> Iterator[Image]:
    """Grey frames spread over the first minute, each with a scene unlike that of the one before."""
    end_s = float(times_s[0]) + min(LONGEST_S, float(times_s[-1] - times_s[0]))
    apart_s = max(APART_S, (end_s - float(times_s[0])) / MOST_FRAMES)
    due_s, before = float(times_s[0]), None
    for frame in frames:
        if times_s[frame.index] > end_s:
            return
        if frame.image is None or times_s[frame.index] < due_s:
            continue
        image = grey(frame.image)
        small = cv2.resize(image, (image.shape[1] // CELL_PX, image.shape[0] // CELL_PX), interpolation=cv2.INTER_AREA)
        if before is None or np.mean(cv2.absdiff(small, before) > CHANGED_LEVELS) > CHANGED_SHARE:
            before, due_s = small, float(times_s[frame.index]) + apart_s
            yield image


def _has_corner(gradient: Floats) -> Bools:
    """(H, W) whether a gradient (2, H, W) has two directions about each pixel."""
    x, y = gradient
    window = (WINDOW_PX, WINDOW_PX)
    xx, yy, xy = (cv2.blur(part, window) for part in (x * x, y * y, x * y))
    middle, spread = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    return np.asarray((middle - spread > CORNER_LEVELS**2) & (middle - spread > CORNER_RATIO * (middle + spread)))
