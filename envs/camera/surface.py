"""The painted ground in the picture, one channel of palette values.

Polygons are filled without anti-aliasing on canvases several times as fine as the picture and averaged down, which
gives every edge its exact coverage: 2 x 2 near the car, 4 x 8 far away, where one row of pixels spans many metres.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.grain import ground_top, row_distance
from vpf_sim.envs.camera.nearby import Indices, Nearby
from vpf_sim.envs.camera.paint import GRASS, RANGE_M, Batch
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near
from vpf_sim.types import Bools, Camera, Floats, Image

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

    def fixed_from_ground(self, view: View) -> Floats:
        """(3, 3) from points of the ground, (x, y, 1) m in the world, to homogeneous coordinates of this canvas, in
        OpenCV's fixed point."""
        camera = view.camera
        lens = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        ground = np.column_stack([view.axes[:, :2], -view.axes @ view.centre])
        scale = np.array([self.fine_x, self.fine_y], float) * 2**SHIFT
        offset = np.array([0.5 * self.fine_x - 0.5, (0.5 - self.first) * self.fine_y - 0.5]) * 2**SHIFT
        fixed = np.array([[scale[0], 0.0, offset[0]], [0.0, scale[1], offset[1]], [0.0, 0.0, 1.0]])
        return np.asarray(fixed @ lens @ ground)


class Polygons:
    """All polygons of a road in the order in which they are laid, their vertices in one array."""

    def __init__(self, camera: Camera, batches: list[Batch]) -> None:
        self.points_m = np.concatenate([batch.polygons_m.reshape(-1, 2) for batch in batches])
        self.across_m = np.concatenate([_across(batch).reshape(-1, 2) for batch in batches])
        self.thin = np.concatenate([np.full(batch.polygons_m[..., 0].size, batch.thin) for batch in batches])
        self.counts = np.concatenate([np.full(len(b.values), b.polygons_m.shape[1]) for b in batches])
        self.starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        self.values = np.concatenate([batch.values for batch in batches])
        self.radii_m = np.concatenate([batch.radii_m for batch in batches])
        centres = np.concatenate([batch.centres_m for batch in batches])
        ranges = np.concatenate([np.full(len(batch.values), batch.range_m) for batch in batches])
        self.nearby = Nearby(camera, centres, self.radii_m, ranges)
        strips = np.concatenate([batch.strips for batch in batches])
        owner = np.repeat(np.arange(len(batches)), [len(batch.values) for batch in batches])
        self.runs = np.cumsum(np.diff(strips, prepend=-1).astype(bool) | np.diff(owner, prepend=-1).astype(bool))


class Surface:
    """Draws what is painted on the ground."""

    def __init__(self, camera: Camera, batches: list[Batch]) -> None:
        self._camera = camera
        self._polygons = Polygons(camera, batches)
        top = ground_top(camera)
        far = min(FAR_ROWS, camera.height_px - top)
        near = camera.height_px - top - far
        width = camera.width_px
        self._far = Canvas(np.empty((8 * far, 4 * width), np.uint8), top, far, 4, 8)
        self._near = Canvas(np.empty((2 * near, 2 * width), np.uint8), top + far, near, 2, 2)
        self._far_from_m, self._near_to_m = row_distance(camera)[[far, far - 1]]
        self._picture = np.empty((far + near, width), np.uint8)

    def draw(self, view: View) -> Image:
        """(rows, W) palette values from the top of the ground down; valid until the next call."""
        self._far.pixels[:] = GRASS
        self._near.pixels[:] = GRASS
        seen, ahead = self._polygons.nearby.in_view(view)
        if len(seen):
            self._fill(view, seen, ahead)
        far = _halved(_halved(self._far.pixels))
        cv2.addWeighted(far[0::2], 0.5, far[1::2], 0.5, 0.0, self._picture[: self._far.rows])
        self._picture[self._far.rows :] = _halved(self._near.pixels)
        return self._picture

    def _fill(self, view: View, seen: Indices, ahead: Floats) -> None:
        """Fill the polygons `seen`, whose middles lie `ahead`."""
        counts = self._polygons.counts[seen]
        ends = np.cumsum(counts)
        starts = ends - counts
        vertices = np.repeat(self._polygons.starts[seen] - starts, counts) + np.arange(ends[-1])
        points = self._narrowed(view, vertices)
        nearest, farthest = ahead - self._polygons.radii_m[seen], ahead + self._polygons.radii_m[seen]
        rise = self._camera.height_m * np.sin(self._camera.pitch_rad)  # what looking down adds to the depth
        cut = np.flatnonzero(np.cos(self._camera.pitch_rad) * nearest + rise <= NEAR_M)
        corners = starts[cut, None] + np.minimum(np.arange(counts.max()), counts[cut, None] - 1)
        clipped, beyond = _clipped(points[corners], _depth_of_ground(view))
        points[corners] += 2.0 * RANGE_M * view.axes[2, :2]  # what lies behind has no place on the canvases
        farthest[cut[~beyond]], cut = -np.inf, cut[beyond]
        runs = self._polygons.runs[seen]
        for canvas, shown in (
            (self._far, farthest > self._far_from_m),
            (self._near, (nearest < self._near_to_m) & (farthest > 0.0)),
        ):
            matrix = canvas.fixed_from_ground(view)
            fixed = _transformed(points, matrix)
            index = np.flatnonzero(shown)
            polygons = [fixed[a:b] for a, b in zip(starts[index].tolist(), ends[index].tolist(), strict=True)]
            split = shown[cut]
            places = np.searchsorted(index, cut[split]).tolist()
            for place, polygon in zip(places, _transformed(clipped, matrix)[split], strict=True):
                polygons[place] = polygon
            last = [*(np.flatnonzero(np.diff(runs[index])) + 1).tolist(), len(index)]
            first = 0
            for end, value in zip(last, self._polygons.values[seen[index[np.array(last) - 1]]].tolist(), strict=True):
                cv2.fillPoly(canvas.pixels, polygons[first:end], value, cv2.LINE_8, SHIFT)
                first = end

    def _narrowed(self, view: View, vertices: Indices) -> Floats:
        """(P, 2) m vertices from the camera's foot, lines narrowed by what OpenCV's filling adds: half a pixel of the
        canvas."""
        points: Floats = self._polygons.points_m.take(vertices, axis=0)
        thin = np.flatnonzero(self._polygons.thin.take(vertices))
        right = view.axes[0, :2]
        across = self._polygons.across_m.take(vertices[thin], axis=0) @ right
        ground = _depth_of_ground(view)
        depth = np.abs(points.take(thin, axis=0) @ ground[:2] + ground[2])
        border_m = self._camera.fy_px * self._camera.height_m / FAR_ROWS
        inset = np.where(depth < border_m, 0.25, 0.125) * depth / self._camera.fx_px
        points[thin] += np.copysign(np.minimum(inset, 0.45 * np.abs(across)), across)[:, None] * right
        return points


def _depth_of_ground(view: View) -> Floats:
    """(3,) the depth of a point (x, y) m of the world's ground is the product with (x, y, 1)."""
    return np.array([*view.axes[2, :2], -view.axes[2] @ view.centre])


def _transformed(points: Floats, matrix: Floats) -> NDArray[np.int32]:
    """(..., 2) points under a homography, as whole numbers."""
    homogeneous = cv2.perspectiveTransform(points.reshape(1, -1, 2), matrix)
    return np.rint(homogeneous).astype(np.int32).reshape(points.shape)


def _clipped(polygons: Floats, depth: Floats) -> tuple[Floats, Bools]:
    """What of polygons (n, V, 2) of the ground lies beyond the near plane, and of which (n,) anything does."""
    corners = np.concatenate([polygons, (polygons @ depth[:2] + depth[2])[..., None]], axis=2)
    inside = corners[..., 2] > NEAR_M
    beyond: Bools = np.asarray(inside.any(axis=1))
    return clip_near(corners[beyond], inside[beyond])[..., :2], beyond


def _across(batch: Batch) -> Floats:
    """(n, V, 2) m from each vertex of a line to the one beside it, 0 for other polygons."""
    return batch.polygons_m[:, ::-1] - batch.polygons_m if batch.thin else np.zeros_like(batch.polygons_m)


def _halved(picture: Image) -> Image:
    height, width = picture.shape
    return np.asarray(cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8)
