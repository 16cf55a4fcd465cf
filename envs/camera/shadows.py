"""Shadows of bodies on the road: the sun's, and the dark band right under the body."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import SHIFT, bounding_box, footprint
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Floats, Image

RANGE_M = 90.0
FULLNESS = 0.85  # a body's shadow is that of a box of this part of its height


def paint_shadow(frame: Image, view: View, pose: Floats, size: tuple[float, float, float], light: Light) -> None:
    """Darken the ground where a body of `size` (length, width, height) at `pose` (x, y, heading) keeps the sun off."""
    if np.hypot(*(pose[:2] - view.centre[:2])) > RANGE_M:
        return
    foot = footprint(pose, size[0], size[1])
    fall = -light.sun[:2] / light.sun[2] * FULLNESS * size[2]
    under = footprint(pose, 0.97 * size[0], 0.9 * size[1])
    outlines = [cv2.convexHull(np.concatenate([foot, foot + fall]).astype(np.float32))[:, 0].astype(float), under]
    points = view.camera_axes(np.column_stack([np.concatenate(outlines), np.zeros(len(outlines[0]) + 4)]))
    polygons = [points[:-4], points[-4:]]
    if points[:, 2].min() <= NEAR_M:
        inside = [polygon[:, 2] > NEAR_M for polygon in polygons]
        if not (inside[0].any() and inside[1].any()):
            return
        polygons = [clip_near(polygon[None], flags[None])[0] for polygon, flags in zip(polygons, inside, strict=True)]
    shown = list(zip([view.pixels(polygon) for polygon in polygons], (light.shadow, light.contact), strict=True))
    box = bounding_box(np.concatenate([polygon for polygon, _ in shown]), frame.shape)
    if box is None:
        return
    x0, y0, x1, y1 = box
    mask = np.full((2 * (y1 - y0), 2 * (x1 - x0)), 255, np.uint8)
    for polygon, value in shown:
        fixed = np.rint(((polygon - np.array([x0, y0]) + 0.5) * 2.0 - 0.5) * 2**SHIFT).astype(np.int32)
        cv2.fillConvexPoly(mask, fixed, round(255.0 * value), cv2.LINE_8, SHIFT)
    left = cv2.blur(cv2.resize(mask, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA), (3, 3))
    region = frame[y0:y1, x0:x1]
    cv2.multiply(region, cv2.merge([left, left, left]), region, scale=1 / 255)
