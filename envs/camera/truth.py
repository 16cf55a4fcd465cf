"""What the picture should say, from the geometry alone: depth, flow, focus of expansion, time to contact, instances.

All of it belongs to the pixels of frame k and to the motion from frame k-1 to k; the first frame counts as standing.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.painter import SHIFT, Drawing, Sprite, bounding_box
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Bools, Floats

Singles = NDArray[np.float32]
STANDING_M = 1e-6  # a camera that moved less stands


@dataclass(frozen=True, slots=True)
class Motion:
    """How a rigid thing got from frame k-1 to k: the world point p now was at `turn` p + `shift` then."""

    turn: Floats  # (3, 3)
    shift: Floats  # (3,) m

    @classmethod
    def of_body(cls, before: Floats, now: Floats) -> "Motion":
        """The motion between two poses (x, y, heading)."""
        c, s = np.cos(before[2] - now[2]), np.sin(before[2] - now[2])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        shift = np.array([*before[:2], 0.0]) - turn @ np.array([*now[:2], 0.0])
        return cls(turn, shift)


STILL = Motion(np.eye(3), np.zeros(3))


@dataclass(frozen=True, slots=True)
class Drawn:
    """One thing of the frame as it was drawn, in painter's order."""

    drawing: Drawing | Sprite
    instance: int  # -1 scenery, i + 1 the body i
    motion: Motion


@dataclass(frozen=True, slots=True)
class Moment:
    """The two views between which the truth lies."""

    now: View
    before: View
    gap_s: float


def truth(names: tuple[str, ...], moment: Moment, drawn: list[Drawn]) -> dict[str, NDArray[np.generic]]:
    """The arrays asked for.

    depth: (H, W) float32 m along the optical axis, inf in the sky. flow: (H, W, 2) float32 px from k-1 to k, bodies'
    own motion included; the sky's is that of the rotation. foe: (2,) float64 px, the image of the translation of the
    camera's centre, nan when it stands. ttc: (H, W) float32 s, depth / closing speed along the optical axis, inf where
    the gap does not close. instance: (H, W) int32, 0 ground and sky, -1 scenery, i + 1 the body i of
    `Renderer.bodies`. hidden: (H, W) bool, what the weather hides.
    """
    result: dict[str, NDArray[np.generic]] = {}
    if "foe" in names:
        result["foe"] = focus_of_expansion(moment)
    if not set(names) - {"foe"}:
        return result
    depth, instance, owner = _rasterised(moment.now, drawn)
    if "depth" in names:
        result["depth"] = depth.astype(np.float32)
    if "instance" in names:
        result["instance"] = instance
    if "hidden" in names:
        result["hidden"] = np.zeros(depth.shape, bool)
    if "flow" in names or "ttc" in names:
        flow, ttc = _motion(moment, drawn, depth, owner)
        result.update({name: array for name, array in (("flow", flow), ("ttc", ttc)) if name in names})
    return result


def focus_of_expansion(moment: Moment) -> Floats:
    """(2,) px, the image in frame k of the direction in which the camera's centre moved; nan when it stands."""
    step = moment.now.axes @ (moment.now.centre - moment.before.centre)
    if abs(step[2]) < STANDING_M:
        return np.full(2, np.nan)
    return moment.now.pixels(step)


def _rays(view: View) -> Floats:
    """(H, W, 3) the ray of each pixel in camera axes, with depth 1."""
    camera = view.camera
    x = (np.arange(camera.width_px) - camera.cx_px) / camera.fx_px
    y = (np.arange(camera.height_px) - camera.cy_px) / camera.fy_px
    grid = np.meshgrid(x, y)
    return np.stack([*grid, np.ones_like(grid[0])], axis=-1)


def _rasterised(view: View, drawn: list[Drawn]) -> tuple[Floats, NDArray[np.int32], NDArray[np.int32]]:
    """Depth, instance, and which of `drawn` owns each pixel (-1: ground or sky)."""
    rays = _rays(view)
    fall = rays @ -view.axes[:, 2]
    with np.errstate(divide="ignore"):
        depth = np.where(fall > 0.0, view.centre[2] / fall, np.inf)
    instance = np.zeros(depth.shape, np.int32)
    owner = np.full(depth.shape, -1, np.int32)
    for index, thing in enumerate(drawn):
        for covered, plane in _covered(thing.drawing, depth.shape):
            depth[covered] = 1.0 / (rays[covered] @ plane)
            instance[covered] = thing.instance
            owner[covered] = index
    return depth, instance, owner


def _covered(
    drawing: Drawing | Sprite, shape: tuple[int, ...]
) -> Iterator[tuple[tuple[NDArray[np.intp], ...], Floats]]:
    """The pixels of each face, as indices, and its plane: inverse depth at a pixel's ray is the dot product."""
    if isinstance(drawing, Sprite):
        rows, columns = np.nonzero(drawing.through[..., 0] < 128)
        yield (rows + drawing.y, columns + drawing.x), np.array([0.0, 0.0, 1.0 / drawing.depth_m])
        return
    for polygon, plane in zip(drawing.polygons_px, drawing.planes, strict=True):
        box = bounding_box(polygon, shape)
        if box is not None:
            x0, y0, x1, y1 = box
            rows, columns = np.nonzero(covered_pixels(polygon - (x0, y0), (y1 - y0, x1 - x0)))
            yield (rows + y0, columns + x0), plane


def covered_pixels(polygon: Floats, shape: tuple[int, ...]) -> Bools:
    """(H, W) the pixels whose centre lies in a convex polygon."""
    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.rint(polygon * 2**SHIFT).astype(np.int32), 1, cv2.LINE_8, SHIFT)
    return mask.astype(bool)


def _motion(moment: Moment, drawn: list[Drawn], depth: Floats, owner: NDArray[np.int32]) -> tuple[Singles, Singles]:
    """Flow and time to contact of every pixel."""
    rays = _rays(moment.now)
    far = np.isinf(depth)
    flow = np.zeros((*depth.shape, 2), np.float32)
    ttc = np.full(depth.shape, np.inf, np.float32)
    pixels = moment.now.pixels(rays)
    distant = rays[far] @ moment.now.axes @ moment.before.axes.T
    flow[far] = pixels[far] - moment.before.pixels(distant)
    for index in range(-1, len(drawn)):
        chosen = (owner == index) & ~far
        if not chosen.any():
            continue
        motion = STILL if index < 0 else drawn[index].motion
        world = (rays[chosen] * depth[chosen][:, None]) @ moment.now.axes + moment.now.centre
        earlier = world @ motion.turn.T + motion.shift
        flow[chosen] = pixels[chosen] - moment.before.pixels(moment.before.camera_axes(earlier))
        if moment.gap_s > 0.0:
            approach = (moment.now.centre - moment.before.centre) - (world - earlier)
            closing = approach @ moment.now.axes[2] / moment.gap_s
            with np.errstate(divide="ignore"):
                ttc[chosen] = np.where(closing > 1e-9, depth[chosen] / closing, np.inf)
    return flow, ttc
