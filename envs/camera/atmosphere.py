"""The physical meaning of a weather's factors."""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Floats

HEAVIEST_RAIN_MMPH = 50.0
CLEAREST_M, DENSEST_M = 20_000.0, 50.0  # visibility at a fog density of 0 and 100
STRONGEST_WIND_MPS = 15.0
WIND_ANGLE_DEG = 70.0  # the wind blows towards this direction, clockwise from the world's X axis


@dataclass(frozen=True, slots=True)
class Atmosphere:
    """Rain, visibility, wind and water of one weather. CARLA's factors have no units; these are ours.

    rain_mmph: 50 (precipitation / 100)^2 mm/h, so 30, 60, 100 are 4.5 (moderate), 18 (heavy) and 50 mm/h (violent).
    visibility_m: meteorological optical range, where contrast falls to 5 %: 20 km x (50 m / 20 km)^(fog / 100).
    extinction_per_m: of light towards the camera (Koschmieder): 3.0 / visibility + 0.312 R^0.67 / km for R mm/h of
    rain (Weber et al. 2015). wind_mps: (2,) world; 15 m/s at an intensity of 100. wetness, puddles: 0 to 1;
    the road's wetness is the largest of wetness, precipitation and deposits.
    """

    rain_mmph: float
    visibility_m: float
    extinction_per_m: float
    wind_mps: Floats
    wetness: float
    puddles: float

    @classmethod
    def of(cls, weather: Weather) -> "Atmosphere":
        """The atmosphere of a weather."""
        rain = HEAVIEST_RAIN_MMPH * (weather.precipitation / 100.0) ** 2
        visibility = CLEAREST_M * (DENSEST_M / CLEAREST_M) ** (weather.fog_density / 100.0)
        wind = STRONGEST_WIND_MPS * weather.wind_intensity / 100.0
        direction = radians(WIND_ANGLE_DEG)
        wettest = max(weather.wetness, weather.precipitation, weather.precipitation_deposits)
        return cls(
            rain_mmph=rain,
            visibility_m=visibility,
            extinction_per_m=3.0 / visibility + 0.312e-3 * rain**0.67,
            wind_mps=wind * np.array([cos(direction), sin(direction)]),
            wetness=wettest / 100.0,
            puddles=weather.precipitation_deposits / 100.0,
        )
