"""Refraction by water on the windscreen."""

import cv2
import numpy as np

from vpf_sim.envs.camera.glass.planes import ROWS, Planes
from vpf_sim.envs.camera.glass.stamps import SHADES
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Image

SKY_LIGHT = 0.12  # share of reflected skylight in a drop
FILM_SPREAD, DROP_SPREAD = (5, 5), (13, 13)  # px of the small images; a drop of 10 px is blurred by 4 px


class Refraction:
    """Captures frames and composes the refracted ones, with preallocated buffers."""

    def __init__(self, planes: Planes, light: Light) -> None:
        self._planes = planes
        (film_h, film_w), (height, width) = planes.film, planes.scene
        self._pictures: Image = np.zeros((film_h + len(SHADES) * height, film_w, 3), np.uint8)
        self._film = self._pictures[:film_h]
        self._shades = [self._pictures[film_h + k * height :][:height, :width] for k in range(len(SHADES))]
        self._sky: Image = np.broadcast_to(np.rint(SKY_LIGHT * light.horizon), (height, width, 3)).astype(np.uint8)
        self._lookup = np.zeros(planes.shape, np.uint32)  # lookups of four bytes are three times as fast as of three
        self._texture: Image = np.zeros((*planes.shape, 3), np.uint8)
        self._keep: Image = np.zeros((*planes.shape, 3), np.uint8)

    def refract(self, cover: Image) -> None:
        """Compose the captured images through water with opacity `cover` (h, w) 0..255 on the planes."""
        pixels = np.asarray(cv2.cvtColor(self._pictures, cv2.COLOR_RGB2RGBA), np.uint8).view(np.uint32)
        np.take(pixels, self._planes.source, out=self._lookup, mode="wrap")  # no bounds check needed
        cv2.cvtColor(self._lookup.view(np.uint8).reshape(*self._planes.shape, 4), cv2.COLOR_RGBA2RGB, self._texture)
        cv2.cvtColor(cover, cv2.COLOR_GRAY2RGB, self._keep)
        cv2.multiply(self._texture, self._keep, self._texture, 1.0 / 255.0)
        cv2.bitwise_not(self._keep, self._keep)

    def apply(self, frame: Image) -> None:
        """Blend the refracted water over a frame, in place."""
        for first in range(ROWS):
            rows = frame[first::ROWS]
            cv2.multiply(rows, self._keep[: len(rows)], rows, 1.0 / 255.0)
            cv2.add(rows, self._texture[: len(rows)], rows)

    def capture(self, frame: Image) -> None:
        """Store the small images of a frame that film and drops show."""
        film, (scene, *shades) = self._film, self._shades
        cv2.resize(frame, film.shape[1::-1], film)
        cv2.resize(film, scene.shape[1::-1], scene)
        cv2.blur(film, FILM_SPREAD, film)
        cv2.blur(scene, DROP_SPREAD, scene)
        cv2.addWeighted(scene, 1.0 - SKY_LIGHT, self._sky, 1.0, 0.0, scene)
        for shade, light in zip(shades, SHADES[1:], strict=True):
            cv2.convertScaleAbs(scene, shade, light)
