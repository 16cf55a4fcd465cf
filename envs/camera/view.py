"""The camera in one frame: projects world points to camera axes and pixels, and clips polygons.

World points are (x, y, up) m with up counted from the road; camera axes are (right, down, depth) m.
"""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Camera, Floats

NEAR_M = 0.5  # near plane; the lowest ray of the default camera meets the road at 1.87 m

Pixels = NDArray[np.float64]  # (..., 2)


@dataclass(frozen=True, slots=True)
class View:
    """One camera at one pose."""

    camera: Camera
    centre: Floats  # (3,) m, the camera's centre in the world
    yaw_rad: float
    axes: Floats  # (3, 3) rows: right, down, depth in world coordinates
    projection: Floats  # (3, 4) from points (x, y, up, 1) m to (column, row, 1) times their depth

    @classmethod
    def of(cls, camera: Camera, centre: Floats, yaw_rad: float, axes: Floats) -> "View":
        """The view of a camera with a centre and axes."""
        scale = np.array(((camera.fx_px, 0.0, camera.cx_px), (0.0, camera.fy_px, camera.cy_px), (0.0, 0.0, 1.0)))
        projection = np.empty((3, 4))
        np.matmul(scale, axes, out=projection[:, :3])
        projection[:, 3] = projection[:, :3] @ -centre
        return cls(camera, centre, yaw_rad, axes, projection)

    @classmethod
    def at(cls, camera: Camera, position: Floats, yaw_rad: float) -> "View":
        """The view of a camera on a vehicle at the pose `position`, `yaw_rad`."""
        c, s = cos(yaw_rad), sin(yaw_rad)
        pitch_c, pitch_s = cos(camera.pitch_rad), sin(camera.pitch_rad)
        x, y = float(position[0]), float(position[1])
        centre = np.array((x + camera.forward_m * c, y + camera.forward_m * s, camera.height_m))
        right = (-s, c, 0.0)
        down = (-pitch_s * c, -pitch_s * s, -pitch_c)
        depth = (pitch_c * c, pitch_c * s, -pitch_s)
        return cls.of(camera, centre, float(yaw_rad), np.array((right, down, depth)))

    def camera_axes(self, points: Floats) -> Floats:
        """(..., 3) world points in camera axes."""
        relative: Floats = (points - self.centre) @ self.axes.T
        return relative

    def pixels(self, points: Floats) -> Pixels:
        """(..., 2) px of (..., 3) points in camera axes with positive depth."""
        camera = self.camera
        flat: Pixels = points[..., :2] / points[..., 2:]
        flat *= (camera.fx_px, camera.fy_px)
        flat += (camera.cx_px, camera.cy_px)
        return flat

    def ground_homography(self) -> Floats:
        """(3, 3) from pixels (x, y, 1) to homogeneous points of the road.

        The last component is the camera's height over the depth, > 0 below the horizon.
        """
        image = np.linalg.inv(self.projection[:, (0, 1, 3)])
        return np.asarray(self.camera.height_m * image)


def clip_near(polygons: Floats, inside: Bools, near_m: float = NEAR_M) -> Floats:
    """(n, W, 3) polygons (n, V, 3) in camera axes, clipped to beyond the depth `near_m` (Sutherland and Hodgman 1974).

    W is the largest vertex count; the last vertex of other polygons is repeated.

    `inside` is (n, V): the vertices beyond, at least one per polygon.
    """
    cyclic = [*range(1, inside.shape[1]), 0]
    following = polygons[:, cyclic]
    crossing = inside != inside[:, cyclic]
    depth, next_depth = polygons[..., 2], following[..., 2]
    share = (near_m - depth) / np.where(crossing, next_depth - depth, 1.0)
    cut = polygons + share[..., None] * (following - polygons)
    count, vertices = inside.shape
    points = np.stack([polygons, cut], axis=2).reshape(count, 2 * vertices, 3)
    kept = np.stack([inside, crossing], axis=2).reshape(count, 2 * vertices)
    numbers = kept.sum(axis=1)
    index = np.argsort(~kept, axis=1, kind="stable")
    index = np.take_along_axis(index, np.minimum(np.arange(numbers.max(initial=1)), numbers[:, None] - 1), axis=1)
    return np.take_along_axis(points, index[..., None], axis=1)
