"""How a wet road reflects, by the weather and the camera."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.rain.puddles import covered_table, road_table, water_level
from vpf_sim.types import Camera, Floats, Image

REFINEMENT = 2  # image pixels per pixel of the reflection, each way
WATER_INDEX = 1.333
DAMP_SHARE, FILM_SHARE = 0.35, 0.9  # reflecting share of a damp and of a flooded road
DAMP_SLOPE_DEG, FILM_SLOPE_DEG = 3.0, 1.2  # slopes of the facets
STONES_MMPH, FILM_MMPH = 8.0, 25.0  # rain rates between which the film covers the stones
RIPPLE = 5.0  # rows by which drops distort reflections in puddles, in hard rain
STEEP, STEEPEST = 0.30, 0.41  # sines of the angle at which reflections (16 %) start to fade, and are left out


@dataclass(frozen=True, slots=True)
class Wetness:
    """How a wet road reflects, on a canvas of half the image's resolution from the first row of the ground down.

    The reflected share is Fresnel's for flat water (n = 1.333) times the covered share of the road. Below about 10 mm/h
    the stones of the asphalt pierce the film, from 25 mm/h on the film is closed (Gallaway et al. 1971, TTI report
    138-5). A facet tilted by s moves distant reflections by 2 f s up or down, and hardly sideways.
    """

    reflectance: Image  # (rows, columns) of 255
    share: Image  # (256,) wet share of the road by depth of the water, of 255
    level: float  # depth from which water stands
    smear: int  # rows over which facets spread reflections
    ripple: int  # rows by which drops move reflections in puddles

    @classmethod
    def of(cls, camera: Camera, atmosphere: Atmosphere) -> "Wetness | None":
        """The reflection of a weather; None where the road is dry or not in the image."""
        top = ground_top(camera)
        if atmosphere.wetness <= 0.0 or not REFINEMENT <= top < camera.height_px:
            return None
        sines = _sines(camera, top)
        fading = np.clip((sines - STEEPEST) / (STEEP - STEEPEST), 0.0, 1.0)
        rows = int((fading.max(axis=1) > 0.0).sum())
        film = float(np.clip((atmosphere.rain_mmph - STONES_MMPH) / (FILM_MMPH - STONES_MMPH), 0.0, 1.0))
        share = min(1.0, 2.0 * atmosphere.wetness) * (DAMP_SHARE + film * (FILM_SHARE - DAMP_SHARE))
        slope = np.radians(DAMP_SLOPE_DEG + film * (FILM_SLOPE_DEG - DAMP_SLOPE_DEG))
        return cls(
            reflectance=np.rint(255.0 * reflectance(sines) * fading)[:rows].astype(np.uint8),
            share=np.maximum(covered_table(atmosphere.puddles), np.rint(share * road_table())).astype(np.uint8),
            level=water_level(atmosphere.puddles),
            smear=2 * round(2.0 * camera.fy_px * slope / REFINEMENT) + 1,
            ripple=round(RIPPLE * min(1.0, atmosphere.rain_mmph / FILM_MMPH) / REFINEMENT),
        )


def _sines(camera: Camera, top: int) -> Floats:
    """(rows, columns) sine of the angle between ray and road."""
    rows, columns = ceil((camera.height_px - top) / REFINEMENT), camera.width_px // REFINEMENT
    x = ((np.arange(columns) + 0.5) * REFINEMENT - 0.5 - camera.cx_px) / camera.fx_px
    y = ((np.arange(rows) + 0.5) * REFINEMENT - 0.5 + top - camera.cy_px) / camera.fy_px
    right, down = np.meshgrid(x, y)
    fall = down * np.cos(camera.pitch_rad) + np.sin(camera.pitch_rad)
    return np.asarray(fall / np.sqrt(right**2 + down**2 + 1.0))


def reflectance(sine: Floats) -> Floats:
    """Fresnel reflectance of water for unpolarised light, by the sine of the grazing angle."""
    refracted = np.sqrt(1.0 - (1.0 - sine**2) / WATER_INDEX**2)  # cosine of the angle of refraction
    across = (sine - WATER_INDEX * refracted) / (sine + WATER_INDEX * refracted)
    along = (WATER_INDEX * sine - refracted) / (WATER_INDEX * sine + refracted)
    return np.asarray(0.5 * (across**2 + along**2))
