"""Rasterises the ground's polygons to palette values.

Polygons are filled without anti-aliasing on a supersampled canvas and averaged down: edges get their exact coverage.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.ground.paint import GRASS, Batch
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.view import NEAR_M, clip_near
from vpf_sim.types import Bools, Floats, Image

SHIFT = 4  # fractional bits of OpenCV's polygon coordinates
STEP_M = 12.0  # travel of the raster before nearby polygons are collected again

Indices = NDArray[np.int64]


class Polygons:
    """Polygons in drawing order with their vertices in one array.

    Repeated vertices, which pad short polygons, are left out.
    """

    def __init__(self, batches: list[Batch]) -> None:
        points = np.concatenate([batch.polygons_m.reshape(-1, 2) for batch in batches])
        across, along = (np.concatenate([of(batch) for batch in batches]) for of in (_across, _along))
        thin = np.concatenate([np.full(batch.polygons_m[..., 0].size, batch.thin) for batch in batches])
        counts = np.concatenate([np.full(len(b.values), b.polygons_m.shape[1]) for b in batches])
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        kept = _differ(points)
        narrowed = np.flatnonzero(thin)
        kept[narrowed] |= (_differ(across) | _differ(along))[narrowed]
        kept[starts] = True
        self.points_m, self.across_m, self.along_m, self.thin = points[kept], across[kept], along[kept], thin[kept]
        self.counts = np.add.reduceat(kept, starts, dtype=np.int64)
        self.starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        self.values = np.concatenate([batch.values for batch in batches])
        self.centres_m = np.concatenate([batch.centres_m for batch in batches])
        self.radii_m = np.concatenate([batch.radii_m for batch in batches])
        strips = np.concatenate([batch.strips for batch in batches])
        owner = np.repeat(np.arange(len(batches)), [len(batch.values) for batch in batches])
        self.runs = np.cumsum(np.diff(strips, prepend=-1).astype(bool) | np.diff(owner, prepend=-1).astype(bool))


class Surface:
    """Draws the ground's polygons on rasters near each other, for a level from the depth `near_m` on."""

    def __init__(self, batches: list[Batch], near_m: float, fine: tuple[int, int], outside: int = GRASS) -> None:
        self._batches = [batch for batch in batches if batch.range_m > near_m]
        self._fine = fine  # supersampling, across and along
        self._outside = outside  # value beside all polygons
        self._close: Polygons | None = None
        self._middle = np.full(2, np.inf)
        self._reach_m = 0.0

    def paint(self, raster: Raster) -> Image:
        """(rows, columns) palette values."""
        fine_x, fine_y = self._fine
        canvas = np.full((fine_y * raster.rows, fine_x * raster.columns), self._outside, np.uint8)
        polygons, indices = self._candidates(raster)
        if polygons is not None and len(indices):
            _fill(canvas, polygons, indices, raster.finer(fine_x, fine_y))
        while len(canvas) > fine_x * raster.rows:
            canvas = np.asarray(cv2.addWeighted(canvas[0::2], 0.5, canvas[1::2], 0.5, 0.0), np.uint8)
        return np.asarray(cv2.resize(canvas, (raster.columns, raster.rows), interpolation=cv2.INTER_AREA), np.uint8)

    def _candidates(self, raster: Raster) -> tuple[Polygons | None, Indices]:
        """The polygons near a raster (None without any), and the indices of those that may touch it."""
        outline = raster.outline()
        middle = outline.mean(axis=0)
        reach = float(np.hypot(*(outline - middle).T).max())
        if not np.hypot(*(middle - self._middle)) + reach <= self._reach_m:
            self._middle, self._reach_m = middle, reach + STEP_M
            near = [batch.near(middle, self._reach_m) for batch in self._batches]
            close = [batch for batch in near if len(batch.values)]
            self._close = Polygons(close) if close else None
        polygons = self._close
        if polygons is None:
            return None, np.empty(0, np.int64)
        sides = outline[[1, 2, 3, 0]] - outline
        normals = sides[:, ::-1] * (1.0, -1.0) / np.hypot(*sides.T)[:, None]
        normals *= np.sign(np.sum((outline - middle) * normals, axis=1))[:, None]  # outward
        outside = normals @ polygons.centres_m.T - np.sum(outline * normals, axis=1)[:, None]
        return polygons, np.flatnonzero(outside.max(axis=0) < polygons.radii_m)


def _fill(canvas: Image, polygons: Polygons, indices: Indices, matrix: Floats) -> None:
    """Fill polygons, one call per strip."""
    counts = polygons.counts[indices]
    ends = np.cumsum(counts)
    starts = ends - counts
    vertices = np.repeat(polygons.starts[indices] - starts, counts) + np.arange(ends[-1])
    corners = _narrowed_vertices(polygons, vertices, matrix)
    fixed = _fixed(corners)
    outlines = [fixed[a:b] for a, b in zip(starts.tolist(), ends.tolist(), strict=True)]
    ahead = corners[:, 2] > NEAR_M
    cut = np.flatnonzero(~np.logical_and.reduceat(ahead, starts))
    if len(cut):
        padded = starts[cut, None] + np.minimum(np.arange(counts.max()), counts[cut, None] - 1)
        for index, polygon in zip(cut.tolist(), _clipped(corners[padded], ahead[padded]), strict=True):
            outlines[index] = polygon
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
        index, here = vertices[thin], points.take(thin, axis=0)
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


def _clipped(polygons: Floats, inside: Bools) -> NDArray[np.int32]:
    """(n, W, 2) polygons (n, V, 3) clipped at the near plane; a point off the canvas if nothing is left."""
    beyond = inside.any(axis=1)
    parts = clip_near(polygons[beyond], inside[beyond])
    fixed = np.full((len(polygons), parts.shape[1], 2), -(9 << SHIFT), np.int32)
    fixed[beyond] = _fixed(parts)
    return fixed


def _differ(points: Floats) -> Bools:
    """(P,) whether points (P, 2) differ from the previous one."""
    x, y = np.diff(points, axis=0, prepend=np.nan).T
    return np.asarray((x != 0.0) | (y != 0.0))


def _across(batch: Batch) -> Floats:
    """(n V, 2) m from each vertex of a thin strip to the opposite one; zero for others."""
    polygons = batch.polygons_m
    return (polygons[:, ::-1] - polygons if batch.thin else np.zeros_like(polygons)).reshape(-1, 2)


def _along(batch: Batch) -> Floats:
    """(n V, 2) m along the side of a thin strip at each vertex; zero for others."""
    polygons = batch.polygons_m
    if not batch.thin:
        return np.zeros((polygons.shape[0] * polygons.shape[1], 2))
    half = polygons.shape[1] // 2
    sides = (polygons[:, :half], polygons[:, half:])
    return np.concatenate([np.gradient(side, axis=1) for side in sides], axis=1).reshape(-1, 2)
