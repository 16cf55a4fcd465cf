"""The image sensor: blur, exposure and noise of the finished image."""

from functools import lru_cache
from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
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

    After a gamma of 2.2 temporal noise has nearly the same size at all tones. A noise bank is drawn once; at each time
    each strip of the image gets another part of it.
    """

    def __init__(self, rig: Rig, weather: Weather, seed: int) -> None:
        self._gain = 2.0 ** (rig.exposure_ev / GAMMA)
        self._blur_px = rig.blur_px
        sd = noise_of(weather) if rig.noise_sd is None else rig.noise_sd
        self._core: Core | None = None
        if sd > 0.0:
            self._core = Core(rig.camera, ground_top(rig.camera))
            self._core.set_noise(
                _bank(rig.camera.height_px, rig.camera.width_px, sd), int(stream(seed, "sensor noise").integers(2**63))
            )

    @timed("render.sensor")
    def expose(self, frame: Image, time_s: float) -> None:
        """Apply blur, exposure and the noise of this time, in place."""
        if self._blur_px > 0.0:
            side = 2 * ceil(3.0 * self._blur_px) + 1
            cv2.GaussianBlur(frame, (side, side), self._blur_px, frame)
        if self._gain != 1.0:
            cv2.convertScaleAbs(frame, frame, self._gain)
        if self._core is not None:
            self._core.draw_noise(frame, time_s)


def noise_of(weather: Weather) -> float:
    """Standard deviation of the noise, grey levels.

    1.3 by day, 2.5 in hard rain or with the sun at 15 deg, 5 at dusk.
    """
    by_sun = float(np.interp(weather.sun_altitude_angle, (-6.0, 15.0, 45.0), (5.0, 2.5, 1.3)))
    by_rain = float(np.interp(weather.precipitation, (0.0, 100.0), (1.3, 2.5)))
    return max(by_sun, by_rain)


@lru_cache(maxsize=4)
def _bank(height: int, width: int, sd: float) -> NDArray[np.int8]:
    """(rows, columns, 3) noise, larger than a strip; cached, since it costs 20 ms."""
    shape = (-(-height // STRIPS) + MARGIN_PX, width + MARGIN_PX, 3)
    white = stream(0, "noise bank").standard_normal(shape, dtype=np.float32)
    blurred = cv2.GaussianBlur(white, (5, 5), CORRELATION_PX)
    levels = np.rint(blurred * np.float32(sd / blurred.std()))
    return np.asarray(np.clip(levels, -128, 127), np.int8)
