"""Where the camera is in one frame: world points into camera axes and pixels, polygons clipped to what lies in front.

World points are (x, y, up) m with up counted from the road; camera axes are (right, down, depth) m.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Camera, Floats

NEAR_M = 0.5  # nothing nearer than this plane is drawn; the lowest ray of the default camera meets the road at 1.87 m

Pixels = NDArray[np.float64]  # (..., 2)


@dataclass(frozen=True, slots=True)
class View:
    """One camera at one pose."""

    camera: Camera
    centre: Floats  # (3,) m, the camera's centre in the world
    yaw_rad: float
    axes: Floats  # (3, 3) rows: right, down, depth in world coordinates

    @classmethod
    def at(cls, camera: Camera, position: Floats, yaw_rad: float) -> "View":
        """The view of a camera on a vehicle whose pose is `position`, `yaw_rad`."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        pitch_c, pitch_s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
        centre = np.array([position[0] + camera.forward_m * c, position[1] + camera.forward_m * s, camera.height_m])
        right = (-s, c, 0.0)
        down = (-pitch_s * c, -pitch_s * s, -pitch_c)
        depth = (pitch_c * c, pitch_c * s, -pitch_s)
        return cls(camera, centre, float(yaw_rad), np.array([right, down, depth]))

    def camera_axes(self, points: Floats) -> Floats:
        """(..., 3) world points in camera axes."""
        relative: Floats = (points - self.centre) @ self.axes.T
        return relative

    def pixels(self, points: Floats) -> Pixels:
        """(..., 2) px of (..., 3) points in camera axes that lie in front."""
        camera = self.camera
        flat: Pixels = points[..., :2] / points[..., 2:]
        flat *= (camera.fx_px, camera.fy_px)
        flat += (camera.cx_px, camera.cy_px)
        return flat

    def ground_homography(self) -> Floats:
        """(3, 3) matrix from pixels (x, y, 1) to homogeneous world points of the road; the last component is > 0 below
        the horizon."""
        camera = self.camera
        back = np.array(
            [
                [1 / camera.fx_px, 0, -camera.cx_px / camera.fx_px],
                [0, 1 / camera.fy_px, -camera.cy_px / camera.fy_px],
                [0, 0, 1.0],
            ]
        )
        ray = self.axes.T @ back  # world direction of a pixel's ray
        fall = -ray[2]
        return np.stack(
            [camera.height_m * ray[0] + self.centre[0] * fall, camera.height_m * ray[1] + self.centre[1] * fall, fall]
        )


def clip_near(polygons: Floats, inside: Bools) -> Floats:
    """(n, 2 V, 3) those parts of (n, V, 3) polygons in camera axes that lie beyond the near plane (Sutherland and
    Hodgman 1974); vertices are repeated to fill up. `inside` is (n, V): which vertices lie beyond, at least one each.
    """
    cyclic = [*range(1, inside.shape[1]), 0]
    following = polygons[:, cyclic]
    crossing = inside != inside[:, cyclic]
    depth, next_depth = polygons[..., 2], following[..., 2]
    share = (NEAR_M - depth) / np.where(crossing, next_depth - depth, 1.0)
    cut = polygons + share[..., None] * (following - polygons)
    count, vertices = inside.shape
    points = np.stack([polygons, cut], axis=2).reshape(count, 2 * vertices, 3)
    kept = np.stack([inside, crossing], axis=2).reshape(count, 2 * vertices)
    index = np.maximum.accumulate(np.where(kept, np.arange(2 * vertices), -1), axis=1)
    index = np.where(index < 0, kept.argmax(axis=1)[:, None], index)
    return np.take_along_axis(points, index[..., None], axis=1)
