"""The sky dome as a panorama: gradient, glow around the sun, clouds.

Clouds lie on a layer, so they get smaller and flatter towards the horizon.
"""

from functools import lru_cache
from math import ceil, radians
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.texture import noise
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

FEWEST_COLUMNS, MOST_COLUMNS = 256, 2048
ZENITH_SLOPE = 1.2  # tangent of the elevation above which the colour is constant
LAYER_M = 1200.0  # height of the clouds
TILE, TILE_HEIGHTS = 1024, 20.0  # texels of the cloud field, and its size in heights of the layer
FLATTEST = 0.22  # added to a ray's slope, like the Earth's curvature
SOFTNESS = 0.6  # of a cloud's edge, in standard deviations of the field
HAZE_SHARE = 0.25  # mean extinction up to the clouds over that at the ground
GLOW_RAD, BLOOM_RAD = 0.4, radians(2.0)  # extent of the sun's glow, and of its disc with lens bloom
NOON_SUN = 0.65  # sun factor at ClearNoon
SUN_HAZE_M = 1000.0  # path at ground extinction that attenuates the glow


def sky_dome(light: Light, atmosphere: Atmosphere, per_rad: float, rng: np.random.Generator) -> Image:
    """(rows, columns, 3) RGB panorama with about `per_rad` columns per rad.

    Column i is the azimuth 2 pi i / columns; rows are linear in the tangent of the elevation, from ZENITH_SLOPE to 0.
    """
    columns = min(max(ceil(2.0 * np.pi * per_rad), FEWEST_COLUMNS), MOST_COLUMNS)
    rows = round(columns / (2.0 * np.pi) * ZENITH_SLOPE) + 1
    slope, azimuth = np.meshgrid(
        np.linspace(ZENITH_SLOPE, 0.0, rows), np.arange(columns) * (2.0 * np.pi / columns), indexing="ij"
    )
    angle = _angle_to_sun(light, slope, azimuth)
    behind = (1.0 - light.cover) * np.exp(-SUN_HAZE_M * atmosphere.extinction_per_m)  # broken clouds glow too
    sun = min(max(float(light.direct.mean()) / NOON_SUN, float(behind)), 1.0)
    warm = light.afterglow if light.afterglow.any() else 255.0 * light.direct / max(float(light.direct.max()), 1e-6)
    sky = _gradient(light, slope)
    glow = 0.7 * sun * np.exp(-angle / GLOW_RAD)[..., None]
    sky += (np.maximum(warm, sky) - sky) * glow
    opacity, tone = _clouds(light, atmosphere, slope, azimuth, rng)
    lit = light.horizon + (light.cloud - light.horizon) * np.sqrt(slope / ZENITH_SLOPE)[..., None]
    lit += (np.maximum(warm, lit) - lit) * glow
    sky += (lit * tone[..., None] - sky) * opacity[..., None]
    disc = sun * (1.0 - 0.7 * opacity) * np.minimum(1.0, 1.6 * np.exp(-angle / BLOOM_RAD))
    sky += (255.0 - sky) * disc[..., None]
    return np.clip(np.rint(sky), 0, 255).astype(np.uint8)


def _angle_to_sun(light: Light, slope: Floats, azimuth: Floats) -> Floats:
    """rad, angle between directions and the sun."""
    scale = 1.0 / np.hypot(1.0, slope)
    cosine = (np.cos(azimuth) * light.sun[0] + np.sin(azimuth) * light.sun[1] + slope * light.sun[2]) * scale
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _gradient(light: Light, slope: Floats) -> Floats:
    """(..., 3) colour of the clear sky."""
    share = (slope / ZENITH_SLOPE)[..., None] ** 0.7
    return np.asarray(light.horizon + (light.gap - light.horizon) * share)


def _clouds(
    light: Light, atmosphere: Atmosphere, slope: Floats, azimuth: Floats, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Opacity of the clouds, 0 to 1, and their brightness about 1.

    A threshold on Gaussian noise sets the cover. Thick parts are darker, sides towards the sun brighter, and haze
    lowers the contrast of distant clouds.
    """
    heights = 1.0 / (slope + FLATTEST)
    x, y = heights * np.cos(azimuth), heights * np.sin(azimuth)
    origin, heading = rng.uniform(0.0, TILE_HEIGHTS, 2), rng.uniform(0.0, 2.0 * np.pi)
    field = _field(x, y, origin, heading)
    sunward = field - _field(x + 0.12 * light.sun[0], y + 0.12 * light.sun[1], origin, heading)
    threshold = -NormalDist().inv_cdf(min(max(light.cover, 1e-3), 0.999))
    dense = field - threshold
    clear = np.exp(-HAZE_SHARE * atmosphere.extinction_per_m * LAYER_M * heights)
    opacity = np.clip(dense / SOFTNESS + 0.5, 0.0, 1.0)
    opacity = opacity**2 * (3.0 - 2.0 * opacity) * min(1.0, 0.45 + 0.9 * light.cover)
    thick = np.clip(dense, 0.0, 4.0)
    broken = 4.0 * light.cover * (1.0 - light.cover)
    shade = -0.08 * thick - 0.04 * (field if light.cover > 0.9 else 0.0) + (0.02 + 0.10 * broken) * sunward
    mean = -0.08 * min(max(-threshold, 0.0), 4.0)  # keeps the mean brightness of an overcast sky
    return opacity * (0.15 + 0.85 * clear), 1.0 + (shade - mean) * (0.25 + 0.75 * clear)


def _field(x: Floats, y: Floats, origin: Floats, heading: float) -> Floats:
    """The cloud field at points of the layer, in layer heights from the zenith."""
    c, s = np.cos(heading), np.sin(heading)
    scale = TILE / TILE_HEIGHTS
    columns = np.mod((c * x - s * y + origin[0]) * scale, TILE).astype(np.float32)
    rows = np.mod((s * x + c * y + origin[1]) * scale, TILE).astype(np.float32)
    return np.asarray(cv2.remap(_tile(), columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP), np.float64)


@lru_cache(maxsize=1)
def _tile() -> NDArray[np.float32]:
    """(TILE, TILE) the cloud field, the same in every episode; a seed only places it."""
    return noise((TILE, TILE), stream(0, "clouds"), 6.0, 1.25).astype(np.float32)
