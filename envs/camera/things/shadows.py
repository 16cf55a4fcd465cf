"""Shadows of bodies on the road: the sun's, and the dark band right under the body."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.things.painter import Box, footprint
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.geometry import is_same
from vpf_sim.types import Floats, Image

RANGE_M, FADED_IN_M = 75.0, 45.0
FULLNESS = 0.85  # a body's shadow is that of a box of this part of its height
NO_SUN = 0.97  # a shadow that leaves more of the road's brightness does not show
FINE, SHIFT = 2, 4


class Shadow:
    """The shadow of one body, and its outlines on the road for as long as it keeps its pose."""

    def __init__(self, size: tuple[float, float, float], light: Light) -> None:
        self._size = size
        self._light = light
        self._pose: Floats = np.full(3, np.nan)
        self._outlines: list[Floats] = []

    def paint(self, frame: Image, view: View, pose: Floats) -> None:
        """Darken the ground where the body at a pose (x, y, heading) keeps the light off."""
        distance = np.hypot(*(pose[:2] - view.centre[:2]).tolist())
        if distance > RANGE_M:
            return
        if not is_same(pose, self._pose):
            self._pose, self._outlines = pose, self._cast(pose)
        polygons = [_in_picture(view, outline) for outline in self._outlines]
        full = min(1.0, (RANGE_M - distance) / (RANGE_M - FADED_IN_M))
        left = (self._light.shadow, self._light.contact)[-len(polygons) :]
        _darken(frame, polygons, [255.0 - full * 255.0 * (1.0 - share) for share in left])

    def _cast(self, pose: Floats) -> list[Floats]:
        """Outlines (n, 3) on the road, the lightest first."""
        length, width, height = self._size
        outlines = [footprint(pose, 0.97 * length, 0.9 * width)]
        if self._light.shadow < NO_SUN:
            sun, foot = self._light.sun, footprint(pose, length, width)
            fall = -sun[:2] / max(sun[2], 0.05) * FULLNESS * height
            both = np.concatenate([foot, foot + fall]).astype(np.float32)
            outlines.insert(0, cv2.convexHull(both)[:, 0].astype(float))
        return [np.column_stack([outline, np.zeros(len(outline))]) for outline in outlines]


def _in_picture(view: View, outline: Floats) -> Floats | None:
    """(n, 2) px; None if all of it lies behind the camera."""
    points = (outline - view.centre) @ view.axes.T
    inside = points[:, 2] > NEAR_M
    if not inside.any():
        return None
    return view.pixels(points if inside.all() else clip_near(points[None], inside[None])[0])


def _darken(frame: Image, polygons: list[Floats | None], values: list[float]) -> None:
    """Multiply the picture within polygons by values of 255, each where it lies over those before it."""
    shown = [(polygon, value) for polygon, value in zip(polygons, values, strict=True) if polygon is not None]
    box = _box(np.concatenate([polygon for polygon, _ in shown]), frame.shape) if shown else None
    if box is None:
        return
    x0, y0, x1, y1 = box
    mask = np.full((FINE * (y1 - y0), FINE * (x1 - x0)), 255, np.uint8)
    corner = np.array([x0, y0]) - 0.5 + 0.5 / FINE
    for polygon, value in shown:
        fixed = np.rint((polygon - corner) * (FINE << SHIFT)).astype(np.int32)
        cv2.fillConvexPoly(mask, fixed, value, cv2.LINE_8, SHIFT)
    left = cv2.blur(cv2.resize(mask, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA), (3, 3))
    region = frame[y0:y1, x0:x1]
    cv2.multiply(region, cv2.cvtColor(left, cv2.COLOR_GRAY2BGR), region, scale=1 / 255)


def _box(points: Floats, shape: tuple[int, ...]) -> Box | None:
    """The pixels that a blurred polygon with these corners may touch, within the picture; None if there are none."""
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    x0, y0 = max(int(left) - 2, 0), max(int(top) - 2, 0)
    x1, y1 = min(int(right) + 4, shape[1]), min(int(bottom) + 4, shape[0])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
