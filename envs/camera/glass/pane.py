"""Geometry of the windscreen in front of the camera.

The glass is an inclined plane, nearer at the top of the image. In camera axes (right, down, depth) its points are
(u, s sin r, z0 + s cos r): u m right of the optical axis, s m down along the glass, rake r. A ray with y / z = t meets
it at the depth z = z0 / (1 - t cot r).
"""

from dataclasses import dataclass
from math import radians, sin, tan

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Camera, Floats

DISTANCE_M = 0.1  # z0, along the optical axis
RAKE_RAD = radians(55.0)  # against the optical axis, as in a van; flatter glass would not fill the image
NEAREST_SHARE, FARTHEST_SHARE = 0.5, 3.0  # depth limits, in z0, also for rays that miss the glass
PUPIL_MM = 1.5  # diameter of the entrance pupil: 3 mm at f/2


@dataclass(frozen=True, slots=True)
class Pane:
    """The glass by image row (H entries each)."""

    camera: Camera
    depth_m: Floats
    across: Floats  # px per mm of glass along the row
    along: Floats  # px per mm of glass down the image
    above_m2: Floats  # (H + 1,) area of glass above each row's upper edge
    blur_px: Floats  # diameter of the blur disc of a point on the glass: f A / z

    @classmethod
    def of(cls, camera: Camera) -> "Pane":
        """The windscreen in front of a camera."""
        t = (np.arange(camera.height_px) - camera.cy_px) / camera.fy_px
        depth = DISTANCE_M * np.clip(1.0 / np.maximum(1.0 - t / tan(RAKE_RAD), 0.1), NEAREST_SHARE, FARTHEST_SHARE)
        across = 1e-3 * camera.fx_px / depth
        along = 1e-3 * camera.fy_px * DISTANCE_M * sin(RAKE_RAD) / depth**2
        area_m2 = 1e-6 * camera.width_px / (across * along)
        above_m2 = np.concatenate([[0.0], np.cumsum(area_m2)])
        return cls(camera, depth, across, along, above_m2, PUPIL_MM * across)

    def row(self, y_px: Floats) -> NDArray[np.intp]:
        """The image row at y, clipped to the image."""
        return np.minimum(np.maximum(y_px + 0.5, 0.0), len(self.depth_m) - 0.5).astype(np.intp)

    def on_glass(self, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
        """(u, s) m, points of the glass on the rays of pixels."""
        depth = np.interp(y_px, np.arange(len(self.depth_m)), self.depth_m)
        u = (x_px - self.camera.cx_px) / self.camera.fx_px * depth
        s = (y_px - self.camera.cy_px) / self.camera.fy_px * depth / sin(RAKE_RAD)
        return u, s

    def pixels(self, u_m: Floats, s_m: Floats) -> tuple[Floats, Floats]:
        """(x, y) px of points on the glass; they may lie outside the image."""
        depth = np.maximum(DISTANCE_M + s_m * sin(RAKE_RAD) / tan(RAKE_RAD), 0.1 * DISTANCE_M)
        x = self.camera.cx_px + self.camera.fx_px * u_m / depth
        y = self.camera.cy_px + self.camera.fy_px * s_m * sin(RAKE_RAD) / depth
        return x, y

    def spread(self, uniform: Floats) -> Floats:
        """Image heights, px, of points uniform on the glass, for uniform numbers in 0..1."""
        heights: Floats = np.interp(uniform * self.above_m2[-1], self.above_m2, np.arange(len(self.above_m2)) - 0.5)
        return heights
