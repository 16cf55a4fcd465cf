"""Ground truth of a frame: depth, flow, focus of expansion, time to contact, instances.

It refers to the pixels of frame k and the motion from frame k-1 to k; the first frame counts as motionless.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.lens import Lens
from vpf_sim.envs.camera.snapshot import Snapshot
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
class Shown:
    """What each pixel of the pinhole camera shows."""

    instance: NDArray[np.int32]  # (h, w) 0 ground and sky, -1 scenery, i + 1 object i
    planes: Floats  # (h, w, 3) inverse depth over the ray (x, y, 1)


@dataclass(frozen=True, slots=True)
class Moment:
    """The two frames that flow and time to contact refer to."""

    now: Snapshot
    before: Snapshot

    @property
    def gap_s(self) -> float:
        return self.now.time_s - self.before.time_s

    def motion(self, instance: int) -> Motion:
        """The motion of an instance between the frames."""
        if instance <= 0:
            return STILL
        pose = self.now.places[instance - 1]
        return Motion(self.before.poses.get(self.now.objects[instance - 1], pose), pose)


def truth(
    names: tuple[str, ...], moment: Moment, shown: Callable[[], Shown], lens: Lens
) -> dict[str, NDArray[np.generic]]:
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
    pixels, found, camera = lens.pixels(), shown(), moment.now.view.camera
    rays = _rays(camera, pixels)
    instance, depth = lens.nearest(found.instance), _depth(rays, lens.nearest(found.planes))
    if "depth" in names:
        result["depth"] = depth.astype(np.float32)
    if "instance" in names:
        result["instance"] = instance
    if "flow" in names or "ttc" in names:
        earlier, ttc = _motion(moment, depth, rays, instance)
        flow = (lens.to_image(pixels) - lens.to_image(earlier)).astype(np.float32)
        result.update({name: array for name, array in (("flow", flow), ("ttc", ttc)) if name in names})
    return result


def focus_of_expansion(moment: Moment) -> Floats:
    """(2,) px, the image in frame k of the camera's direction of motion; nan without motion."""
    now, before = moment.now.view, moment.before.view
    step = now.axes @ (now.centre - before.centre)
    if abs(step[2]) < STANDING_M:
        return np.full(2, np.nan)
    return now.pixels(step)


def _rays(camera: Camera, pixels: Floats) -> Floats:
    """(..., 3) rays of (..., 2) pixels in camera axes, with depth 1."""
    flat = (pixels - (camera.cx_px, camera.cy_px)) / (camera.fx_px, camera.fy_px)
    return np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)


def _depth(rays: Floats, planes: Floats) -> Floats:
    """(H, W) m along the optical axis, inf where a ray misses its plane."""
    inverse = np.einsum("ijk,ijk->ij", rays, planes)
    depth: Floats = np.divide(1.0, inverse, out=np.full(inverse.shape, np.inf), where=inverse > 0.0)
    return depth


def _motion(moment: Moment, depth: Floats, rays: Floats, instance: NDArray[np.int32]) -> tuple[Floats, Singles]:
    """(H, W, 2) px, each pixel's position in the pinhole's previous image, and (H, W) s, its time to contact."""
    now, before, far = moment.now.view, moment.before.view, np.isinf(depth)
    earlier_px = np.empty((*depth.shape, 2))
    ttc = np.full(depth.shape, np.inf, np.float32)
    earlier_px[far] = before.pixels(rays[far] @ now.axes @ before.axes.T)
    for index in np.unique(instance).tolist():
        chosen = (instance == index) & ~far
        if not chosen.any():
            continue
        motion = moment.motion(index)
        world = (rays[chosen] * depth[chosen][:, None]) @ now.axes + now.centre
        earlier = world @ motion.turn.T + motion.shift
        earlier_px[chosen] = before.pixels(before.camera_axes(earlier))
        if moment.gap_s > 0.0:
            approach = (now.centre - before.centre) - (world - earlier)
            closing = approach @ now.axes[2] / moment.gap_s
            with np.errstate(divide="ignore"):
                ttc[chosen] = np.where(closing > 1e-9, depth[chosen] / closing, np.inf)
    return earlier_px, ttc
