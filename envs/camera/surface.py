"""The painted ground in the picture, one channel of palette values.

Polygons are filled without anti-aliasing on canvases several times as fine as the picture and averaged down, which gives
every edge its exact coverage: 2 x 2 near the car, 4 x 8 far away, where one row of pixels spans many metres.
"""

from dataclasses import dataclass
from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.ground import ground_top
from vpf_sim.envs.camera.paint import GRASS, Batch
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Camera, Floats, Image

RANGE_M = 260.0
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

    def fill(self, polygons: list[Floats], value: int) -> None:
        """Fill polygons given in pixels of the picture."""
        scale = np.array([self.fine_x, self.fine_y], float)
        offset = np.array([0.5, 0.5 - self.first])
        fixed = [np.rint(((p + offset) * scale - 0.5) * 2**SHIFT).astype(np.int32) for p in polygons]
        cv2.fillPoly(self.pixels, fixed, value, cv2.LINE_8, SHIFT)


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
        relative = centres - view.centre[:2]
        ahead = relative @ np.array([np.cos(view.yaw_rad), np.sin(view.yaw_rad)])
        aside = relative @ np.array([-np.sin(view.yaw_rad), np.cos(view.yaw_rad)])
        reach = self._camera.width_px / self._camera.fx_px  # a generous half field of view
        seen = np.flatnonzero(
            (ahead > -radii) & (ahead < RANGE_M) & (np.abs(aside) < reach * np.abs(ahead) + 2.0 * radii)
        )
        if not len(seen):
            return
        points = _camera_axes(view, batch.polygons_m[seen])
        if batch.thin:
            _inset(points, self._camera.fx_px)
        inside = points[..., 2] > NEAR_M
        whole = inside.all(axis=1)
        pixels: list[Floats | None] = list(view.pixels(np.where(whole[:, None, None], points, 1.0)))
        part = np.flatnonzero(~whole)
        if len(part):
            keep = part[inside[part].any(axis=1)]
            for i in part:
                pixels[i] = None
            for i, polygon in zip(keep, clip_near(points[keep], inside[keep]), strict=True):
                pixels[i] = view.pixels(polygon)
        order = zip(batch.strips[seen], batch.values[seen], pixels, strict=True)
        for (_, value), group in groupby(order, key=lambda item: (item[0], item[1])):
            self._fill([polygon for _, _, polygon in group if polygon is not None], int(value))

    def _fill(self, polygons: list[Floats], value: int) -> None:
        border = self._near.first
        upper = [p for p in polygons if p[:, 1].min() < border]
        lower = [p for p in polygons if p[:, 1].max() > border - 1]
        if upper:
            self._far.fill(upper, value)
        if lower:
            self._near.fill(lower, value)


def _camera_axes(view: View, polygons: Floats) -> Floats:
    """(n, V, 3) of (n, V, 2) points of the road."""
    flat: Floats = (polygons - view.centre[:2]) @ view.axes[:, :2].T
    return flat - view.centre[2] * view.axes[:, 2]


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
    return cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
