"""The light of a weather: what sun and sky give to surfaces, and the colours of the sky.

All colours are those of the finished picture, 0 to 255, exposure included.
"""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class Light:
    """A surface shows its colour x (sky + direct x max(0, normal . sun)), channel by channel."""

    sun: Floats  # (3,) unit vector towards the sun, world axes with z up
    direct: Floats  # (3,) RGB factor of the sun
    sky: Floats  # (3,) RGB factor of the sky
    horizon: Floats  # (3,) RGB 0..255 of the sky at the horizon, and of what fog and rain put before things
    zenith: Floats  # (3,) RGB 0..255
    shadow: float  # what is left of the road's brightness where the sun does not shine, 0..1
    contact: float  # and right under a body

    @classmethod
    def of(cls, weather: Weather) -> "Light":
        """The light of a weather."""
        altitude, azimuth = radians(weather.sun_altitude_angle), radians(weather.sun_azimuth_angle)
        sun = np.array([cos(altitude) * cos(azimuth), cos(altitude) * sin(azimuth), sin(altitude)])
        return cls(
            sun=sun,
            direct=np.full(3, 0.6),
            sky=np.full(3, 0.55),
            horizon=np.array([214.0, 224.0, 232.0]),
            zenith=np.array([96.0, 146.0, 208.0]),
            shadow=0.5,
            contact=0.27,
        )
