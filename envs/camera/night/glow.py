"""The image of a lamp that shines into the camera: a point spread over the lens."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log2, pi

import numpy as np

from vpf_sim.envs.camera.light import GAMMA
from vpf_sim.types import Camera, Floats, Image

SHARP_PX = 0.8  # standard deviation of the point spread, for 640 px over 90 deg
GLARE, GLARE_PX = 0.04, 3.0  # share of the light that lens and glass scatter, and the extent of this
STEPS = 4  # brightness levels per power of 2
FAINTEST = 3.0  # grey levels; the image ends where it is fainter
LARGEST_PX = 72  # radius of an image
FAINTEST_FLUX = 0.02  # pixels of full brightness; fainter lamps are left out
WHITE_CD_M2 = 0.175  # luminance of a grey level of 255 for each lx of `white_lx`: of a surface of 0.55 / pi


GlowKind = tuple[int, tuple[float, float, float], float]  # brightness level, colour, diameter in px


@dataclass(frozen=True, slots=True)
class Lamp:
    """A lamp in one frame."""

    x_px: float
    y_px: float
    depth_m: float
    flux: float  # light at the camera, in pixels of full brightness
    colour: tuple[float, float, float]  # linear RGB
    size_px: float  # diameter


def flux_px(camera: Camera, lux: float, white_lx: float) -> float:
    """Light of `lux` at the camera, in pixels of full brightness."""
    return lux * camera.fx_px**2 / (WHITE_CD_M2 * white_lx)


def kind_of_glow(lamp: Lamp) -> GlowKind | None:
    """What the lamp's image depends on, in steps; None if it is too faint."""
    if lamp.flux < FAINTEST_FLUX:
        return None
    return round(STEPS * log2(lamp.flux)), lamp.colour, round(2.0 * lamp.size_px) / 2.0


@lru_cache(maxsize=256)
def glow_picture(level: int, colour: tuple[float, float, float], size_px: float, fx_px: float) -> Image:
    """(n, n, 4) a lamp in its middle: 255 (flux x spread)^(1 / 2.2), and full transparency."""
    flux, scale = 2.0 ** (level / STEPS), fx_px / 320.0
    radius = 2
    while radius < LARGEST_PX * scale and _levels(flux, np.array([float(radius)]), size_px, scale)[0] > FAINTEST:
        radius += 2
    radius = ceil(radius) + 1
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    distance = np.hypot(x, y)
    spread = _spread(distance, size_px, scale)
    rim = np.clip(1.0 - (distance / radius) ** 2, 0.0, 1.0)[..., None]  # fades out instead of ending
    light = 255.0 * np.minimum(flux * spread[..., None] * np.array(colour), 1.0) ** (1.0 / GAMMA) * rim
    return np.dstack([np.rint(light), np.full(distance.shape, 255.0)]).astype(np.uint8)


def _spread(distance_px: Floats, size_px: float, scale: float) -> Floats:
    """1/px2, the point spread: a Gaussian as wide as the lamp, and glare with (1 + (r / r0)^2)^-1.5."""
    variance = (SHARP_PX * scale) ** 2 + (0.25 * size_px) ** 2
    core = np.exp(-0.5 * distance_px**2 / variance) / (2.0 * pi * variance)
    extent = GLARE_PX * scale
    glare = (1.0 + (distance_px / extent) ** 2) ** -1.5 / (2.0 * pi * extent**2)
    return np.asarray((1.0 - GLARE) * core + GLARE * glare)


def _levels(flux: float, distance_px: Floats, size_px: float, scale: float) -> Floats:
    return np.asarray(255.0 * (flux * _spread(distance_px, size_px, scale)) ** (1.0 / GAMMA))
