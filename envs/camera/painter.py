"""Draws faces into the picture, sub-pixel exact.

A rectangle of the picture is enlarged, faces are filled on it without anti-aliasing, and it is averaged down again: the
untouched pixels come back as they were and the edges get their exact coverage.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.envs.camera.mesh import Mesh
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Floats, Image

SHIFT = 4


@dataclass(frozen=True, slots=True)
class Light:
    """Sun and sky on a surface: colour x (sky + sun x cosine)."""

    sun: Floats  # (3,) unit vector towards the sun, world axes with z up
    sky: float = 0.55
    direct: float = 0.6


@dataclass(frozen=True, slots=True)
class Drawing:
    """Faces of one body in the picture, in painter's order."""

    polygons_px: list[Floats]  # each (V, 2)
    colours: Floats  # (n, 3)
    planes: Floats  # (n, 3) inverse depth of face i at a pixel's ray (x, y, 1) is planes[i] . ray


def project_mesh(view: View, mesh: Mesh, position: Floats, heading: float, light: Light) -> Drawing:
    """The visible faces of a mesh at a pose."""
    c, s = np.cos(heading), np.sin(heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    axes = view.axes @ turn
    origin = view.axes @ (np.array([position[0], position[1], 0.0]) - view.centre)
    faces = mesh.faces_m @ axes.T + origin
    normals = mesh.normals @ axes.T
    offset = np.einsum("ij,ij->i", normals, faces[:, 0])
    inside = faces[..., 2] > NEAR_M
    shown = np.flatnonzero((offset < -1e-6) & inside.any(axis=1))
    shade = light.sky + light.direct * np.maximum(0.0, (mesh.normals[shown] @ turn.T) @ light.sun)
    colours = np.minimum(mesh.colours[shown] * np.where(mesh.lit[shown], shade, 1.0)[:, None], 255.0)
    planes = normals[shown] / offset[shown, None]
    if inside[shown].all():
        return Drawing(list(view.pixels(faces[shown])), colours, planes)
    return Drawing(list(view.pixels(clip_near(faces[shown], inside[shown]))), colours, planes)


def paint(frame: Image, drawing: Drawing) -> None:
    """Draw faces over the picture."""
    if not drawing.polygons_px:
        return
    box = bounding_box(drawing.polygons_px, frame.shape)
    if box is None:
        return
    x0, y0, x1, y1 = box
    region = frame[y0:y1, x0:x1]
    fine = 4 if (x1 - x0) * (y1 - y0) < 6000 else 2
    canvas = cv2.resize(region, ((x1 - x0) * fine, (y1 - y0) * fine), interpolation=cv2.INTER_NEAREST)
    offset = np.array([0.5 - x0, 0.5 - y0])
    for polygon, colour in zip(drawing.polygons_px, drawing.colours.tolist(), strict=True):
        fixed = np.rint(((polygon + offset) * fine - 0.5) * 2**SHIFT).astype(np.int32)
        cv2.fillConvexPoly(canvas, fixed, colour, cv2.LINE_8, SHIFT)
    while canvas.shape[0] > y1 - y0:
        canvas = cv2.resize(canvas, (canvas.shape[1] // 2, canvas.shape[0] // 2), interpolation=cv2.INTER_AREA)
    region[:] = canvas


def bounding_box(polygons: list[Floats], shape: tuple[int, ...]) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 of the pixels that polygons may touch, within the picture; None if there are none."""
    low = np.min([p.min(axis=0) for p in polygons], axis=0) - 1.0
    high = np.max([p.max(axis=0) for p in polygons], axis=0) + 2.0
    x0, y0 = np.maximum(np.floor(low), 0.0).astype(int)
    x1, y1 = np.minimum(np.ceil(high), [shape[1], shape[0]]).astype(int)
    return (int(x0), int(y0), int(x1), int(y1)) if x0 < x1 and y0 < y1 else None
