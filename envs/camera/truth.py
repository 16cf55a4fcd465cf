"""Ground truth of a frame: depth, flow, focus of expansion, time to contact, instances.

It refers to the pixels of frame k and the motion from frame k-1 to k; the first frame counts as motionless.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.lens import Lens
from vpf_sim.envs.camera.painter import SHIFT, Drawing, Sprite
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats

Singles = NDArray[np.float32]
STANDING_M = 1e-6  # below this a camera counts as motionless


@dataclass(frozen=True, slots=True)
class Motion:
    """Rigid motion between frames: a world point p of frame k was at `turn` p + `shift` in frame k-1."""

    before: Floats  # pose (x, y, heading)
    now: Floats

    @property
    def turn(self) -> Floats:
        """(3, 3) rotation."""
        angle = self.before[2] - self.now[2]
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    @property
    def shift(self) -> Floats:
        """(3,) m, translation."""
        shift: Floats = np.array([*self.before[:2], 0.0]) - self.turn @ np.array([*self.now[:2], 0.0])
        return shift


STILL = Motion(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, slots=True)
class Drawn:
    """One drawn item of the frame, in painter's order."""

    drawing: Drawing | Sprite
    instance: int  # -1 scenery, i + 1 object i
    motion: Motion


@dataclass(frozen=True, slots=True)
class Moment:
    """The two views that flow and time to contact refer to."""

    now: View
    before: View
    gap_s: float


def truth(names: tuple[str, ...], moment: Moment, drawn: list[Drawn], lens: Lens) -> dict[str, NDArray[np.generic]]:
    """The requested arrays of the image through the lens; the views belong to its pinhole camera.

    depth: (H, W) float32 m along the optical axis, inf in the sky. flow: (H, W, 2) float32 px from k-1 to k, with
    objects' own motion; the sky's flow is that of the rotation. foe: (2,) float64 px, the image of the camera's
    translation, nan without motion. ttc: (H, W) float32 s, depth / closing speed along the optical axis, inf if not
    closing. instance: (H, W) int32, 0 ground and sky, -1 scenery, i + 1 object i of `Renderer.objects`.
    """
    result: dict[str, NDArray[np.generic]] = {}
    if "foe" in names:
        result["foe"] = lens.to_image(focus_of_expansion(moment))
    if not set(names) - {"foe", "hidden"}:
        return result
    pixels = lens.pixels()
    rays = _rays(moment.now.camera, pixels)
    owner, planes = _rasterised(moment.now, drawn)
    owner, depth = lens.nearest(owner), _depth(rays, lens.nearest(planes))
    if "depth" in names:
        result["depth"] = depth.astype(np.float32)
    if "instance" in names:
        result["instance"] = np.array([0, *(item.instance for item in drawn)], np.int32)[owner + 1]
    if "flow" in names or "ttc" in names:
        earlier, ttc = _motion(moment, drawn, depth, rays, owner)
        flow = (lens.to_image(pixels) - lens.to_image(earlier)).astype(np.float32)
        result.update({name: array for name, array in (("flow", flow), ("ttc", ttc)) if name in names})
    return result


def focus_of_expansion(moment: Moment) -> Floats:
    """(2,) px, the image in frame k of the camera's direction of motion; nan without motion."""
    step = moment.now.axes @ (moment.now.centre - moment.before.centre)
    if abs(step[2]) < STANDING_M:
        return np.full(2, np.nan)
    return moment.now.pixels(step)


def _rays(camera: Camera, pixels: Floats) -> Floats:
    """(..., 3) rays of (..., 2) pixels in camera axes, with depth 1."""
    flat = (pixels - (camera.cx_px, camera.cy_px)) / (camera.fx_px, camera.fy_px)
    return np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)


def _rasterised(view: View, drawn: list[Drawn]) -> tuple[NDArray[np.int32], Floats]:
    """(h, w) the item of `drawn` at each pinhole pixel (-1: ground or sky), and (h, w, 3) its plane there."""
    label = np.zeros((view.camera.height_px, view.camera.width_px), np.int32)
    owners, planes = [-1], [-view.axes[:, 2] / view.centre[2]]
    for index, item in enumerate(drawn):
        drawing = item.drawing
        if isinstance(drawing, Sprite):
            x0, y0, x1, y1 = drawing.box
            label[y0:y1, x0:x1][drawing.through[..., 0] < 128] = len(owners)
            owners.append(index)
            planes.append(np.array([0.0, 0.0, 1.0 / drawing.depth_m]))
            continue
        for polygon, plane in zip(_fixed(drawing.polygons_px), drawing.planes, strict=True):
            cv2.fillConvexPoly(label, polygon, (len(owners),), cv2.LINE_8, SHIFT)
            owners.append(index)
            planes.append(plane)
    return np.array(owners, np.int32).take(label), np.array(planes).take(label, axis=0)


def _fixed(polygons: Floats) -> NDArray[np.int32]:
    """Pixels in OpenCV's fixed-point format."""
    return np.asarray(np.rint(polygons * 2**SHIFT), np.int32)


def _depth(rays: Floats, planes: Floats) -> Floats:
    """(H, W) m along the optical axis, inf where a ray misses its plane."""
    inverse = np.einsum("ijk,ijk->ij", rays, planes)
    depth: Floats = np.divide(1.0, inverse, out=np.full(inverse.shape, np.inf), where=inverse > 0.0)
    return depth


def _motion(
    moment: Moment, drawn: list[Drawn], depth: Floats, rays: Floats, owner: NDArray[np.int32]
) -> tuple[Floats, Singles]:
    """(H, W, 2) px, each pixel's position in the pinhole's previous image, and (H, W) s, its time to contact."""
    far = np.isinf(depth)
    earlier_px = np.empty((*depth.shape, 2))
    ttc = np.full(depth.shape, np.inf, np.float32)
    earlier_px[far] = moment.before.pixels(rays[far] @ moment.now.axes @ moment.before.axes.T)
    for index in range(-1, len(drawn)):
        chosen = (owner == index) & ~far
        if not chosen.any():
            continue
        motion = STILL if index < 0 else drawn[index].motion
        world = (rays[chosen] * depth[chosen][:, None]) @ moment.now.axes + moment.now.centre
        earlier = world @ motion.turn.T + motion.shift
        earlier_px[chosen] = moment.before.pixels(moment.before.camera_axes(earlier))
        if moment.gap_s > 0.0:
            approach = (moment.now.centre - moment.before.centre) - (world - earlier)
            closing = approach @ moment.now.axes[2] / moment.gap_s
            with np.errstate(divide="ignore"):
                ttc[chosen] = np.where(closing > 1e-9, depth[chosen] / closing, np.inf)
    return earlier_px, ttc
