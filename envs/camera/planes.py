"""The picture's water, at half size: how much of each pixel it covers and what it shows there."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.stamps import REACH, Stamp
from vpf_sim.types import Camera, Image

NONE: Any = None  # for arguments of OpenCV that its stubs want to be arrays
SCENE_DIVISOR = 4  # the small picture of the scene is this much smaller than the frame
Box = tuple[int, int, int, int]  # x0, y0, x1, y1 on the planes


class Planes:
    """Persistent; only what is stamped, moved or wiped changes.

    `alpha` (h, w) 0..255 and `source` (h, w, 2), where in the pictures of `stamps` each pixel looks. Where there is no
    drop, a pixel looks straight through, into the first of the pictures.
    """

    def __init__(self, camera: Camera) -> None:
        self.shape = ((camera.height_px + 1) // 2, (camera.width_px + 1) // 2)
        self.scene = (max(camera.height_px // SCENE_DIVISOR, 1), max(camera.width_px // SCENE_DIVISOR, 1))
        y, x = (
            (np.arange(size) * small / size).astype(np.int16)
            for size, small in zip(self.shape, self.scene, strict=True)
        )
        self._through = np.stack(np.meshgrid(x, y), axis=-1)
        self.alpha: Image = np.zeros(self.shape, np.uint8)
        self.source = self._through.copy()

    @property
    def whole(self) -> Box:
        """All of it."""
        return 0, 0, self.shape[1], self.shape[0]

    def put(self, stamp: Stamp, x: int, y: int, box: Box) -> None:
        """A drop with its middle at (x, y), as far as it lies in `box`; the thicker of two drops is seen."""
        height, width = stamp.alpha.shape
        left, top = x - width // 2, y - height // 2
        x0, y0, x1, y1 = max(left, box[0]), max(top, box[1]), min(left + width, box[2]), min(top + height, box[3])
        if x0 >= x1 or y0 >= y1:
            return
        own = np.s_[y0 - top : y1 - top, x0 - left : x1 - left]
        here = self.alpha[y0:y1, x0:x1]
        alpha = stamp.alpha[own]
        source = stamp.source[own] + self._anchor(x, y)
        cv2.copyTo(source, cv2.compare(alpha, here, cv2.CMP_GT), self.source[y0:y1, x0:x1])
        cv2.max(alpha, here, here)

    def clear(self, box: Box) -> None:
        """Leave no water in a box."""
        x0, y0, x1, y1 = box
        self.alpha[y0:y1, x0:x1] = 0
        self.source[y0:y1, x0:x1] = self._through[y0:y1, x0:x1]

    def wipe(self, mask: NDArray[np.uint8]) -> None:
        """Leave no water where a (h, w) mask is 255."""
        cv2.subtract(self.alpha, mask, self.alpha)
        cv2.copyTo(self._through, mask, self.source)

    def _anchor(self, x: int, y: int) -> NDArray[np.int16]:
        """(2,) what the middle of a drop at (x, y) shows: part of the way from the middle of the scene to what is
        behind the drop."""
        middle = [(size - 1) / 2 for size in self.scene[::-1]]
        place = [
            half * (1.0 + (1.0 - REACH) * min(max(2.0 * at / size - 1.0, -1.0), 1.0))
            for half, at, size in zip(middle, (x, y), self.shape[::-1], strict=True)
        ]
        return np.array(place).astype(np.int16)
