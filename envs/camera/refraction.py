"""What water on the windshield does to the light: the picture is kept where there is none, bent where there is."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.planes import NONE, Planes
from vpf_sim.types import Camera, Image

RIM_LIGHT, SKY_LIGHT = 0.6, 0.12  # brightness of a drop's rim; what a drop mirrors of the sky
SPREAD_PX = 5  # blur of the small picture of the scene


class Refraction:
    """Owns the buffers, for a frame's worth of memory taken anew costs as much as what is done with it."""

    def __init__(self, camera: Camera, planes: Planes, light: Light) -> None:
        self._planes = planes
        self._size = (camera.width_px, camera.height_px)
        height, width = planes.scene
        self._scenes: Image = np.zeros((3 * height, width, 3), np.uint8)  # as `stamps` counts them
        self._sky: Image = np.broadcast_to(np.rint(SKY_LIGHT * light.horizon), (height, width, 3)).astype(np.uint8)
        self._texture: Image = np.zeros((*planes.shape, 3), np.uint8)
        self._alpha: Image = np.zeros((*planes.shape, 3), np.uint8)
        self._full: Image = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)

    def apply(self, frame: Image, cover: Image) -> None:
        """Show the frame through water that covers `cover` (h, w) 0..255 of each pixel of the planes, in place."""
        self._picture(frame)
        texture, alpha, full = self._texture, self._alpha, self._full
        cv2.remap(self._scenes, self._planes.source, NONE, cv2.INTER_NEAREST, texture)
        cv2.cvtColor(cover, cv2.COLOR_GRAY2RGB, alpha)
        cv2.multiply(texture, alpha, texture, 1.0 / 255.0)
        cv2.cvtColor(cv2.resize(cv2.bitwise_not(cover), self._size), cv2.COLOR_GRAY2RGB, full)
        cv2.multiply(frame, full, frame, 1.0 / 255.0)
        cv2.resize(texture, self._size, full)
        cv2.add(frame, full, frame)

    def _picture(self, frame: Image) -> None:
        """Make the small pictures that drops show, one above the other: film, body, rim."""
        height, width = self._planes.scene
        film, body, rim = np.split(self._scenes, 3)
        cv2.blur(cv2.resize(frame, (width, height)), (SPREAD_PX, SPREAD_PX), film)
        cv2.addWeighted(film, 1.0 - SKY_LIGHT, self._sky, 1.0, 0.0, body)
        cv2.convertScaleAbs(film, rim, RIM_LIGHT)
