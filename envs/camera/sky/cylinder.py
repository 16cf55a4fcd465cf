"""A cylindrical panorama at infinity, for a camera that yaws."""

import cv2
import numpy as np

from vpf_sim.types import Floats, Image


class Cylinder:
    """Column i is the azimuth 2 pi i / columns; rows are linear in the tangent of the elevation, from `tall` down to 0.

    Whole columns of a yaw shift the panorama; the rest selects one of several precomputed maps, so the image turns in
    fractions of a column.
    """

    def __init__(self, panorama: Image, tall: float, turn_rad: Floats, slope: Floats, fractions: int) -> None:
        self._fractions = fractions
        rows, self._columns = panorama.shape[:2]
        self._per_rad = self._columns / (2.0 * np.pi)
        self._base = int(np.ceil(np.abs(turn_rad).max() * self._per_rad)) + 1
        self._span = 2 * self._base + 2
        self._panorama = np.ascontiguousarray(np.concatenate([panorama, panorama[:, : self._span]], axis=1))
        column = (turn_rad * self._per_rad + self._base).astype(np.float32)
        row = np.clip((rows - 1) * (1.0 - slope / tall), 0, rows - 1).astype(np.float32)
        shifts = np.arange(fractions, dtype=np.float32) / fractions
        self._maps = [cv2.convertMaps(column + shift, row, cv2.CV_16SC2) for shift in shifts]

    def draw(self, yaw_rad: float, picture: Image) -> None:
        """Draw the panorama at a yaw into an image of the rays' shape."""
        steps = round(yaw_rad * self._per_rad * self._fractions)
        whole, fraction = divmod(steps, self._fractions)
        first = (whole - self._base) % self._columns
        part = self._panorama[:, first : first + self._span]
        across, down = self._maps[fraction]
        cv2.remap(part, across, down, cv2.INTER_LINEAR, picture)
