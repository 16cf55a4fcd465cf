"""Rasterises the ground's polygons to palette values.

Polygons are filled without anti-aliasing on a supersampled canvas and averaged down: edges get their exact coverage.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.ground.paint import GRASS, Batch
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.view import NEAR_M
from vpf_sim.types import Bools, Floats, Image

SHIFT = 4  # fractional bits of OpenCV's polygon coordinates
STEP_M = 12.0  # travel of the raster before nearby polygons are collected again

Indices = NDArray[np.int64]


class Polygons:
    """The polygons of a road in drawing order, with their vertices in one array.

    Repeated vertices, which pad short polygons, are left out.
    """

    def __init__(self, batches: list[Batch]) -> None:
        kept = [_kept(batch) for batch in batches]
        narrowed = [(batch, keep) for batch, keep in zip(batches, kept, strict=True) if batch.thin]
        self.points_m = _pairs([batch.polygons_m[keep] for batch, keep in zip(batches, kept, strict=True)])
        # of the vertices of thin strips alone, which `narrowed` numbers
        self.across_m = _pairs([_across(batch)[keep] for batch, keep in narrowed])
        self.along_m = _pairs([_along(batch)[keep] for batch, keep in narrowed])
        self.counts = _joined([keep.sum(axis=1) for keep in kept], np.int64)
        self.starts = np.cumsum(self.counts) - self.counts
        self.thin = np.repeat(_joined([np.full(len(b.values), b.thin) for b in batches], bool), self.counts)
        self.narrowed = np.cumsum(self.thin) - 1
        self.ranges_m = _joined([np.full(len(b.values), b.range_m) for b in batches], np.float64)
        self.values = _joined([batch.values for batch in batches], np.int64)
        circles = [_circles(batch) for batch in batches]
        self.centres_m = _pairs([centres for centres, _ in circles])
        self.radii_m = _joined([radii for _, radii in circles], np.float64)
        self.runs = np.cumsum(_joined([_begins_run(batch) for batch in batches], bool))


class Surface:
    """Draws the ground's polygons on rasters near each other, for a level from the depth `near_m` on."""

    def __init__(self, polygons: Polygons, near_m: float, fine: tuple[int, int], outside: int = GRASS) -> None:
        self._polygons = polygons
        self._shown = np.flatnonzero(polygons.ranges_m > near_m)
        self._fine = fine  # supersampling, across and along
        self._outside = outside  # value beside all polygons
        self._close = self._shown
        self._middle = np.full(2, np.inf)
        self._reach_m = 0.0

    def paint(self, raster: Raster) -> Image:
        """(rows, columns) palette values."""
        fine_x, fine_y = self._fine
        canvas = np.full((fine_y * raster.rows, fine_x * raster.columns), self._outside, np.uint8)
        indices = self._candidates(raster)
        if len(indices):
            _fill(canvas, self._polygons, indices, raster.finer(fine_x, fine_y))
        while len(canvas) > fine_x * raster.rows:
            canvas = np.asarray(cv2.addWeighted(canvas[0::2], 0.5, canvas[1::2], 0.5, 0.0), np.uint8)
        return np.asarray(cv2.resize(canvas, (raster.columns, raster.rows), interpolation=cv2.INTER_AREA), np.uint8)

    def _candidates(self, raster: Raster) -> Indices:
        """The indices of the polygons that may touch a raster."""
        outline = raster.outline()
        middle = outline.mean(axis=0)
        reach = float(np.hypot(*(outline - middle).T).max())
        polygons = self._polygons
        if not np.hypot(*(middle - self._middle)) + reach <= self._reach_m:
            self._middle, self._reach_m = middle, reach + STEP_M
            x, y = (polygons.centres_m[self._shown] - middle).T
            self._close = self._shown[x * x + y * y < (self._reach_m + polygons.radii_m[self._shown]) ** 2]
        close = self._close
        sides = outline[[1, 2, 3, 0]] - outline
        normals = sides[:, ::-1] * (1.0, -1.0) / np.hypot(*sides.T)[:, None]
        normals *= np.sign(np.sum((outline - middle) * normals, axis=1))[:, None]  # outward
        outside = normals @ polygons.centres_m[close].T - np.sum(outline * normals, axis=1)[:, None]
        touching: Indices = close[outside.max(axis=0) < polygons.radii_m[close]]
        return touching


def _fill(canvas: Image, polygons: Polygons, indices: Indices, matrix: Floats) -> None:
    """Fill polygons, one call per strip."""
    counts = polygons.counts[indices]
    ends = np.cumsum(counts)
    starts = ends - counts
    vertices = np.repeat(polygons.starts[indices] - starts, counts) + np.arange(ends[-1])
    corners = _narrowed_vertices(polygons, vertices, matrix)
    inside = corners[:, 2] > NEAR_M
    if not inside.all():
        corners, counts = _clipped(corners, inside, starts, ends)
        indices, counts = indices[counts > 0], counts[counts > 0]
        ends = np.cumsum(counts)
    if not len(indices):
        return  # all of them lie behind the camera
    fixed, stops = _fixed(corners), ends.tolist()
    outlines = [fixed[a:b] for a, b in zip([0, *stops], stops, strict=False)]
    last = [*(np.flatnonzero(np.diff(polygons.runs[indices])) + 1).tolist(), len(indices)]
    first = 0
    for end, value in zip(last, polygons.values[indices[np.array(last) - 1]].tolist(), strict=True):
        cv2.fillPoly(canvas, outlines[first:end], value, cv2.LINE_8, SHIFT)
        first = end


def _narrowed_vertices(polygons: Polygons, vertices: Indices, matrix: Floats) -> Floats:
    """(P, 3) vertices in homogeneous canvas coordinates, with thin strips narrowed.

    OpenCV's filling adds half a pixel on either side, along the axis in which the edge is steeper."""
    points = _homogeneous(polygons.points_m.take(vertices, axis=0), matrix)
    thin = np.flatnonzero(polygons.thin[vertices] & (points[:, 2] > NEAR_M))
    if len(thin):
        index, here = polygons.narrowed[vertices[thin]], points.take(thin, axis=0)
        across_m, along_m = (of.take(index, axis=0) for of in (polygons.across_m, polygons.along_m))
        pixels = here[:, :2] / here[:, 2:]
        across, along = (
            (vector @ matrix[:, :2].T)[:, :2] - (vector @ matrix[2, :2])[:, None] * pixels
            for vector in (across_m, along_m)
        )  # on the canvas, times the depth
        turned = np.abs(across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0])
        steeper = np.maximum(np.abs(along[:, 0]), np.abs(along[:, 1]))
        share = 0.5 * here[:, 2] * steeper / np.maximum(turned, 1e-9)
        inward = np.minimum(share, 0.45)[:, None] * across_m
        points[thin] += inward @ matrix[:, :2].T
    return points


def _homogeneous(points: Floats, matrix: Floats) -> Floats:
    return np.asarray(points @ matrix[:, :2].T + matrix[:, 2])


def _fixed(corners: Floats) -> NDArray[np.int32]:
    """(..., 2) px of homogeneous corners in OpenCV's fixed-point format."""
    scale = 2.0**SHIFT / np.maximum(corners[..., 2:], NEAR_M)
    return np.rint(corners[..., :2] * scale).astype(np.int32)


def _clipped(corners: Floats, inside: Bools, starts: Indices, ends: Indices) -> tuple[Floats, Indices]:
    """(Q, 3) corners of polygons clipped at the near plane, and (n,) their counts, 0 where nothing is left."""
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = starts
    crossing = np.flatnonzero(inside != inside[following])
    here, there = corners[crossing], corners[following[crossing]]
    share = (NEAR_M - here[:, 2:]) / (there[:, 2:] - here[:, 2:])
    numbers = inside.astype(np.int64)  # points that each corner leaves: itself, and the cut of the side after it
    numbers[crossing] += 1
    places = np.cumsum(numbers) - numbers
    result = np.empty((numbers.sum(), 3))
    result[places[inside]] = corners[inside]
    result[places[crossing] + inside[crossing]] = here + share * (there - here)
    return result, np.add.reduceat(numbers, starts)


def _joined(parts: list[NDArray[Any]], dtype: type) -> NDArray[Any]:
    """(n,) one value per polygon of all batches."""
    return np.concatenate([np.empty(0, dtype), *parts], dtype=dtype)


def _pairs(parts: list[Floats]) -> Floats:
    """(n, 2) points or vectors of all batches."""
    return np.concatenate([np.empty((0, 2)), *parts])


def _circles(batch: Batch) -> tuple[Floats, Floats]:
    """(n, 2) and (n,) m, centres of the polygons, and the distance of the farthest vertex from each."""
    places = np.ascontiguousarray(batch.polygons_m.T)  # (2, V, n)
    centres = places.mean(axis=1)
    x, y = places - centres[:, None]
    return centres.T, np.sqrt((x * x + y * y).max(axis=0))


def _kept(batch: Batch) -> Bools:
    """(n, V) which vertices differ from the one before, by their place or in how they are narrowed."""
    kept = np.zeros(batch.polygons_m.shape[:2], bool)
    kept[:, 0] = True
    for values in (batch.polygons_m, _across(batch), _along(batch)) if batch.thin else (batch.polygons_m,):
        kept[:, 1:] |= (values[:, 1:, 0] != values[:, :-1, 0]) | (values[:, 1:, 1] != values[:, :-1, 1])
    return kept


def _begins_run(batch: Batch) -> Bools:
    """(n,) whether a polygon is the first of a strip."""
    begins = np.ones(len(batch.strips), bool)
    begins[1:] = batch.strips[1:] != batch.strips[:-1]
    return begins


def _across(batch: Batch) -> Floats:
    """(n, V, 2) m from each vertex of a thin strip to the opposite one."""
    return batch.polygons_m[:, ::-1] - batch.polygons_m


def _along(batch: Batch) -> Floats:
    """(n, V, 2) m along the side of a thin strip at each vertex."""
    half = batch.polygons_m.shape[1] // 2
    sides = (batch.polygons_m[:, :half], batch.polygons_m[:, half:])
    return np.concatenate([np.gradient(side, axis=1) for side in sides], axis=1)
