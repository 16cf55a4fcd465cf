"""Draws faces into the picture, sub-pixel exact.

Things that lie side by side in the picture share a layer: an empty rectangle, finer than the picture, on which faces
are filled without anti-aliasing; how fine depends on the thing, so that it looks the same in any company. Averaged
down, the layer holds colours times opacity and what is seen through it (Porter and Duff 1984), so that edges get their
exact coverage and the picture beneath stays as it was where nothing is drawn.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import cos, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Floats, Image

SHIFT = 4  # fractional bits of OpenCV's polygon coordinates
SUBPIXELS = 64  # polygons are rounded to parts of a pixel
SMALL_PX = 1200  # things in less pixels are drawn four times as fine, the others twice
SPARE_PX = 40000  # what one more layer costs, in empty pixels of a larger one, counted on the layer
EMPTY = np.frombuffer(bytes((0, 0, 0, 255)), np.uint32)[0]  # a pixel of a layer on which nothing is drawn

Box = Sequence[int]  # x0, y0, x1, y1


@dataclass(frozen=True, slots=True)
class Drawing:
    """Faces of one or more things in the picture, in painter's order."""

    polygons_px: Floats  # (n, V, 2)
    fixed: NDArray[np.int32]  # (n, V, 2) the same, from the corner of the picture, in parts of a pixel
    colours: Floats  # (n, 4) RGB times opacity, and what is seen through, of 255
    planes: Floats  # (n, 3) inverse depth of face i at a pixel's ray (x, y, 1) is planes[i] . ray
    firsts: list[int]  # (k + 1,) the first face of each thing, and n
    boxes: list[Box]  # (k,) the pixels that each thing may touch

    def part(self, first: int, last: int) -> "Drawing":
        """The things `first` to `last` - 1."""
        a, b = self.firsts[first], self.firsts[last]
        firsts = [face - a for face in self.firsts[first : last + 1]]
        return Drawing(
            self.polygons_px[a:b],
            self.fixed[a:b],
            self.colours[a:b],
            self.planes[a:b],
            firsts,
            self.boxes[first:last],
        )


@dataclass(frozen=True, slots=True)
class Sprite:
    """An upright picture that faces the camera, and where it lies in the frame."""

    x: int
    y: int
    picture: Image  # (h, w, 4) colours times opacity, and what is seen through, of 255
    depth_m: float

    @property
    def colour(self) -> Image:
        """(h, w, 3) colours times opacity."""
        return np.asarray(cv2.cvtColor(self.picture, cv2.COLOR_BGRA2BGR), np.uint8)

    @property
    def through(self) -> Image:
        """(h, w, 3) what is seen through, of 255."""
        return np.asarray(cv2.cvtColor(cv2.extractChannel(self.picture, 3), cv2.COLOR_GRAY2BGR), np.uint8)

    @property
    def box(self) -> Box:
        """x0, y0, x1, y1 of its pixels."""
        height, width = self.picture.shape[:2]
        return self.x, self.y, self.x + width, self.y + height


@dataclass(slots=True)
class _Layer:
    """Things that will be drawn together."""

    box: Box
    fine: int  # pixels of the layer to one of the picture, each way
    runs: list[tuple[Drawing, int, int]] = field(default_factory=list)  # faces from the first up to the second


def drawing(view: View, faces: Floats, colours: Floats, planes: Floats, firsts: NDArray[np.int64]) -> Drawing:
    """The drawing of things whose `faces` (n, V, 3) are given in camera axes, each with a vertex beyond the near plane.

    `firsts` is (k,), the first face of each thing.
    """
    polygons = view.pixels(in_front(faces))
    exact = polygons * SUBPIXELS
    exact += 0.5 * SUBPIXELS + 0.5
    fixed = exact.astype(np.int32)
    points, each = fixed.reshape(-1, 2), firsts * fixed.shape[1]
    limits = np.array([view.camera.width_px, view.camera.height_px])
    low, high = np.minimum.reduceat(points, each) // SUBPIXELS, np.maximum.reduceat(points, each) // SUBPIXELS + 1
    boxes = np.concatenate([np.maximum(low, 0), np.minimum(high, limits)], axis=1).tolist()
    return Drawing(polygons, fixed, colours, planes, [*firsts.tolist(), len(faces)], boxes)


def in_front(faces: Floats) -> Floats:
    """(n, V or 2 V, 3) those parts of faces that lie beyond the near plane."""
    if faces[..., 2].min() > NEAR_M:
        return faces
    behind = faces[..., 2] <= NEAR_M
    cut = np.flatnonzero(behind.any(axis=1))
    result = np.concatenate([faces, faces[:, -1:].repeat(faces.shape[1], axis=1)], axis=1)
    result[cut] = clip_near(faces[cut], ~behind[cut])
    return result


def paint(frame: Image, drawn: list[Drawing | Sprite]) -> None:
    """Draw things over the picture, in their order."""
    waiting: list[_Layer] = []
    for thing in drawn:
        if isinstance(thing, Sprite):
            waiting = _painted_under(frame, thing, waiting)
            paint_sprite(frame, thing)
            continue
        for box, first, last in zip(thing.boxes, thing.firsts, thing.firsts[1:], strict=False):
            if box[0] < box[2] and box[1] < box[3]:
                waiting = _joined(frame, waiting, box, (thing, first, last))
    for layer in waiting:
        paint_sprite(frame, _rasterised(layer))


def paint_sprite(frame: Image, sprite: Sprite) -> None:
    """Draw an upright picture over the picture."""
    x0, y0, x1, y1 = sprite.box
    region = frame[y0:y1, x0:x1]
    cv2.multiply(region, sprite.through, region, scale=1 / 255)
    cv2.add(region, sprite.colour, region)


def _painted_under(frame: Image, sprite: Sprite, waiting: list[_Layer]) -> list[_Layer]:
    """Draw the layers that a sprite covers; those that still wait."""
    if not waiting:
        return waiting
    a0, b0, a1, b1 = sprite.box
    left = []
    for layer in waiting:
        x0, y0, x1, y1 = layer.box
        if x0 < a1 and a0 < x1 and y0 < b1 and b0 < y1:
            paint_sprite(frame, _rasterised(layer))
        else:
            left.append(layer)
    return left


def _joined(frame: Image, waiting: list[_Layer], box: Box, run: tuple[Drawing, int, int]) -> list[_Layer]:
    """Layers with one more thing: together with those that lie near, or in a layer of its own.

    What it would cover, and what lies too far off to share a layer with, is drawn.
    """
    a0, b0, a1, b1 = box
    fine = 4 if (a1 - a0) * (b1 - b0) < SMALL_PX else 2
    spare = SPARE_PX // fine**2
    mine: _Layer | None = None
    others = []
    for layer in waiting:
        x0, y0, x1, y1 = layer.box
        u0, v0 = a0 if a0 < x0 else x0, b0 if b0 < y0 else y0
        u1, v1 = a1 if a1 > x1 else x1, b1 if b1 > y1 else y1
        empty = (u1 - u0) * (v1 - v0) - (a1 - a0) * (b1 - b0) - (x1 - x0) * (y1 - y0)
        if layer.fine != fine or empty > spare:
            if a0 < x1 and x0 < a1 and b0 < y1 and y0 < b1:
                paint_sprite(frame, _rasterised(layer))
            else:
                others.append(layer)
            continue
        if mine is None:
            mine = layer
        else:
            mine.runs += layer.runs
        a0, b0, a1, b1 = u0, v0, u1, v1
    if mine is None:
        mine = _Layer(box, fine)
    mine.box = (a0, b0, a1, b1)
    if mine.runs and mine.runs[-1][0] is run[0] and mine.runs[-1][2] == run[1]:
        run = (run[0], mine.runs.pop()[1], run[2])
    mine.runs.append(run)
    others.append(mine)
    return others


def _rasterised(layer: _Layer) -> Sprite:
    """The picture of a layer."""
    x0, y0, x1, y1 = layer.box
    height, width = y1 - y0, x1 - x0
    fine = layer.fine
    empty = np.empty((height * fine, width * fine), np.uint32)
    empty.fill(EMPTY)
    canvas: Image = empty.view(np.uint8).reshape(-1, width * fine, 4)
    shift = (SUBPIXELS // fine).bit_length() - 1
    corner = np.array([x0, y0], np.int32) * SUBPIXELS + SUBPIXELS // 2 // fine
    for thing, first, last in layer.runs:
        polygons = thing.fixed[first:last] - corner
        for polygon, colour in zip(polygons, thing.colours[first:last].tolist(), strict=True):
            cv2.fillConvexPoly(canvas, polygon, colour, cv2.LINE_8, shift)
    while len(canvas) > height:
        half = (canvas.shape[1] // 2, canvas.shape[0] // 2)
        canvas = np.asarray(cv2.resize(canvas, half, interpolation=cv2.INTER_AREA), np.uint8)
    return Sprite(x0, y0, canvas, 0.0)


def bounding_box(polygons: Floats, shape: tuple[int, ...]) -> Box | None:
    """x0, y0, x1, y1 of the pixels that polygons (..., 2) may touch, within the picture; None if there are none."""
    points = polygons.reshape(-1, 2)
    low, high = points.min(axis=0) - 1.0, points.max(axis=0) + 2.0
    x0, y0 = np.maximum(np.floor(low), 0.0)
    x1, y1 = np.minimum(np.ceil(high), [shape[1], shape[0]])
    return (int(x0), int(y0), int(x1), int(y1)) if x0 < x1 and y0 < y1 else None


def footprint(pose: Floats, length: float, width: float) -> Floats:
    """(4, 2) m, the corners of a body at a pose (x, y, heading)."""
    x, y, heading = pose.tolist()
    ahead_x, ahead_y = 0.5 * length * cos(heading), 0.5 * length * sin(heading)
    right_x, right_y = -0.5 * width * sin(heading), 0.5 * width * cos(heading)
    return np.array(
        [
            (x - ahead_x - right_x, y - ahead_y - right_y),
            (x - ahead_x + right_x, y - ahead_y + right_y),
            (x + ahead_x + right_x, y + ahead_y + right_y),
            (x + ahead_x - right_x, y + ahead_y - right_y),
        ]
    )
