"""Light of a weather: factors of sun and sky for surfaces, and the colours of the sky.

All colours and factors hold for the finished image (gamma 2.2) after automatic exposure.
"""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.daylight import Daylight, cloud_cover
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Floats

GAMMA = 2.2
NOON_LEVEL = 1.04  # exposure target for a horizontal surface at ClearNoon
ALBEDO = 0.2  # of the metered ground
CLEAR_HORIZON, COVERED_HORIZON = 2.5, 0.9  # brightness of the horizon over the sky's mean
WHITE_LX = 30.0  # the exposure's limit: illuminance of a horizontal surface that then has a factor of 1
LAMPS_LX = 1000.0  # vehicles switch their lamps on below this (UN Regulation 48, paragraph 6.2.7.6 and annex 12)
RAIN_DARKENS = 0.13  # loss of the sky's brightness in hard rain, beyond the exposure's correction
OPAQUE_FOG_PER_M = 0.008  # extinction at which fog hides the sky
BLUE = np.array([-0.05, 0.0, 0.07])  # tint of skylight under a clear sky
WARM = np.array([0.09, 0.0, -0.14])  # tint of skylight with the sun at 5 deg

# Colours of the sky, means over all directions, with a high sun and with the sun at 5 deg; chosen by eye.
HORIZON = np.array([[206.0, 219.0, 231.0], [244.0, 205.0, 162.0]])
ZENITH = np.array([[92.0, 136.0, 198.0], [82.0, 108.0, 160.0]])
CLOUD = np.array([[246.0, 248.0, 250.0], [255.0, 214.0, 176.0]])
COVERED_HORIZON_RGB = np.array([[198.0, 203.0, 208.0], [190.0, 184.0, 180.0]])
COVERED_ZENITH_RGB = np.array([[214.0, 218.0, 224.0], [166.0, 167.0, 176.0]])
FOG = np.array([[201.0, 205.0, 209.0], [202.0, 195.0, 188.0]])

# The sky after sunset: its colours with the sun at -6 deg, the afterglow there, and the glow that is left at night.
TWILIGHT_DEG = 6.0
DUSK_HORIZON, DUSK_ZENITH = np.array([176.0, 158.0, 158.0]), np.array([62.0, 82.0, 128.0])
DUSK_CLOUD, AFTERGLOW = np.array([128.0, 122.0, 140.0]), np.array([255.0, 178.0, 118.0])
NIGHT_SKY = np.array([[46.0, 40.0, 38.0], [8.0, 9.0, 13.0], [8.0, 9.0, 13.0], [18.0, 17.0, 19.0]])  # as _sky_colours


@dataclass(frozen=True, slots=True)
class Light:
    """The shaded colour of a surface is colour x (sky + direct x max(0, normal . sun)), per channel."""

    sun: Floats  # (3,) unit vector towards the sun, world axes with z up
    direct: Floats  # (3,) RGB factor of the sun
    sky: Floats  # (3,) RGB factor of the sky
    horizon: Floats  # (3,) RGB 0..255 of the sky at the horizon and of the airlight
    zenith: Floats  # (3,) RGB 0..255, clouds included
    shadow: float  # brightness of the road in shadow over that in the sun, 0..1
    contact: float  # the same right under an object
    cover: float  # cloud cover, 0..1
    gap: Floats  # (3,) RGB 0..255 of the zenith between the clouds
    cloud: Floats  # (3,) RGB 0..255 of the brightest clouds
    afterglow: Floats  # (3,) RGB 0..255 of the sky towards a sun below the horizon; black by day
    white_lx: float  # illuminance of a horizontal surface that has a factor of 1
    has_lamps: bool  # whether it is so dark that vehicles have their lamps on

    @classmethod
    def of(cls, weather: Weather) -> "Light":
        """The light of a weather."""
        atmosphere, cover = Atmosphere.of(weather), cloud_cover(weather)
        daylight = Daylight.of(weather, atmosphere)
        direct, sky = _factors(daylight, cover, weather)
        sun = _towards_sun(weather)
        level = sky + direct * max(sun[2], 0.0)
        exposed = _exposed(daylight, cover)
        night = _night(daylight, exposed)
        horizon, zenith, gap, cloud = _sky_colours(weather, atmosphere, cover) * night + NIGHT_SKY * (1.0 - night)
        return cls(
            sun=sun,
            direct=direct,
            sky=sky,
            horizon=horizon,
            zenith=zenith,
            shadow=float(np.mean(sky / level)),
            contact=0.27,
            cover=cover,
            gap=gap,
            cloud=cloud,
            afterglow=AFTERGLOW * (night if weather.sun_altitude_angle < 0.0 else 0.0),
            white_lx=max(WHITE_LX, 1e3 * daylight.ground_klx / exposed**GAMMA),
            has_lamps=1e3 * daylight.ground_klx < LAMPS_LX,
        )

    @property
    def ground(self) -> Floats:
        """(3,) RGB factor of a horizontal surface."""
        return self.sky + self.direct * max(float(self.sun[2]), 0.0)


def _towards_sun(weather: Weather) -> Floats:
    altitude, azimuth = radians(weather.sun_altitude_angle), radians(weather.sun_azimuth_angle)
    return np.array([cos(altitude) * cos(azimuth), cos(altitude) * sin(azimuth), sin(altitude)])


def _lowness(weather: Weather) -> float:
    """0 for a high sun to 1 for a sun at 5 deg or below."""
    return min(max((30.0 - weather.sun_altitude_angle) / 25.0, 0.0), 1.0)


def _factors(daylight: Daylight, cover: float, weather: Weather) -> tuple[Floats, Floats]:
    """(3,) RGB factors of the sun and of the sky.

    Light adds up before the gamma, not after it. So the sun's factor is a compromise: the mean of the factors that are
    right for the ground and for a face towards the sun.
    """
    total = max(daylight.ground_klx, 1e-6)
    exposed = _exposed(daylight, cover)
    level = exposed * _night(daylight, exposed) * (1.0 - 0.5 * RAIN_DARKENS * weather.precipitation / 100.0)
    shade = level * (daylight.sky_klx / total) ** (1.0 / GAMMA)
    facing = level * ((daylight.sky_klx + daylight.sun_klx) / total) ** (1.0 / GAMMA)
    height = max(sin(radians(weather.sun_altitude_angle)), 0.1)
    direct = 0.5 * (level - shade) / height + 0.5 * (facing - shade)
    low = _lowness(weather) * (1.0 - _twilight(weather))
    blue = BLUE * (1.0 - cover) * (1.0 - low)
    return direct * daylight.sun_colour ** (1.0 / GAMMA) * (1.0 - blue), shade * (1.0 + blue + WARM * low)


def _exposed(daylight: Daylight, cover: float) -> float:
    """The factor of a horizontal surface; the exposure keeps the mean of ground and horizon constant."""
    horizon = CLEAR_HORIZON + (COVERED_HORIZON - CLEAR_HORIZON) * cover
    share = daylight.ground_klx / (ALBEDO * daylight.ground_klx + horizon * daylight.sky_klx)
    return float(NOON_LEVEL * (share / NOON_SHARE) ** (1.0 / GAMMA))


def _night(daylight: Daylight, exposed: float) -> float:
    """The loss of brightness where the exposure is at its limit, 0 to 1."""
    return float(min(1.0, 1e3 * daylight.ground_klx / (WHITE_LX * exposed**GAMMA)) ** (1.0 / GAMMA))


def _twilight(weather: Weather) -> float:
    """0 while the sun is up to 1 with the sun at -6 deg or below."""
    return min(max(-weather.sun_altitude_angle / TWILIGHT_DEG, 0.0), 1.0)


def _sky_colours(weather: Weather, atmosphere: Atmosphere, cover: float) -> Floats:
    """(4, 3) RGB 0..255 of the horizon, the zenith, the gaps between the clouds, and the clouds."""
    low = _lowness(weather)
    clear_horizon, gap, cloud, covered_horizon, covered_zenith, fog = (
        colours[0] + (colours[1] - colours[0]) * low
        for colours in (HORIZON, ZENITH, CLOUD, COVERED_HORIZON_RGB, COVERED_ZENITH_RGB, FOG)
    )
    dusk = _twilight(weather)
    clear_horizon, gap, cloud = (
        colour + (late - colour) * dusk
        for colour, late in ((clear_horizon, DUSK_HORIZON), (gap, DUSK_ZENITH), (cloud, DUSK_CLOUD))
    )
    horizon = clear_horizon + (covered_horizon - clear_horizon) * cover
    cloud = cloud + (covered_zenith - cloud) * cover
    gap = gap + (covered_zenith - gap) * cover**3
    zenith = gap + (cloud - gap) * cover
    colours = np.array([horizon, zenith, gap, cloud]) * (1.0 - RAIN_DARKENS * weather.precipitation / 100.0)
    foggy = min(1.0, 3.0 / atmosphere.visibility_m / OPAQUE_FOG_PER_M)
    return np.asarray(colours + (fog - colours) * foggy)


NOON_SHARE = 82.8 / (ALBEDO * 82.8 + (CLEAR_HORIZON + (COVERED_HORIZON - CLEAR_HORIZON) * 0.05) * 15.6)  # ClearNoon's
