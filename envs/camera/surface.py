"""The painted ground in the picture, one channel of palette values.

Polygons are filled without anti-aliasing on canvases several times as fine as the picture and averaged down, which
gives every edge its exact coverage: 2 x 2 near the car, 4 x 8 far away, where one row of pixels spans many metres.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from vpf_sim.envs.camera.grain import ground_top
from vpf_sim.envs.camera.paint import GRASS, Batch
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near

from vpf_sim.types import Camera, Floats, Image

FAR_ROWS = 32  # rows under the horizon that are drawn on the finer canvas
SHIFT = 4  # fractional bits of OpenCV's polygon coordinates


@dataclass(frozen=True, slots=True)
class Canvas:
    """A stretch of rows, drawn several times as fine."""

    pixels: NDArray[np.uint8]
    first: int  # row of the picture
    rows: int
    fine_x: int
    fine_y: int

    def fixed(self, pixels: Floats) -> NDArray[np.int32]:
        """Pixels of the picture in OpenCV's fixed-point coordinates of this canvas."""
        scale = np.array([self.fine_x, self.fine_y], float) * 2**SHIFT
        offset = np.array([0.5 * self.fine_x - 0.5, (0.5 - self.first) * self.fine_y - 0.5]) * 2**SHIFT
        return np.asarray(np.rint(pixels * scale + offset), np.int32)


class Surface:
    """Draws the batches of a road."""

    def __init__(self, camera: Camera, batches: list[Batch]) -> None:
        self._camera = camera
        self._batches = batches
        self._bounds = [(batch.centres_m, batch.radii_m) for batch in batches]
        top = ground_top(camera)
        far = min(FAR_ROWS, camera.height_px - top)
        near = camera.height_px - top - far
        width = camera.width_px
        self._far = Canvas(np.empty((8 * far, 4 * width), np.uint8), top, far, 4, 8)
        self._near = Canvas(np.empty((2 * near, 2 * width), np.uint8), top + far, near, 2, 2)
        self._picture = np.empty((far + near, width), np.uint8)

    def draw(self, view: View) -> Image:
        """(rows, W) palette values from the top of the ground down; valid until the next call."""
        self._far.pixels[:] = GRASS
        self._near.pixels[:] = GRASS
        for batch, (centres, radii) in zip(self._batches, self._bounds, strict=True):
            self._draw_batch(view, batch, centres, radii)
        far = _halved(_halved(self._far.pixels))
        cv2.addWeighted(far[0::2], 0.5, far[1::2], 0.5, 0.0, self._picture[: self._far.rows])
        self._picture[self._far.rows :] = _halved(self._near.pixels)
        return self._picture

    def _draw_batch(self, view: View, batch: Batch, centres: Floats, radii: Floats) -> None:
        seen = self._in_view(view, centres, radii, batch.range_m)
        if not len(seen):
            return
        points = _camera_axes(view, batch.polygons_m[seen])
        if batch.thin:
            _inset(points, self._camera.fx_px)
        inside = points[..., 2] > NEAR_M
        whole, part = inside.all(axis=1), inside.any(axis=1)
        part &= ~whole
        self._fill(view.pixels(points[whole]), batch.strips[seen][whole], batch.values[seen][whole])
        if part.any():
            clipped = view.pixels(clip_near(points[part], inside[part]))
            self._fill(clipped, batch.strips[seen][part], batch.values[seen][part])

    def _in_view(self, view: View, centres: Floats, radii: Floats, range_m: float) -> NDArray[np.int64]:
        relative = centres - view.centre[:2]
        c, s = np.cos(view.yaw_rad), np.sin(view.yaw_rad)
        ahead = relative[:, 0] * c + relative[:, 1] * s
        aside = relative[:, 1] * c - relative[:, 0] * s
        slope = 0.55 * self._camera.width_px / self._camera.fx_px
        return np.flatnonzero(
            (ahead > -radii) & (ahead < range_m) & (np.abs(aside) < slope * np.abs(ahead) + (1.0 + slope) * radii)
        )

    def _fill(self, pixels: Floats, strips: NDArray[np.int64], values: NDArray[np.int64]) -> None:
        """Fill (n, V, 2) polygons, those of one strip in one call."""
        if not len(pixels):
            return
        border = self._near.first
        for canvas, shown in (
            (self._far, pixels[..., 1].min(axis=1) < border),
            (self._near, pixels[..., 1].max(axis=1) > border - 1.0),
        ):
            fixed = list(canvas.fixed(pixels[shown]))
            owners = strips[shown]
            ends = [*(np.flatnonzero(np.diff(owners)) + 1).tolist(), len(fixed)] if fixed else []
            first = 0
            for last, value in zip(ends, values[shown][np.array(ends, np.int64) - 1].tolist(), strict=True):
                cv2.fillPoly(canvas.pixels, fixed[first:last], value, cv2.LINE_8, SHIFT)
                first = last


def _camera_axes(view: View, polygons: Floats) -> Floats:
    """(n, V, 3) of (n, V, 2) points of the road."""
    flat: Floats = (polygons - view.centre[:2]) @ view.axes[:, :2].T
    return np.asarray(flat - view.centre[2] * view.axes[:, 2])


def _inset(points: Floats, focal_px: float) -> None:
    """Narrow lines by what OpenCV's polygon filling adds, half a pixel of the canvas on each side."""
    half = points.shape[1] // 2
    left, right = points[:, :half], points[:, half:][:, ::-1]
    across = right[..., 0] - left[..., 0]
    depth = np.abs(left[..., 2])
    amount = np.where(depth < 14.0, 0.25, 0.125) * depth / focal_px
    step = np.sign(across) * np.minimum(amount, 0.45 * np.abs(across))
    left[..., 0] += step
    right[..., 0] -= step


def _halved(picture: Image) -> Image:
    height, width = picture.shape
    return np.asarray(cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8)
