"""The painted ground in the picture, one channel of palette values.

Polygons are filled without anti-aliasing on canvases several times as fine as the picture and averaged down, which
gives every edge its exact coverage: 2 x 2 near the car, 4 x 8 far away, where one row of pixels spans many metres.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from vpf_sim.envs.camera.grain import ground_top
from vpf_sim.envs.camera.paint import GRASS, Batch
from vpf_sim.envs.camera.view import NEAR_M, View, clip_near

from vpf_sim.types import Camera, Floats, Image

FAR_ROWS = 32  # rows under the horizon that are drawn on the finer canvas
SHIFT = 4  # fractional bits of OpenCV's polygon coordinates

Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Canvas:
    """A stretch of rows, drawn several times as fine."""

    pixels: NDArray[np.uint8]
    first: int  # row of the picture
    rows: int
    fine_x: int
    fine_y: int

    def fixed(self, pixels: Floats) -> NDArray[np.int32]:
        """Pixels of the picture in OpenCV's fixed-point coordinates of this canvas."""
        scale = np.array([self.fine_x, self.fine_y], float) * 2**SHIFT
        offset = np.array([0.5 * self.fine_x - 0.5, (0.5 - self.first) * self.fine_y - 0.5]) * 2**SHIFT
        return np.asarray(np.rint(pixels * scale + offset), np.int32)


class Polygons:
    """All polygons of a road in the order in which they are laid, their vertices in one array."""

    def __init__(self, batches: list[Batch]) -> None:
        self.points_m = np.concatenate([batch.polygons_m.reshape(-1, 2) for batch in batches])
        self.across_m = np.concatenate([_across(batch).reshape(-1, 2) for batch in batches])
        self.counts = np.concatenate([np.full(len(b.values), b.polygons_m.shape[1]) for b in batches])
        self.starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        self.values = np.concatenate([batch.values for batch in batches])
        self.centres_m = np.concatenate([batch.centres_m for batch in batches])
        self.radii_m = np.concatenate([batch.radii_m for batch in batches])
        self.ranges_m = np.concatenate([np.full(len(batch.values), batch.range_m) for batch in batches])
        strips = np.concatenate([batch.strips for batch in batches])
        owner = np.repeat(np.arange(len(batches)), [len(batch.values) for batch in batches])
        self.runs = np.cumsum(np.diff(strips, prepend=-1).astype(bool) | np.diff(owner, prepend=-1).astype(bool))

    def in_view(self, view: View) -> Indices:
        """Which of them may be in the picture."""
        relative = self.centres_m - view.centre[:2]
        c, s = np.cos(view.yaw_rad), np.sin(view.yaw_rad)
        ahead = relative[:, 0] * c + relative[:, 1] * s
        near = np.flatnonzero((ahead > -self.radii_m) & (ahead < self.ranges_m))
        aside = relative[near, 1] * c - relative[near, 0] * s
        slope = 0.55 * view.camera.width_px / view.camera.fx_px
        seen = np.abs(aside) < slope * np.abs(ahead[near]) + (1.0 + slope) * self.radii_m[near]
        return np.asarray(near[seen], np.int64)


class Surface:
    """Draws what is painted on the ground."""

    def __init__(self, camera: Camera, batches: list[Batch]) -> None:
        self._camera = camera
        self._polygons = Polygons(batches)
        top = ground_top(camera)
        far = min(FAR_ROWS, camera.height_px - top)
        near = camera.height_px - top - far
        width = camera.width_px
        self._far = Canvas(np.empty((8 * far, 4 * width), np.uint8), top, far, 4, 8)
        self._near = Canvas(np.empty((2 * near, 2 * width), np.uint8), top + far, near, 2, 2)
        self._picture = np.empty((far + near, width), np.uint8)

    def draw(self, view: View) -> Image:
        """(rows, W) palette values from the top of the ground down; valid until the next call."""
        self._far.pixels[:] = GRASS
        self._near.pixels[:] = GRASS
        seen = self._polygons.in_view(view)
        if len(seen):
            self._fill(seen, self._projected(view, seen))
        far = _halved(_halved(self._far.pixels))
        cv2.addWeighted(far[0::2], 0.5, far[1::2], 0.5, 0.0, self._picture[: self._far.rows])
        self._picture[self._far.rows :] = _halved(self._near.pixels)
        return self._picture

    def _projected(self, view: View, seen: Indices) -> "Projected":
        """The polygons `seen` in pixels, cut at the near plane."""
        counts = self._polygons.counts[seen]
        ends = np.cumsum(counts)
        starts = ends - counts
        points = self._camera_axes(view, np.repeat(self._polygons.starts[seen] - starts, counts) + np.arange(ends[-1]))
        cut = np.flatnonzero(np.minimum.reduceat(points[:, 2], starts) <= NEAR_M)
        points[:, 2] = np.maximum(points[:, 2], NEAR_M)  # those polygons come again below, as they are cut
        pixels = view.pixels(points)
        low, high = (extreme.reduceat(pixels[:, 1], starts) for extreme in (np.minimum, np.maximum))
        clipped = np.empty((0, 1, 2))
        if len(cut):
            most = int(counts[cut].max())
            steps = np.minimum(np.arange(most), counts[cut][:, None] - 1)
            corners = self._camera_axes(view, (self._polygons.starts[seen[cut]][:, None] + steps).ravel())
            corners = corners.reshape(len(cut), most, 3)
            inside = corners[..., 2] > NEAR_M
            behind = ~inside.any(axis=1)
            corners[behind, :, 2], inside[behind] = 1.0, True
            clipped = view.pixels(clip_near(corners, inside))
            low[cut] = np.where(behind, np.inf, clipped[..., 1].min(axis=1))
            high[cut] = np.where(behind, -np.inf, clipped[..., 1].max(axis=1))
        place = np.full(len(seen), -1)
        place[cut] = np.arange(len(cut))
        return Projected(pixels, starts, ends, clipped, place, low, high)

    def _camera_axes(self, view: View, vertices: Indices) -> Floats:
        """(P, 3) vertices in camera axes, lines narrowed by what OpenCV's filling adds: half a pixel of the canvas."""
        ground = view.axes[:, :2]
        points: Floats = (self._polygons.points_m[vertices] - view.centre[:2]) @ ground.T
        points -= view.centre[2] * view.axes[:, 2]
        across = self._polygons.across_m[vertices] @ ground[0]
        depth = np.abs(points[:, 2])
        border_m = self._camera.fy_px * self._camera.height_m / FAR_ROWS
        inset = np.where(depth < border_m, 0.25, 0.125) * depth / self._camera.fx_px
        points[:, 0] += np.copysign(np.minimum(inset, 0.45 * np.abs(across)), across)
        return points

    def _fill(self, seen: Indices, projected: "Projected") -> None:
        """Fill the polygons, those of one run in one call."""
        border = self._near.first
        for canvas, shown in (
            (self._far, projected.low < border),
            (self._near, projected.high > border - 1.0),
        ):
            index = np.flatnonzero(shown)
            fixed, cut = canvas.fixed(projected.pixels), canvas.fixed(projected.clipped)
            polygons = [
                cut[k] if k >= 0 else fixed[a:b]
                for a, b, k in zip(
                    projected.starts[index].tolist(),
                    projected.ends[index].tolist(),
                    projected.place[index].tolist(),
                    strict=True,
                )
            ]
            runs = self._polygons.runs[seen[index]]
            last = [*(np.flatnonzero(np.diff(runs)) + 1).tolist(), len(index)]
            first = 0
            for end, value in zip(last, self._polygons.values[seen[index[np.array(last) - 1]]].tolist(), strict=True):
                cv2.fillPoly(canvas.pixels, polygons[first:end], value, cv2.LINE_8, SHIFT)
                first = end


@dataclass(frozen=True, slots=True)
class Projected:
    """Polygons in pixels; those that reach behind the near plane once more, as it cuts them."""

    pixels: Floats  # (P, 2) vertices of all
    starts: Indices  # (n,) where the vertices of each begin
    ends: Indices  # (n,)
    clipped: Floats  # (m, V, 2)
    place: Indices  # (n,) in `clipped`, or -1
    low: Floats  # (n,) topmost row
    high: Floats  # (n,) lowest row


def _across(batch: Batch) -> Floats:
    """(n, V, 2) m from each vertex of a line to the one beside it, 0 for other polygons."""
    return batch.polygons_m[:, ::-1] - batch.polygons_m if batch.thin else np.zeros_like(batch.polygons_m)


def _halved(picture: Image) -> Image:
    height, width = picture.shape
    return np.asarray(cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8)
