"""Draws faces into the picture, sub-pixel exact.

A rectangle of the picture is enlarged, faces are filled on it without anti-aliasing, and it is averaged down again: the
untouched pixels come back as they were and the edges get their exact coverage.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.mesh import Mesh
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Floats, Image

SHIFT = 4  # fractional bits of OpenCV's polygon coordinates
SMALL_PX = 6000  # rectangles with less pixels are drawn four times as fine, the others twice


VISIBLE_PX = 0.6  # faces thinner than this are not drawn


@dataclass(frozen=True, slots=True)
class Drawing:
    """Faces of one thing in the picture, in painter's order."""

    polygons_px: Floats  # (n, V, 2)
    colours: Floats  # (n, 3)
    planes: Floats  # (n, 3) inverse depth of face i at a pixel's ray (x, y, 1) is planes[i] . ray

    def __getitem__(self, part: slice) -> "Drawing":
        """Some of the faces."""
        return Drawing(self.polygons_px[part], self.colours[part], self.planes[part])


def project_mesh(view: View, mesh: Mesh, pose: Floats, light: Light) -> Drawing:
    """The visible faces of a mesh at a pose (x, y, heading)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    axes = view.axes @ turn
    origin = view.axes @ (np.array([pose[0], pose[1], 0.0]) - view.centre)
    faces = mesh.faces_m @ axes.T + origin
    normals = mesh.normals @ axes.T
    offset = np.einsum("ij,ij->i", normals, faces[:, 0])
    inside = faces[..., 2] > NEAR_M
    visible = VISIBLE_PX * max(float(origin[2]) - 2.0, 0.0) / view.camera.fx_px  # m; what is thinner there is left out
    shown = np.flatnonzero((offset < -1e-6) & inside.any(axis=1) & (mesh.thickness_m >= visible))
    if mesh.parts[-1] > 0:
        shown = shown[np.argsort(-_part_distances(mesh, faces)[mesh.parts[shown]], kind="stable")]
    facing = np.maximum(0.0, mesh.normals[shown] @ (light.sun @ turn))[:, None]
    shading = np.where(mesh.lit[shown, None], light.sky + light.direct * facing, 1.0)
    colours = np.minimum(mesh.colours[shown] * shading, 255.0)
    planes = normals[shown] / offset[shown, None]
    faces, inside = faces[shown], inside[shown]
    return Drawing(view.pixels(faces if inside.all() else clip_near(faces, inside)), colours, planes)


def paint(frame: Image, drawing: Drawing) -> None:
    """Draw faces over the picture."""
    box = bounding_box(drawing.polygons_px, frame.shape)
    if box is None:
        return
    x0, y0, x1, y1 = box
    region = frame[y0:y1, x0:x1]
    fine = 4 if region.size < 3 * SMALL_PX else 2
    canvas = cv2.resize(region, ((x1 - x0) * fine, (y1 - y0) * fine), interpolation=cv2.INTER_NEAREST)
    scale, offset = fine * 2**SHIFT, np.array([0.5 - x0, 0.5 - y0]) - 0.5 / fine
    fixed = np.rint((drawing.polygons_px + offset) * scale).astype(np.int32)
    for polygon, colour in zip(fixed, drawing.colours.tolist(), strict=True):
        cv2.fillConvexPoly(canvas, polygon, colour, cv2.LINE_8, SHIFT)
    while canvas.shape[0] > y1 - y0:
        canvas = cv2.resize(canvas, (canvas.shape[1] // 2, canvas.shape[0] // 2), interpolation=cv2.INTER_AREA)
    region[:] = canvas


def bounding_box(polygons: Floats, shape: tuple[int, ...]) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 of the pixels that polygons (..., 2) may touch, within the picture; None if there are none."""
    points = polygons.reshape(-1, 2)
    low, high = points.min(axis=0) - 1.0, points.max(axis=0) + 2.0
    x0, y0 = np.maximum(np.floor(low), 0.0)
    x1, y1 = np.minimum(np.ceil(high), [shape[1], shape[0]])
    return (int(x0), int(y0), int(x1), int(y1)) if x0 < x1 and y0 < y1 else None


def footprint(pose: Floats, length: float, width: float) -> Floats:
    """(4, 2) m, the corners of a body at a pose (x, y, heading)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    corners = 0.5 * np.array([[-length, -width], [-length, width], [length, width], [length, -width]])
    turned: Floats = corners @ np.array([[c, s], [-s, c]]) + pose[:2]
    return turned


def _part_distances(mesh: Mesh, faces: Floats) -> Floats:
    """(parts,) how far the middle of each part of a mesh is from the camera."""
    centres = faces.mean(axis=1)
    counts = np.bincount(mesh.parts)
    return np.asarray(np.hypot(*(np.bincount(mesh.parts, centres[:, i]) / counts for i in (0, 2))))
