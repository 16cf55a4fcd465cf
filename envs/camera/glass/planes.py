"""Water over the image, per pair of rows: its opacity and the pixel that it shows."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.glass.stamps import REACH, Stamp
from vpf_sim.types import Camera, Image

FILM_DIVISOR, SCENE_DIVISOR = 4, 8  # downscaling of the images that film and drops show
ROWS = 2  # image rows per row of the planes: doubling rows costs nothing, doubling columns does
Box = tuple[int, int, int, int]  # x0, y0, x1, y1 on the planes


class Planes:
    """Persistent planes of opacity and source pixels.

    `alpha` is (h, w) 0..255. `source` is (h, w), the index of the shown pixel in rows of `stride`: straight through in
    a blurred image of the size `film` (height, width), or for drops in the images of the size `scene` below it, one per
    shade.
    """

    def __init__(self, camera: Camera) -> None:
        self.shape = (-(-camera.height_px // ROWS), camera.width_px)
        self.film, self.scene = (
            (-(-camera.height_px // divisor), -(-camera.width_px // divisor))
            for divisor in (FILM_DIVISOR, SCENE_DIVISOR)
        )
        y, x = (np.arange(size) * small // size for size, small in zip(self.shape, self.film, strict=True))
        self.stride = self.film[1]
        self.source: NDArray[np.int64] = np.add.outer(self.stride * y, x).astype(np.int64)
        self._bits = self.source.view(np.float64)  # OpenCV 4 copies eight-byte numbers as float64
        self._through = self._bits.copy()
        self.alpha: Image = np.zeros(self.shape, np.uint8)
        self._anchors_x = _anchors(self.shape[1], self.scene[1], 0)
        self._anchors_y = [self.stride * row for row in _anchors(self.shape[0], self.scene[0], self.film[0])]

    @property
    def whole(self) -> Box:
        """The box of the whole planes."""
        return 0, 0, self.shape[1], self.shape[0]

    def put(self, stamp: Stamp, x: int, y: int, box: Box) -> None:
        """Draw a drop centred at (x, y), clipped to `box`; the more opaque of two drops wins."""
        height, width = stamp.alpha.shape
        left, top = x - width // 2, y - height // 2
        x0, y0, x1, y1 = max(left, box[0]), max(top, box[1]), min(left + width, box[2]), min(top + height, box[3])
        if x0 >= x1 or y0 >= y1:
            return
        alpha, source = stamp.alpha, stamp.source
        if (x1 - x0, y1 - y0) != (width, height):
            own = np.s_[y0 - top : y1 - top, x0 - left : x1 - left]
            alpha, source = alpha[own], source[own]
        here = self.alpha[y0:y1, x0:x1]
        anchor = self._anchors_x[min(max(x, 0), self.shape[1] - 1)] + self._anchors_y[min(max(y, 0), self.shape[0] - 1)]
        bits = np.add(source, anchor, dtype=np.int64).view(np.float64)
        cv2.copyTo(bits, cv2.compare(alpha, here, cv2.CMP_GT), self._bits[y0:y1, x0:x1])
        cv2.max(alpha, here, here)

    def clear(self, box: Box) -> None:
        """Clear the water in a box."""
        x0, y0, x1, y1 = box
        self.alpha[y0:y1, x0:x1] = 0
        self._bits[y0:y1, x0:x1] = self._through[y0:y1, x0:x1]

    def wipe(self, mask: Image) -> None:
        """Clear the water where a (h, w) mask is 255."""
        cv2.subtract(self.alpha, mask, self.alpha)
        cv2.copyTo(self._through, mask, self._bits)


def _anchors(size: int, small: int, first: int) -> list[int]:
    """The source index at a drop's centre for each position: between the scene's middle and straight through."""
    place = (1.0 - REACH) * np.linspace(-1.0, 1.0, size)
    anchors: list[int] = (first + (small - 1) / 2 * (1.0 + place)).astype(int).tolist()
    return anchors
