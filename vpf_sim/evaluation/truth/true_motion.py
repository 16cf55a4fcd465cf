"""How tracks really moved over several frames, from the truth of the last frame and what the poses were before."""

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera import Renderer
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

OFF_PX = 1.0  # a track farther from the truth is off
LONGEST_TTC_S = 10.0  # of the points whose time to contact is scored
NEIGHBOURS = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)]
Truth = dict[str, NDArray[np.generic]]


@dataclass(frozen=True, slots=True)
class Shot:
    """One frame of a drive and its renderer, which tells the truth of it until the next is taken."""

    index: int
    image: Image  # (H, W, 3) RGB
    pose: Floats  # (3,) x m, y m, yaw rad
    renderer: Renderer


@dataclass(frozen=True, slots=True)
class Instant:
    """Where the camera and the bodies were at one frame."""

    view: View
    bodies: list[Floats]  # (3,) x m, y m, heading rad of each


class TrueMotion:
    """Remembers the poses of the last frames.

    The scene is rigid but for its bodies, which move as a whole: the point that a pixel shows now, by its depth, was
    then at a known place, and was seen where that projects to. The lens is a pinhole.
    """

    def __init__(self, camera: Camera, frames: int) -> None:
        self._camera = camera
        self._instants: deque[Instant] = deque(maxlen=frames + 1)  # newest first

    def note(self, shot: Shot) -> None:
        """Remember a frame; every one in its order."""
        bodies = [np.array([*body.position, body.heading], float) for body in shot.renderer.objects]
        self._instants.appendleft(Instant(View.at(self._camera, shot.pose[:2], shot.pose[2]), bodies))

    def errors_px(self, points_px: Floats, displacement_px: Floats, frames: NDArray[np.int64], truth: Truth) -> Floats:
        """(N,) px by which displacements (N, 2) of points (N, 2) over `frames` (N,) miss the true ones.

        `truth` has `depth` and `instance` of the frame noted last. Of the nine pixels about a point the one that agrees
        best counts, as a corner on an outline may belong to either side.
        """
        errors = np.full(len(points_px), np.inf)
        for back in np.unique(frames):
            chosen = frames == back
            for neighbour in NEIGHBOURS:
                true_px = self._displacement(pixels(points_px[chosen] + neighbour, self._camera), int(back), truth)
                errors[chosen] = np.minimum(errors[chosen], np.hypot(*(displacement_px[chosen] - true_px).T))
        return errors

    def ttc_s(self, points_px: Floats, gap_s: float, truth: Truth) -> Floats:
        """(N,) s, depth / closing speed of what is seen at points (N, 2); inf where the gap does not close.

        The closing speed is that of the last `gap_s` seconds, one frame.
        """
        then, depth = self._earlier(pixels(points_px, self._camera), 1, truth)
        closed_m = then[:, 2] - depth
        found: Floats = np.divide(depth * gap_s, closed_m, out=np.full(len(depth), np.inf), where=closed_m > 0.0)
        return found

    def _displacement(self, pixel: NDArray[np.intp], back: int, truth: Truth) -> Floats:
        """(N, 2) px that what is seen at pixels (N, 2) moved in the last `back` frames."""
        then, _ = self._earlier(pixel, back, truth)
        displacement: Floats = pixel - self._instants[back].view.pixels(then)
        return displacement

    def _earlier(self, pixel: NDArray[np.intp], back: int, truth: Truth) -> tuple[Floats, Floats]:
        """(N, 3) where what is seen at pixels (N, 2) was `back` frames ago, in the camera's axes; (N,) its depth now.

        Of what has no end it is a direction.
        """
        now, then = self._instants[0], self._instants[back]
        column, row = pixel.T
        depth, instance = truth["depth"][row, column].astype(np.float64), truth["instance"][row, column]
        camera = self._camera
        ray = np.stack([(column - camera.cx_px) / camera.fx_px, (row - camera.cy_px) / camera.fy_px, np.ones(len(row))])
        direction = ray.T @ now.view.axes
        endless = np.isinf(depth)
        world = now.view.centre + direction * np.where(endless, 0.0, depth)[:, None]
        for body in np.unique(instance[instance > 0]):
            moved = instance == body
            world[moved] = carried(world[moved], now.bodies[body - 1], then.bodies[body - 1])
        seen: Floats = np.where(endless[:, None], direction @ then.view.axes.T, then.view.camera_axes(world))
        return seen, depth


def pixels(points_px: Floats, camera: Camera) -> NDArray[np.intp]:
    """(N, 2) the pixels, column and row, that points (N, 2) lie in; at the frame's edge the nearest."""
    return np.clip(np.rint(points_px), 0, [camera.width_px - 1, camera.height_px - 1]).astype(np.intp)


def at(values: NDArray[np.generic], points_px: Floats, camera: Camera) -> NDArray[Any]:
    """(N,) the values of an array (H, W) at points (N, 2)."""
    column, row = pixels(points_px, camera).T
    found: NDArray[Any] = values[row, column]
    return found


def ttc_errors(seen_s: Floats, true_s: Floats) -> Floats:
    """(M,) |TTC - true| / true of those of N points whose true time is at most LONGEST_TTC_S; 1 where none was seen."""
    near = true_s <= LONGEST_TTC_S
    with np.errstate(invalid="ignore"):
        errors = np.abs(seen_s[near] - true_s[near]) / true_s[near]
    return np.where(np.isfinite(seen_s[near]), errors, 1.0)


def carried(points: Floats, now: Floats, then: Floats) -> Floats:
    """Where points (N, 3) of a body at pose `now` were when its pose (x, y, heading) was `then`."""
    turn = then[2] - now[2]
    c, s = np.cos(turn), np.sin(turn)
    flat = (points[:, :2] - now[:2]) @ np.array([[c, s], [-s, c]]) + then[:2]
    return np.column_stack([flat, points[:, 2]])
