"""The windshield before the camera: where a pixel's ray meets the glass, and how large things on it appear.

The glass is a plane that leans back, so it is nearer at the top of the picture. In camera axes (right, down, depth)
its points are (u, s sin r, z0 + s cos r) for u m to the right of the optical axis and s m down along the glass, with
the rake r. A ray with y / z = t meets it at the depth z = z0 / (1 - t cot r).
"""

from dataclasses import dataclass
from math import radians, sin, tan

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Camera, Floats

DISTANCE_M = 0.1  # z0, along the optical axis
RAKE_RAD = radians(55.0)  # against the optical axis, as in a van; much flatter glass would not fill the picture
NEAREST_SHARE, FARTHEST_SHARE = 0.5, 3.0  # of z0; rays that miss the glass are taken to meet it this far
PUPIL_MM = 1.5  # diameter of the lens's entrance: 3 mm at f/2


@dataclass(frozen=True, slots=True)
class Pane:
    """The glass, row by row of the picture (H entries each)."""

    camera: Camera
    depth_m: Floats
    across: Floats  # px / mm of glass along the row
    along: Floats  # px / mm of glass down the picture
    above_m2: Floats  # (H + 1,) glass above each row's upper edge
    blur_px: Floats  # diameter of the disc into which a point on the glass spreads: f A / z

    @classmethod
    def of(cls, camera: Camera) -> "Pane":
        """The glass before a camera."""
        t = (np.arange(camera.height_px) - camera.cy_px) / camera.fy_px
        depth = DISTANCE_M * np.clip(1.0 / np.maximum(1.0 - t / tan(RAKE_RAD), 0.1), NEAREST_SHARE, FARTHEST_SHARE)
        across = 1e-3 * camera.fx_px / depth
        along = 1e-3 * camera.fy_px * DISTANCE_M * sin(RAKE_RAD) / depth**2
        area_m2 = 1e-6 * camera.width_px / (across * along)
        above_m2 = np.concatenate([[0.0], np.cumsum(area_m2)])
        return cls(camera, depth, across, along, above_m2, PUPIL_MM * across)

    def row(self, y_px: Floats) -> NDArray[np.intp]:
        """The row of the picture that holds a height, or the nearest one."""
        return np.minimum(np.maximum(y_px + 0.5, 0.0), len(self.depth_m) - 0.5).astype(np.intp)

    def on_glass(self, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
        """(u, s) m where the rays of pixels meet the glass."""
        depth = np.interp(y_px, np.arange(len(self.depth_m)), self.depth_m)
        u = (x_px - self.camera.cx_px) / self.camera.fx_px * depth
        s = (y_px - self.camera.cy_px) / self.camera.fy_px * depth / sin(RAKE_RAD)
        return u, s

    def pixels(self, u_m: Floats, s_m: Floats) -> tuple[Floats, Floats]:
        """(x, y) px of points on the glass, which may lie beyond the picture's edges."""
        depth = np.maximum(DISTANCE_M + s_m * sin(RAKE_RAD) / tan(RAKE_RAD), 0.1 * DISTANCE_M)
        x = self.camera.cx_px + self.camera.fx_px * u_m / depth
        y = self.camera.cy_px + self.camera.fy_px * s_m * sin(RAKE_RAD) / depth
        return x, y

    def spread(self, uniform: Floats) -> Floats:
        """Heights (px) of points spread evenly over the glass, from numbers spread evenly over 0..1."""
        heights: Floats = np.interp(uniform * self.above_m2[-1], self.above_m2, np.arange(len(self.above_m2)) - 0.5)
        return heights
