"""Which of the many things of a road may be in the picture."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats

STEP_M = 12.0  # what the camera travels before all things are looked at again

Indices = NDArray[np.int64]


class Nearby:
    """Discs on the ground, each with the distance ahead up to which its middle is drawn."""

    def __init__(self, camera: Camera, centres_m: Floats, radii_m: Floats, ranges_m: Floats) -> None:
        self._slope = 0.55 * camera.width_px / camera.fx_px  # of the sides of what the camera sees, and a margin
        self._all = (centres_m, radii_m, ranges_m)
        self._reach_m = (ranges_m + radii_m) * np.hypot(1.0, self._slope) + 2.0 * radii_m + STEP_M
        self._middle = np.full(2, np.inf)
        self._index = np.empty(0, np.int64)
        self._close = self._all

    def in_view(self, view: View) -> tuple[Indices, Floats]:
        """Which discs may be in the picture, and how far ahead their middles are, m."""
        eye = view.centre[:2]
        if not np.hypot(*(eye - self._middle)) < STEP_M:
            centres_m, radii_m, ranges_m = self._all
            self._middle = eye
            self._index = np.flatnonzero(np.hypot(*(centres_m - eye).T) < self._reach_m)
            self._close = (centres_m[self._index], radii_m[self._index], ranges_m[self._index])
        centres, radii, ranges = self._close
        c, s = np.cos(view.yaw_rad), np.sin(view.yaw_rad)
        ahead, aside = np.array([[c, s], [-s, c]]) @ (centres - eye).T
        seen = (ahead > -radii) & (ahead < ranges)
        seen &= np.abs(aside) < self._slope * np.abs(ahead) + (1.0 + self._slope) * radii
        index = np.flatnonzero(seen)
        return self._index[index], ahead[index]
