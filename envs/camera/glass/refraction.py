"""What water on the windshield does to the light: the picture is kept where there is none, bent where there is."""

import cv2
import numpy as np

from vpf_sim.envs.camera.glass.planes import ROWS, Planes
from vpf_sim.envs.camera.glass.stamps import SHADES
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Image

SKY_LIGHT = 0.12  # share of a drop's light that is the sky's mirror image
FILM_SPREAD, DROP_SPREAD = (5, 5), (13, 13)  # px of the small pictures; through a drop of 10 px, far out of focus, 4 px


class Refraction:
    """Owns the buffers, for a frame's worth of memory taken anew costs as much as what is done with it."""

    def __init__(self, planes: Planes, light: Light) -> None:
        self._planes = planes
        (film_h, film_w), (height, width) = planes.film, planes.scene
        self._pictures: Image = np.zeros((film_h + len(SHADES) * height, film_w, 3), np.uint8)
        self._film = self._pictures[:film_h]
        self._shades = [self._pictures[film_h + k * height :][:height, :width] for k in range(len(SHADES))]
        self._sky: Image = np.broadcast_to(np.rint(SKY_LIGHT * light.horizon), (height, width, 3)).astype(np.uint8)
        self._looked_up = np.zeros(planes.shape, np.uint32)  # pixels of four bytes are found thrice as fast as of three
        self._texture: Image = np.zeros((*planes.shape, 3), np.uint8)
        self._keep: Image = np.zeros((*planes.shape, 3), np.uint8)

    def refract(self, cover: Image) -> None:
        """Look at what was seen last through water that covers `cover` (h, w) 0..255 of each pixel of the planes."""
        pixels = np.asarray(cv2.cvtColor(self._pictures, cv2.COLOR_RGB2RGBA), np.uint8).view(np.uint32)
        np.take(pixels, self._planes.source, out=self._looked_up, mode="wrap")  # without a check: all are inside
        cv2.cvtColor(self._looked_up.view(np.uint8).reshape(*self._planes.shape, 4), cv2.COLOR_RGBA2RGB, self._texture)
        cv2.cvtColor(cover, cv2.COLOR_GRAY2RGB, self._keep)
        cv2.multiply(self._texture, self._keep, self._texture, 1.0 / 255.0)
        cv2.bitwise_not(self._keep, self._keep)

    def apply(self, frame: Image) -> None:
        """Put the water as it was last looked through before a frame, in place."""
        for first in range(ROWS):
            rows = frame[first::ROWS]
            cv2.multiply(rows, self._keep[: len(rows)], rows, 1.0 / 255.0)
            cv2.add(rows, self._texture[: len(rows)], rows)

    def capture(self, frame: Image) -> None:
        """Make the small pictures of a frame that film and drops show."""
        film, (scene, *shades) = self._film, self._shades
        cv2.resize(frame, film.shape[1::-1], film)
        cv2.resize(film, scene.shape[1::-1], scene)
        cv2.blur(film, FILM_SPREAD, film)
        cv2.blur(scene, DROP_SPREAD, scene)
        cv2.addWeighted(scene, 1.0 - SKY_LIGHT, self._sky, 1.0, 0.0, scene)
        for shade, light in zip(shades, SHADES[1:], strict=True):
            cv2.convertScaleAbs(scene, shade, light)
