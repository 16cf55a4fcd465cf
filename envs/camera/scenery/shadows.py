"""Shadows of objects on the road: the sun's, and the dark contact shadow."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import Box, footprint, in_front
from vpf_sim.envs.camera.view import NEAR_M, View
from vpf_sim.geometry import is_same
from vpf_sim.types import Floats, Image

RANGE_M, FADED_IN_M = 75.0, 45.0
FULLNESS = 0.85  # height of the shadow-casting box over the object's
NO_SUN = 0.97  # shadows with more remaining brightness are left out
FINE, SHIFT = 2, 4


class Shadow:
    """The shadow of one object; its outlines are cached by pose."""

    def __init__(self, size: tuple[float, float, float], light: Light) -> None:
        self._size = size
        self._fall_m: Floats | None = None  # (2,) offset of the top's shadow
        self._brightness = [light.contact]  # remaining brightness in each outline
        if light.shadow < NO_SUN:
            self._fall_m = -light.sun[:2] / max(light.sun[2], 0.05) * FULLNESS * size[2]
            self._brightness = [light.shadow, light.contact]
        self._pose: Floats = np.full(3, np.nan)
        self._outlines: Floats = np.empty((0, 4, 3))

    def paint(self, frame: Image, view: View, pose: Floats) -> None:
        """Darken the ground under an object at a pose (x, y, heading)."""
        distance = float(np.hypot(*(pose[:2] - view.centre[:2]).tolist()))
        if distance > RANGE_M:
            return
        if not is_same(pose, self._pose):
            self._pose, self._outlines = pose, self._cast(pose)
        full = min(1.0, (RANGE_M - distance) / (RANGE_M - FADED_IN_M))
        values = [255.0 - full * 255.0 * (1.0 - share) for share in self._brightness]
        points = view.camera_axes(self._outlines)
        if points[..., 2].min() <= NEAR_M:
            shown = np.flatnonzero((points[..., 2] > NEAR_M).any(axis=1))
            points, values = in_front(points[shown]), [values[i] for i in shown]
        if values:
            _darken(frame, view.pixels(points), values)

    def _cast(self, pose: Floats) -> Floats:
        """(n, V, 3) outlines on the road, the lightest first; padded by their last corner."""
        length, width, _ = self._size
        outlines = [footprint(pose, 0.97 * length, 0.9 * width)]
        if self._fall_m is not None:
            foot = footprint(pose, length, width)
            both = np.concatenate([foot, foot + self._fall_m]).astype(np.float32)
            outlines.insert(0, cv2.convexHull(both)[:, 0].astype(float))
        result = np.zeros((len(outlines), max(map(len, outlines)), 3))
        for corners, outline in zip(result, outlines, strict=True):
            corners[:, :2] = outline[-1]
            corners[: len(outline), :2] = outline
        return result


def _darken(frame: Image, polygons: Floats, values: list[float]) -> None:
    """Multiply the image within polygons (n, V, 2) by values of 255; later polygons override."""
    box = _box(polygons.reshape(-1, 2), frame.shape)
    if box is None:
        return
    x0, y0, x1, y1 = box
    mask = np.full((FINE * (y1 - y0), FINE * (x1 - x0)), 255, np.uint8)
    corner = (x0 - 0.5 + 0.5 / FINE, y0 - 0.5 + 0.5 / FINE)
    fixed = np.rint((polygons - corner) * (FINE << SHIFT)).astype(np.int32)
    for polygon, value in zip(fixed, values, strict=True):
        cv2.fillConvexPoly(mask, polygon, value, cv2.LINE_8, SHIFT)
    left = cv2.blur(cv2.resize(mask, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA), (3, 3))
    region = frame[y0:y1, x0:x1]
    cv2.multiply(region, cv2.cvtColor(left, cv2.COLOR_GRAY2BGR), region, scale=1 / 255)


def _box(points: Floats, shape: tuple[int, ...]) -> Box | None:
    """Bounding box of a blurred polygon, clipped to the image; None if empty."""
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    x0, y0 = max(int(left) - 2, 0), max(int(top) - 2, 0)
    x1, y1 = min(int(right) + 4, shape[1]), min(int(bottom) + 4, shape[0])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
