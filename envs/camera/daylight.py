"""Illuminance of sun and sky by the sun's altitude, clouds and fog."""

from dataclasses import dataclass
from math import exp, radians, sin

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Floats

SOLAR_KLX = 133.8  # solar illuminance outside the atmosphere
FOG_DEPTH_M = 200.0  # height of a fog layer
LOWEST_SINE = 0.035  # lowest sine of the altitude for the air mass 1 / sine: 2 deg
TWILIGHT_DECADES_PER_DEG = 0.4  # measured illuminance falls from 700 lx at the horizon to 3 lx at -6 deg
WAVELENGTHS_UM = np.array([0.61, 0.55, 0.465])  # R, G, B
TURBIDITY = 0.1  # Angstrom's beta: slightly hazy
WHITE_ALTITUDE_DEG = 45.0  # sun altitude of the white balance


@dataclass(frozen=True, slots=True)
class Daylight:
    """Illuminances by the daylight availability model of the IES (Gillette, Pierpoint and Treado, J. IES 13:330, 1984).

    Cloud cover interpolates between its three skies:

        sun on a plane that faces it   133.8 exp(-c / sin a) klx    c = 0.21 clear, 0.80 half cloudy, infinite overcast
        sky on a horizontal plane      A + B sin^C a klx            0.8, 15.5, 0.5 / 0.3, 45, 1 / 0.3, 21, 1

    A fog layer of 200 m transmits exp(-k 200 m / sin a) of the sun's light and adds half of the rest to the sky.
    """

    sun_klx: float  # on a plane that faces the sun
    sky_klx: float  # on a horizontal plane
    ground_klx: float  # both, on a horizontal plane
    sun_colour: Floats  # (3,) linear RGB, 1 in the green; white at a sun altitude of 45 deg

    @classmethod
    def of(cls, weather: Weather, atmosphere: Atmosphere) -> "Daylight":
        """The daylight of a weather."""
        cover, height = cloud_cover(weather), sin(radians(weather.sun_altitude_angle))
        above = max(height, LOWEST_SINE)
        sun = 0.0
        if height > 0.0 and cover < 1.0:
            sun = SOLAR_KLX * exp(-(0.21 + 0.59 * cover / (1.0 - cover)) / above) * min(1.0, height / LOWEST_SINE)
        skies = 0.8 + 15.5 * max(height, 0.0) ** 0.5, 0.3 + 45.0 * max(height, 0.0), 0.3 + 21.0 * max(height, 0.0)
        sky = float(np.interp(cover, (0.0, 0.5, 1.0), skies))
        sky *= 10.0 ** (TWILIGHT_DECADES_PER_DEG * min(weather.sun_altitude_angle, 0.0))
        transmission = exp(-atmosphere.extinction_per_m * FOG_DEPTH_M / above)
        sky += 0.5 * (1.0 - transmission) * sun * max(height, 0.0)
        return cls(
            transmission * sun, sky, transmission * sun * max(height, 0.0) + sky, sun_colour(weather.sun_altitude_angle)
        )


def cloud_cover(weather: Weather) -> float:
    """The share of the sky that clouds cover, 0 to 1: the cloudiness, but at least 1 - (1 - p)^3 for rain of p.

    CARLA's soft rain, p = 0.3, has a cloudiness of 20 only; the bound gives it two thirds.
    """
    return max(weather.cloudiness / 100.0, 1.0 - (1.0 - weather.precipitation / 100.0) ** 3)


def sun_colour(altitude_deg: float) -> Floats:
    """(3,) linear RGB of the sun, 1 in the green, after Rayleigh scattering and haze.

    Optical depths at a wavelength of w um: 0.0086 w^-4 (1 + 0.0113 w^-2) (Hansen and Travis 1974,
    doi 10.1007/BF00168069) and beta w^-1.3 (Angstrom 1929).
    """
    depth = 0.008569 * WAVELENGTHS_UM**-4.0 * (1.0 + 0.0113 * WAVELENGTHS_UM**-2.0) + TURBIDITY * WAVELENGTHS_UM**-1.3
    path = 1.0 / max(sin(radians(altitude_deg)), LOWEST_SINE) - 1.0 / sin(radians(WHITE_ALTITUDE_DEG))
    transmission = np.exp(-depth * path)
    return np.asarray(transmission / transmission[1])
