"""Draws faces into the image with sub-pixel accuracy.

Neighbouring items share a layer: a supersampled rectangle on which faces are filled without anti-aliasing. The
supersampling depends on the item alone, so an item looks the same whatever else is drawn. Averaged down, a layer holds
premultiplied colours and transparency (Porter and Duff 1984): edges get their exact coverage, and pixels without faces
do not change.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import cos, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Camera, Floats, Image

SHIFT = 4  # fractional bits of OpenCV's polygon coordinates
SUBPIXELS = 64  # fractions of a pixel to which polygons are rounded
HALF = 0.5 * SUBPIXELS + 0.5  # from a pixel's centre to its corner, plus rounding
SMALL_PX = 1200  # items with fewer pixels are supersampled 4 x 4, others 2 x 2
SPARE_PX = 40000  # cost of one more layer, in empty supersampled pixels
EMPTY = np.frombuffer(bytes((0, 0, 0, 255)), np.uint32)[0]  # a transparent pixel

Box = Sequence[int]  # x0, y0, x1, y1


Colour = Sequence[float]  # RGB times opacity, and transparency of 255


@dataclass(frozen=True, slots=True)
class Faces:
    """Projected faces in painter's order."""

    exact: Floats  # (n, V, 2) from the image's corner, in 1 / SUBPIXELS px
    fixed: NDArray[np.int32]  # (n, V, 2) the same, rounded
    colours: Sequence[Colour]  # (n,)
    planes: Callable[[], Floats]  # (n, 3), computed on demand


@dataclass(frozen=True, slots=True)
class Drawing:
    """One or more projected items in painter's order."""

    faces: Faces
    firsts: list[int]  # (k + 1,) the first face of each item, and the end
    boxes: list[Box]  # (k,) bounding box of each item, px

    @property
    def polygons_px(self) -> Floats:
        """(n, V, 2) px, the items' faces."""
        return (self.faces.exact[self._range] - HALF) / SUBPIXELS

    @property
    def planes(self) -> Floats:
        """(n, 3) planes: face i has the inverse depth planes[i] . ray at a pixel's ray (x, y, 1)."""
        return self.faces.planes()[self._range]

    @property
    def colours(self) -> Sequence[Colour]:
        """(n,) colours of the faces."""
        return self.faces.colours[self._range]

    @property
    def _range(self) -> slice:
        return slice(self.firsts[0], self.firsts[-1])

    def part(self, first: int, last: int) -> "Drawing":
        """The items `first` to `last` - 1."""
        return Drawing(self.faces, self.firsts[first : last + 1], self.boxes[first:last])


@dataclass(frozen=True, slots=True)
class Sprite:
    """A billboard: an upright image that faces the camera, at a place in the frame."""

    x: int
    y: int
    picture: Image  # (h, w, 4) premultiplied colours, and transparency of 255
    depth_m: float

    @property
    def colour(self) -> Image:
        """(h, w, 3) premultiplied colours."""
        return np.asarray(cv2.cvtColor(self.picture, cv2.COLOR_BGRA2BGR), np.uint8)

    @property
    def through(self) -> Image:
        """(h, w, 3) transparency, of 255."""
        return np.asarray(cv2.cvtColor(cv2.extractChannel(self.picture, 3), cv2.COLOR_GRAY2BGR), np.uint8)

    @property
    def box(self) -> Box:
        """x0, y0, x1, y1 px."""
        height, width = self.picture.shape[:2]
        return self.x, self.y, self.x + width, self.y + height


@dataclass(slots=True)
class _Layer:
    """Items that are drawn together."""

    box: Box
    fine: int  # supersampling, each way
    runs: list[tuple[Faces, int, int]] = field(default_factory=list)  # faces, first, end


def drawing(
    view: View, faces: Floats, colours: Sequence[Colour], planes: Callable[[], Floats], firsts: NDArray[np.int64]
) -> Drawing:
    """The projection of items with `faces` (n, V, 3) in the view's axes.

    Each face has a vertex beyond the near plane. `firsts` is (k,), the first face of each item.
    """
    projection = view.projection
    points = projection[:, :3] @ faces.reshape(-1, 3).T
    points += projection[:, 3:]
    if points[2].min() > NEAR_M:
        exact = points[:2] / points[2]
        vertices = faces.shape[1]
    else:
        cut = in_front(view.camera_axes(faces))
        exact, vertices = view.pixels(cut).reshape(-1, 2).T, cut.shape[1]
    exact *= SUBPIXELS
    exact += HALF
    fixed = exact.T.astype(np.int32, order="C")
    boxes = _boxes(fixed, firsts * vertices, view.camera)
    shape = (len(faces), vertices, 2)
    projected = Faces(exact.T.reshape(shape), fixed.reshape(shape), colours, planes)
    return Drawing(projected, [*firsts.tolist(), len(faces)], boxes)


def planes_of(normals: Floats, distances: Floats, view: View) -> Floats:
    """(n, 3) planes of faces with `normals` (n, 3) at signed `distances` (n,) m from the camera."""
    return np.asarray(normals @ view.axes.T / -distances[:, None])


def _boxes(points: NDArray[np.int32], firsts: NDArray[np.int64], camera: Camera) -> list[Box]:
    """The bounding box of each item, px; `firsts` are their first points."""
    low, high = np.minimum.reduceat(points, firsts) // SUBPIXELS, np.maximum.reduceat(points, firsts) // SUBPIXELS
    width, height = camera.width_px, camera.height_px
    return [
        (x0 if x0 > 0 else 0, y0 if y0 > 0 else 0, x1 + 1 if x1 < width else width, y1 + 1 if y1 < height else height)
        for (x0, y0), (x1, y1) in zip(low.tolist(), high.tolist(), strict=True)
    ]


def in_front(faces: Floats, near_m: float = NEAR_M) -> Floats:
    """(n, W, 3) faces (n, V, 3) in camera axes, clipped to beyond the depth `near_m`; W >= V."""
    behind = faces[..., 2] <= near_m
    cut = np.flatnonzero(behind.any(axis=1))
    if not len(cut):
        return faces
    parts = clip_near(faces[cut], ~behind[cut], near_m)
    wider = max(0, parts.shape[1] - faces.shape[1])
    result = np.concatenate([faces, faces[:, -1:].repeat(wider, axis=1)], axis=1)
    result[cut, : parts.shape[1]] = parts
    result[cut, parts.shape[1] :] = parts[:, -1:]
    return result


def paint(frame: Image, drawn: list[Drawing | Sprite]) -> None:
    """Draw items over the image, in their order."""
    waiting: list[_Layer] = []
    for item in drawn:
        if isinstance(item, Sprite):
            waiting = _flushed_under(frame, item, waiting)
            paint_sprite(frame, item)
            continue
        for box, first, last in zip(item.boxes, item.firsts, item.firsts[1:], strict=False):
            if box[0] < box[2] and box[1] < box[3]:
                waiting = _joined(frame, waiting, box, (item.faces, first, last))
    for layer in waiting:
        _flush(frame, layer)


def paint_sprite(frame: Image, sprite: Sprite) -> None:
    """Draw a billboard over the image."""
    _blend(frame, sprite.x, sprite.y, sprite.picture)


def _blend(frame: Image, x: int, y: int, picture: Image) -> None:
    """Draw an image (h, w, 4) over the frame with its corner at (x, y)."""
    height, width = picture.shape[:2]
    region = frame[y : y + height, x : x + width]
    through = cv2.cvtColor(cv2.extractChannel(picture, 3), cv2.COLOR_GRAY2BGR)
    cv2.multiply(region, through, region, scale=1 / 255)
    cv2.add(region, cv2.cvtColor(picture, cv2.COLOR_BGRA2BGR), region)


def _flushed_under(frame: Image, sprite: Sprite, waiting: list[_Layer]) -> list[_Layer]:
    """Draw the pending layers that a sprite overlaps; returns the others."""
    if not waiting:
        return waiting
    a0, b0, a1, b1 = sprite.box
    left = []
    for layer in waiting:
        x0, y0, x1, y1 = layer.box
        if x0 < a1 and a0 < x1 and y0 < b1 and b0 < y1:
            _flush(frame, layer)
        else:
            left.append(layer)
    return left


def _joined(frame: Image, waiting: list[_Layer], box: Box, run: tuple[Faces, int, int]) -> list[_Layer]:
    """The pending layers with one more item: merged with near ones, or in a layer of its own.

    Layers that it overlaps but cannot share are drawn first.
    """
    a0, b0, a1, b1 = box
    fine = 4 if (a1 - a0) * (b1 - b0) < SMALL_PX else 2
    spare = SPARE_PX // fine**2
    target: _Layer | None = None
    others = []
    for layer in waiting:
        x0, y0, x1, y1 = layer.box
        u0, v0 = a0 if a0 < x0 else x0, b0 if b0 < y0 else y0
        u1, v1 = a1 if a1 > x1 else x1, b1 if b1 > y1 else y1
        empty = (u1 - u0) * (v1 - v0) - (a1 - a0) * (b1 - b0) - (x1 - x0) * (y1 - y0)
        if layer.fine != fine or empty > spare:
            if a0 < x1 and x0 < a1 and b0 < y1 and y0 < b1:
                _flush(frame, layer)
            else:
                others.append(layer)
            continue
        if target is None:
            target = layer
        else:
            target.runs += layer.runs
        a0, b0, a1, b1 = u0, v0, u1, v1
    if target is None:
        target = _Layer(box, fine)
    target.box = (a0, b0, a1, b1)
    if target.runs and target.runs[-1][0] is run[0] and target.runs[-1][2] == run[1]:
        run = (run[0], target.runs.pop()[1], run[2])
    target.runs.append(run)
    others.append(target)
    return others


def _flush(frame: Image, layer: _Layer) -> None:
    """Draw a layer over the frame."""
    x0, y0, x1, y1 = layer.box
    height, width = y1 - y0, x1 - x0
    fine = layer.fine
    empty = np.empty((height * fine, width * fine), np.uint32)
    empty.fill(EMPTY)
    canvas: Image = empty.view(np.uint8).reshape(-1, width * fine, 4)
    shift = (SUBPIXELS // fine).bit_length() - 1
    half_px = SUBPIXELS // 2 // fine
    corner = np.array((x0 * SUBPIXELS + half_px, y0 * SUBPIXELS + half_px), np.int32)
    for faces, first, last in layer.runs:
        polygons = faces.fixed[first:last] - corner
        for polygon, colour in zip(polygons, faces.colours[first:last], strict=True):
            cv2.fillConvexPoly(canvas, polygon, colour, cv2.LINE_8, shift)
    while len(canvas) > height:
        half = (canvas.shape[1] // 2, canvas.shape[0] // 2)
        canvas = np.asarray(cv2.resize(canvas, half, interpolation=cv2.INTER_AREA), np.uint8)
    _blend(frame, x0, y0, canvas)


def footprint(pose: Floats, length: float, width: float) -> Floats:
    """(4, 2) m, the footprint of an object at a pose (x, y, heading)."""
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
