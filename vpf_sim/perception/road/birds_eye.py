"""The road seen from above: a patch of the frame laid out in metres, and the thin bright ridges in it."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from vpf_sim.geometry import distort, ground_from_pixels, project
from vpf_sim.types import Bools, Camera, Floats, Image, Integers


@dataclass(frozen=True, slots=True)
class Patch:
    """A rectangle of road ahead, in vehicle axes."""

    near_m: float  # from the pose
    far_m: float
    half_width_m: float
    row_m: float  # along the road, at least
    column_m: float  # across


class BirdsEye:
    """Lays one camera's frames out as a patch of flat road, by one look-up; lens distortion is part of it.

    Rows go away from the vehicle, columns to the right. Each row is one row of pixels, never a mix of two: a slanted
    line would come apart in the mix. So rows are `row_m` apart where pixels are fine, and further apart elsewhere.
    """

    def __init__(self, camera: Camera, patch: Patch) -> None:
        self.camera = camera
        self.forward_m = rows_ahead(camera, patch)  # (rows,) from the pose
        self.length_m: Floats = np.gradient(self.forward_m)  # (rows,) of road that a row stands for
        self.right_m: Floats = np.arange(-patch.half_width_m, patch.half_width_m + 1e-9, patch.column_m)  # (columns,)
        self.column_m = patch.column_m
        self._maps, self.visible = lookup(camera, self.forward_m, self.right_m)

    def warp(self, image: Image) -> Image:
        """(rows, columns[, 3]) the patch of an (H, W[, 3]) frame, 0 where it does not reach."""
        laid = cv2.remap(image, *self._maps, interpolation=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return laid.astype(np.uint8, copy=False)

    def columns(self, right_m: Floats, reached: Bools) -> tuple[Integers, Bools]:
        """The columns in which places right of the pose (..., rows), those `reached`, lie, and whether they do in the
        patch; 0 where not."""
        places = np.rint((right_m - self.right_m[0]) / self.column_m)
        inside = reached & (places >= 0) & (places < len(self.right_m))
        return np.where(inside, places, 0).astype(np.intp), inside

    def nearest(self, forward_m: Floats, right_m: Floats) -> tuple[Integers, Integers]:
        """The rows (R,) and columns (..., R) nearest to places ahead (R,) and right (..., R) of the pose."""
        rows = np.rint((forward_m - self.forward_m[0]) / (self.forward_m[1] - self.forward_m[0]))
        columns = np.rint((right_m - self.right_m[0]) / self.column_m)
        rows, columns = np.clip(rows, 0, len(self.forward_m) - 1), np.clip(columns, 0, len(self.right_m) - 1)
        return rows.astype(np.intp), columns.astype(np.intp)


def lookup(camera: Camera, forward_m: Floats, right_m: Floats) -> tuple[tuple[Any, Any], Bools]:
    """Maps for `cv2.remap` that lay a frame out as flat road, and (rows, columns) which places the frame shows."""
    forward, right = np.meshgrid(forward_m, right_m, indexing="ij")
    pixels = distort(camera, project(camera, np.stack([forward, right, np.zeros_like(right)], axis=-1)))
    x, y = np.nan_to_num(pixels, nan=-10.0).astype(np.float32).transpose(2, 0, 1)
    visible: Bools = (x >= 0.0) & (x <= camera.width_px - 1) & (y >= 0.0) & (y <= camera.height_px - 1)
    exact, table = cv2.convertMaps(np.where(visible, x, -10.0), np.where(visible, y, -10.0), cv2.CV_16SC2)
    return (exact, table), visible


def rows_ahead(camera: Camera, patch: Patch) -> Floats:
    """(rows,) m from the pose, where rows of pixels see the road, nearest first and at least `row_m` apart."""
    rows = np.arange(camera.height_px - 1, -1, -1, dtype=float)
    forward = ground_from_pixels(camera, np.stack([np.full_like(rows, camera.cx_px), rows], axis=-1))[:, 0]
    chosen: list[float] = []
    for place in forward[np.isfinite(forward) & (forward >= patch.near_m) & (forward <= patch.far_m)].tolist():
        if not chosen or place >= chosen[-1] + patch.row_m:
            chosen.append(place)
    return np.array(chosen)


def ridge(patch: Image, reach_columns: int) -> Image:
    """(rows, columns) how much brighter each place is than both places `reach_columns` to its sides, >= 0.

    min(centre - left, centre - right): an edge between two surfaces gives nothing, a painted line its contrast.
    """
    result = np.zeros_like(patch)
    centre = patch[:, reach_columns:-reach_columns]
    left, right = patch[:, : -2 * reach_columns], patch[:, 2 * reach_columns :]
    contrast = cv2.min(cv2.subtract(centre, left), cv2.subtract(centre, right))
    result[:, reach_columns:-reach_columns] = cv2.GaussianBlur(contrast, (3, 1), 0.8)
    return result
