"""The image sensor: blur, exposure and noise of the finished image."""

from functools import lru_cache
from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.light import GAMMA
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Image

STRIPS = 4  # image strips with their own part of the noise bank: a small bank fits the CPU cache
MARGIN_PX = 32  # size of the bank beyond a strip
CORRELATION_PX = 0.5  # sd of the blur of the noise by demosaicing and denoising


class Sensor:
    """Blur, exposure and temporal noise of the sensor.

    After a gamma of 2.2 temporal noise has nearly the same size at all tones. A noise bank is drawn once; each frame
    adds it to each strip of the image from a random corner.
    """

    def __init__(self, rig: Rig, weather: Weather, seed: int) -> None:
        self._rng = stream(seed, "sensor noise")
        self._size = (rig.camera.height_px, rig.camera.width_px)
        self._gain = 2.0 ** (rig.exposure_ev / GAMMA)
        self._blur_px = rig.blur_px
        sd = noise_of(weather) if rig.noise_sd is None else rig.noise_sd
        self._layers = _bank(*self._size, sd) if sd > 0.0 else None

    @timed("render.sensor")
    def expose(self, frame: Image) -> None:
        """Apply blur, exposure and the next frame's noise, in place."""
        if self._blur_px > 0.0:
            side = 2 * ceil(3.0 * self._blur_px) + 1
            cv2.GaussianBlur(frame, (side, side), self._blur_px, frame)
        if self._gain != 1.0:
            cv2.convertScaleAbs(frame, frame, self._gain)
        if self._layers is not None:
            self._add_noise(frame, *self._layers)

    def skip(self) -> None:
        """Skip the next frame's noise."""
        if self._layers is not None:
            self._corners()

    def _corners(self) -> NDArray[np.int64]:
        """(STRIPS, 2) row and column of the bank for each strip of the next frame."""
        return self._rng.integers(0, MARGIN_PX, (STRIPS, 2))

    def _add_noise(self, frame: Image, brighter: Image, darker: Image) -> None:
        height, width = self._size
        flat = frame.reshape(height, 3 * width)
        strip = -(-height // STRIPS)
        for top, (y, x) in zip(range(0, height, strip), self._corners(), strict=True):
            part = flat[top : top + strip]
            corner = slice(y, y + len(part)), slice(3 * x, 3 * (x + width))
            cv2.add(part, brighter[corner], part)
            cv2.subtract(part, darker[corner], part)


def noise_of(weather: Weather) -> float:
    """Standard deviation of the noise, grey levels.

    1.3 by day, 2.5 in hard rain or with the sun at 15 deg, 5 at dusk.
    """
    by_sun = float(np.interp(weather.sun_altitude_angle, (-6.0, 15.0, 45.0), (5.0, 2.5, 1.3)))
    by_rain = float(np.interp(weather.precipitation, (0.0, 100.0), (1.3, 2.5)))
    return max(by_sun, by_rain)


@lru_cache(maxsize=4)
def _bank(height: int, width: int, sd: float) -> tuple[Image, Image]:
    """Noise to add and noise to subtract, three channels side by side; cached, since it costs 20 ms."""
    shape = (-(-height // STRIPS) + MARGIN_PX, width + MARGIN_PX, 3)
    white = stream(0, "noise bank").standard_normal(shape, dtype=np.float32)
    blurred = cv2.GaussianBlur(white, (5, 5), CORRELATION_PX).reshape(shape[0], -1)
    levels = np.rint(blurred * np.float32(sd / blurred.std()))
    return np.clip(levels, 0, 255).astype(np.uint8), np.clip(-levels, 0, 255).astype(np.uint8)
