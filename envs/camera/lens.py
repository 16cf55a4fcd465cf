"""Lens distortion."""

from dataclasses import replace
from math import ceil, floor
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.errors import InputError
from vpf_sim.geometry import distort, undistort
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

WIDEST = 2.0  # tangent of the largest angle from the axis, 63 deg
STEPS = 2000
Values = TypeVar("Values", bound=np.generic)


class Lens:
    """Distorts the image of a pinhole camera by OpenCV's radial model k1, k2.

    The pinhole camera has the lens's intrinsics without distortion and an image large enough for all its rays. Without
    distortion it is the lens's camera itself, and images pass unchanged.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self.is_distorted = camera.k1 != 0.0 or camera.k2 != 0.0
        self.pinhole = camera  # renders the undistorted image
        self._corner_px = np.zeros(2)  # the pinhole image's first pixel in undistorted pixels
        if self.is_distorted:
            self.pinhole, self._corner_px = _pinhole(camera)
            x, y = np.moveaxis(self.pixels().astype(np.float32), -1, 0)
            self._maps = cv2.convertMaps(x, y, cv2.CV_16SC2)

    def pixels(self) -> Floats:
        """(H, W, 2) px, each pixel's position in the pinhole's image."""
        return undistort(self._camera, _pixel_grid(self._camera)) - self._corner_px

    def nearest(self, values: NDArray[Values]) -> NDArray[Values]:
        """(H, W, ...) the pinhole's (h, w, ...) values sampled at each pixel."""
        if not self.is_distorted:
            return values
        column, row = np.moveaxis(np.rint(self.pixels()).astype(np.intp), -1, 0)
        return np.asarray(values[row, column], values.dtype)

    def to_image(self, pixels: Floats) -> Floats:
        """(..., 2) px in the distorted image for the pinhole's pixels."""
        return distort(self._camera, pixels + self._corner_px)

    @timed("render.lens")
    def distorted(self, frame: Image) -> Image:
        """(H, W, 3) the pinhole's image through the lens."""
        if not self.is_distorted:
            return frame
        across, down = self._maps
        return np.asarray(cv2.remap(frame, across, down, cv2.INTER_LINEAR), np.uint8)


def _pixel_grid(camera: Camera) -> Floats:
    """(H, W, 2) coordinates of each pixel."""
    grid = np.meshgrid(np.arange(camera.width_px, dtype=float), np.arange(camera.height_px, dtype=float))
    return np.stack(grid, axis=-1)


def check_distortion(camera: Camera) -> None:
    """Raise InputError for a distortion that is not invertible within the image."""
    if camera.k1 == 0.0 and camera.k2 == 0.0:
        return
    radius = np.linspace(0.0, WIDEST, STEPS)
    distorted_radius = radius * (1.0 + camera.k1 * radius**2 + camera.k2 * radius**4)
    folds = np.flatnonzero(np.diff(distorted_radius) <= 0.0)
    reach = float(distorted_radius[folds[0]] if len(folds) else distorted_radius[-1])
    corners = [
        np.hypot((x - camera.cx_px) / camera.fx_px, (y - camera.cy_px) / camera.fy_px)
        for x in (0, camera.width_px - 1)
        for y in (0, camera.height_px - 1)
    ]
    if max(corners) > 0.99 * reach:
        raise InputError(
            f"camera: k1, k2: expected a distortion that is invertible within the image, to {max(corners):.2f} off "
            f"the axis, got {camera.k1:g}, {camera.k2:g}, with which rays reach {reach:.2f}"
        )


def _pinhole(camera: Camera) -> tuple[Camera, Floats]:
    """The camera without distortion that covers all rays of `camera`, and its first pixel in undistorted pixels."""
    x, y = np.moveaxis(undistort(camera, _pixel_grid(camera)), -1, 0)
    left, top = floor(float(x.min())) - 1, floor(float(y.min())) - 1
    width, height = ceil(float(x.max())) + 2 - left, ceil(float(y.max())) + 2 - top
    pinhole = replace(
        camera,
        width_px=width + width % 2,
        height_px=height + height % 2,
        cx_px=camera.cx_px - left,
        cy_px=camera.cy_px - top,
        k1=0.0,
        k2=0.0,
    )
    return pinhole, np.array([left, top], float)
