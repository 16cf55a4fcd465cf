"""True motion of tracked points over several frames, from the last frame's ground truth and earlier poses."""

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from highway_env.vehicle.objects import RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.camera import Renderer
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

OFF_PX = 1.0  # a track with a larger error counts as off
LONGEST_TTC_S = 10.0  # points with a longer true time to contact are not scored
NEIGHBOURS = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)]
Truth = dict[str, NDArray[np.generic]]


@dataclass(frozen=True, slots=True)
class Shot:
    """One frame of a drive and its renderer, which has the frame's ground truth until the next frame."""

    index: int
    image: Image  # (H, W, 3) RGB
    pose: Floats  # (3,) x m, y m, yaw rad
    renderer: Renderer


@dataclass(frozen=True, slots=True)
class Instant:
    """Poses of the camera and the objects at one frame."""

    view: View
    poses: dict[RoadObject, Floats]  # (3,) x m, y m, heading rad, in the order of the truth's instances


class TrueMotion:
    """Keeps the poses of the last frames and computes true displacements and times to contact.

    The scene is static except for rigid objects: a pixel's depth gives its point, the poses give the point's earlier
    position, and that is projected into the earlier frame. The lens is a pinhole.
    """

    def __init__(self, camera: Camera, frames: int) -> None:
        self._camera = camera
        self._instants: deque[Instant] = deque(maxlen=frames + 1)  # newest first

    def add(self, shot: Shot) -> None:
        """Add a frame; call for every frame in order."""
        poses = {obj: np.array([*obj.position, obj.heading], float) for obj in shot.renderer.objects}
        self._instants.appendleft(Instant(View.at(self._camera, shot.pose[:2], shot.pose[2]), poses))

    def errors_px(self, points_px: Floats, displacement_px: Floats, frames: NDArray[np.int64], truth: Truth) -> Floats:
        """(N,) px, errors of displacements (N, 2) of points (N, 2) over `frames` (N,).

        `truth` has `depth` and `instance` of the last frame. The best of the nine pixels around a point counts, since a
        corner on an outline may belong to either side.
        """
        errors = np.full(len(points_px), np.inf)
        for back in np.unique(frames):
            chosen = frames == back
            for neighbour in NEIGHBOURS:
                true_px = self._displacement(pixels(points_px[chosen] + neighbour, self._camera), int(back), truth)
                errors[chosen] = np.minimum(errors[chosen], np.hypot(*(displacement_px[chosen] - true_px).T))
        return errors

    def ttc_s(self, points_px: Floats, gap_s: float, truth: Truth) -> Floats:
        """(N,) s, depth / closing speed at points (N, 2); inf where the depth does not decrease.

        The closing speed is the mean over the last frame, `gap_s`.
        """
        then, depth = self._earlier(pixels(points_px, self._camera), 1, truth)
        closed_m = then[:, 2] - depth
        found: Floats = np.divide(depth * gap_s, closed_m, out=np.full(len(depth), np.inf), where=closed_m > 0.0)
        return found

    def _displacement(self, pixel: NDArray[np.intp], back: int, truth: Truth) -> Floats:
        """(N, 2) px, displacement over the last `back` frames of the scene points at pixels (N, 2)."""
        then, _ = self._earlier(pixel, back, truth)
        displacement: Floats = pixel - self._instants[back].view.pixels(then)
        return displacement

    def _earlier(self, pixel: NDArray[np.intp], back: int, truth: Truth) -> tuple[Floats, Floats]:
        """(N, 3) positions `back` frames ago, camera axes, of the scene points at pixels (N, 2); (N,) their depth now.

        A direction for points at infinity.
        """
        now, then = self._instants[0], self._instants[back]
        column, row = pixel.T
        depth, instance = truth["depth"][row, column].astype(np.float64), truth["instance"][row, column]
        camera = self._camera
        ray = np.stack([(column - camera.cx_px) / camera.fx_px, (row - camera.cy_px) / camera.fy_px, np.ones(len(row))])
        direction = ray.T @ now.view.axes
        endless = np.isinf(depth)
        world = now.view.centre + direction * np.where(endless, 0.0, depth)[:, None]
        objects = list(now.poses)
        for number in np.unique(instance[instance > 0]).tolist():
            moved, obj = instance == number, objects[number - 1]
            # who was not there yet counts as standing
            world[moved] = moved_points(world[moved], now.poses[obj], then.poses.get(obj, now.poses[obj]))
        seen: Floats = np.where(endless[:, None], direction @ then.view.axes.T, then.view.camera_axes(world))
        return seen, depth


def pixels(points_px: Floats, camera: Camera) -> NDArray[np.intp]:
    """(N, 2) pixels (column, row) of points (N, 2), clipped to the frame."""
    return np.clip(np.rint(points_px), 0, [camera.width_px - 1, camera.height_px - 1]).astype(np.intp)


def at(values: NDArray[np.generic], points_px: Floats, camera: Camera) -> NDArray[Any]:
    """(N,) the values of an array (H, W) at points (N, 2)."""
    column, row = pixels(points_px, camera).T
    found: NDArray[Any] = values[row, column]
    return found


def ttc_errors(estimated_s: Floats, true_s: Floats) -> Floats:
    """(M,) |TTC - true| / true of the points whose true time is at most LONGEST_TTC_S; 1 without an estimate."""
    near = true_s <= LONGEST_TTC_S
    with np.errstate(invalid="ignore"):
        errors = np.abs(estimated_s[near] - true_s[near]) / true_s[near]
    return np.where(np.isfinite(estimated_s[near]), errors, 1.0)


def moved_points(points: Floats, now: Floats, then: Floats) -> Floats:
    """(N, 3) positions of an object's points at its pose `then` (x, y, heading), given them at pose `now`."""
    turn = then[2] - now[2]
    c, s = np.cos(turn), np.sin(turn)
    flat = (points[:, :2] - now[:2]) @ np.array([[c, s], [-s, c]]) + then[:2]
    return np.column_stack([flat, points[:, 2]])
