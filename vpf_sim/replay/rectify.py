"""Rectifies frames for perception: pinhole or radial lens, looking straight ahead.

Mounting: yaw + looks right, pitch + looks down, roll + clockwise as seen from behind the camera.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import ceil
from typing import Literal

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay.image_files import Frame
from vpf_sim.types import Camera, Floats, Image

WIDEST_PX = 1300  # wider images are reduced, since tracking time grows with pixels
WIDEST_TANGENT = 1.5  # of the largest angle from the axis that a fisheye's image keeps
LEAST_PX = 15.0  # least size of a usable image
MARGIN_PX = 2.0  # at the edge, since the inverse of the lens is iterative
SLIGHT_RAD = 5e-4  # of yaw and roll: not worth a remap


@dataclass(frozen=True, slots=True)
class Lens:
    """A calibrated camera; distortion coefficients are OpenCV's, in its order (k1 k2 p1 p2 k3 ...)."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: tuple[float, ...] = ()
    model: Literal["pinhole", "fisheye"] = "pinhole"

    @property
    def matrix(self) -> Floats:
        """(3, 3) camera matrix."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    @property
    def coefficients(self) -> Floats:
        """(4 or more,) distortion coefficients for OpenCV."""
        return np.array([*self.distortion, *[0.0] * (4 - len(self.distortion))])


@dataclass(frozen=True, slots=True)
class Mounting:
    """The orientation and height of the camera on the car."""

    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
    roll_rad: float = 0.0
    height_m: float = 1.4


def reduction(width_px: int) -> int:
    """The whole number by which images of this width are reduced."""
    return ceil(width_px / WIDEST_PX)


def reduced(lens: Lens, by: int) -> Lens:
    """The lens of images that are `by` times smaller; pixel centres keep their direction."""
    return replace(
        lens,
        width_px=lens.width_px // by,
        height_px=lens.height_px // by,
        fx_px=lens.fx_px / by,
        fy_px=lens.fy_px / by,
        cx_px=(lens.cx_px + 0.5) / by - 0.5,
        cy_px=(lens.cy_px + 0.5) / by - 0.5,
    )


def shrunk(image: Image, lens: Lens) -> Image:
    """The image as a reduced lens shows it."""
    by = image.shape[1] // lens.width_px
    if by == 1:
        return image
    even = image[: lens.height_px * by, : lens.width_px * by]
    size = (lens.width_px, lens.height_px)
    return cv2.resize(even, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)


def rotation(mounting: Mounting) -> Floats:
    """(3, 3) from camera axes (x right, y down, z forward) to vehicle axes (right, down, forward)."""
    turns = (_about(1, mounting.yaw_rad), _about(0, -mounting.pitch_rad), _about(2, mounting.roll_rad))
    return turns[0] @ turns[1] @ turns[2]


def mounting_from_rotation(camera_to_vehicle: Floats, height_m: float) -> Mounting:
    """Mounting angles of a (3, 3) rotation, the inverse of `rotation`."""
    axis = camera_to_vehicle[:, 2]
    pitch, yaw = float(np.arcsin(axis[1])), float(np.arctan2(axis[0], axis[2]))
    level = _about(0, pitch) @ _about(1, -yaw) @ camera_to_vehicle
    return Mounting(pitch, yaw, float(np.arctan2(level[1, 0], level[0, 0])), height_m)


def mounting_from_direction(direction: Floats, height_m: float) -> Mounting:
    """Mounting without roll of a camera that moves in this direction (3,) of its own axes."""
    right, down, depth = direction / np.linalg.norm(direction)
    return Mounting(float(np.arctan2(-down, depth)), float(-np.arcsin(right)), 0.0, height_m)


def rectified(lens: Lens, mounting: Mounting) -> tuple[Camera, Callable[[Image], Image]]:
    """The camera of the rectified frames, and the function that rectifies an image.

    Radial distortion of two coefficients stays, since perception removes it from its points. Other distortion, and a
    camera that does not look straight ahead, need a remap of each frame, cropped to what was visible.
    """
    lens = reduced(lens, reduction(lens.width_px))
    if _needs_no_remap(lens, mounting):
        radial = (*lens.distortion, 0.0, 0.0)[:2]
        return _camera(lens, mounting, radial), lambda image: shrunk(image, lens)
    straight = rotation(replace(mounting, yaw_rad=0.0, roll_rad=0.0)).T @ rotation(mounting)
    view = _view(lens, straight)
    maps = _remap_tables(lens, straight, view)
    return _camera(view, mounting, (0.0, 0.0)), lambda image: _warped(shrunk(image, lens), maps)


def rectified_frames(frames: Iterator[Frame], rectify_image: Callable[[Image], Image]) -> Iterator[Frame]:
    """The frames, rectified for perception."""
    for frame in frames:
        yield frame if frame.image is None else replace(frame, image=rectify_image(frame.image))


def _needs_no_remap(lens: Lens, mounting: Mounting) -> bool:
    straight = abs(mounting.yaw_rad) < SLIGHT_RAD and abs(mounting.roll_rad) < SLIGHT_RAD
    return straight and lens.model == "pinhole" and not any(lens.distortion[2:])


def _camera(lens: Lens, mounting: Mounting, radial: tuple[float, ...]) -> Camera:
    return Camera(
        lens.width_px,
        lens.height_px,
        lens.fx_px,
        lens.fy_px,
        lens.cx_px,
        lens.cy_px,
        height_m=mounting.height_m,
        forward_m=0.0,
        pitch_rad=mounting.pitch_rad,
        k1=radial[0],
        k2=radial[1],
    )


def _view(lens: Lens, straight: Floats) -> Lens:
    """The pinhole of the largest rectangle that was visible everywhere."""
    width, height = lens.width_px - 1.0, lens.height_px - 1.0
    along = np.linspace(0.0, 1.0, 33)
    sides = [
        _rectified_points(lens, straight, np.stack([x * width + 0.0 * along, y * height + 0.0 * along], axis=1))
        for x, y in ((0.0, along), (1.0, along), (along, 0.0), (along, 1.0))
    ]
    reach = WIDEST_TANGENT * lens.fx_px
    first = np.array([sides[0][:, 0].max(), sides[2][:, 1].max()]) + MARGIN_PX
    last = np.array([sides[1][:, 0].min(), sides[3][:, 1].min()]) - MARGIN_PX
    centre, whole = np.array([lens.cx_px, lens.cy_px]), np.array([lens.width_px, lens.height_px])
    left, top = np.ceil(np.maximum(np.maximum(first, centre - reach), 0.0 - whole)).tolist()
    right, bottom = np.floor(np.minimum(np.minimum(last, centre + reach), 2.0 * whole)).tolist()
    if not (right - left >= LEAST_PX and bottom - top >= LEAST_PX):
        visible = f"{right - left + 1:g} x {bottom - top + 1:g} px"
        raise InputError(
            f"expected a lens and a mounting that show what is straight ahead, got {visible}: check [camera]"
        )
    size = (int(right - left) + 1, int(bottom - top) + 1)
    return Lens(*size, lens.fx_px, lens.fy_px, lens.cx_px - left, lens.cy_px - top)


def _rectified_points(lens: Lens, straight: Floats, pixels: Floats) -> Floats:
    """(N, 2) px in the straight pinhole, of equal focal length and centre, for pixels (N, 2) of the frame."""
    points = pixels.reshape(-1, 1, 2)
    if lens.model == "fisheye":
        found = cv2.fisheye.undistortPoints(points, lens.matrix, lens.coefficients, R=straight, P=lens.matrix)
    else:
        found = cv2.undistortPoints(points, lens.matrix, lens.coefficients, R=straight, P=lens.matrix)
    return np.asarray(found, float).reshape(-1, 2)


def _remap_tables(lens: Lens, straight: Floats, view: Lens) -> tuple[Image, Image]:
    size = (view.width_px, view.height_px)
    make = cv2.fisheye.initUndistortRectifyMap if lens.model == "fisheye" else cv2.initUndistortRectifyMap
    first, second = make(lens.matrix, lens.coefficients, straight, view.matrix, size, cv2.CV_16SC2)
    return first, second  # type: ignore[return-value]


def _warped(image: Image, maps: tuple[Image, Image]) -> Image:
    return cv2.remap(image, *maps, cv2.INTER_LINEAR).astype(np.uint8, copy=False)


def _about(axis: int, angle_rad: float) -> Floats:
    turn, _ = cv2.Rodrigues(np.eye(3)[axis] * angle_rad)
    return np.asarray(turn, float)
