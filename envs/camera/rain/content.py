"""Hands the wet road and its spray over to the core."""

from typing import Any

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.rain.puddles import CELL_M, HeightMap, Puddles
from vpf_sim.envs.camera.rain.spray import LIT_BY_LAMPS, OPACITY, VARIANTS, puff_picture
from vpf_sim.envs.camera.rain.wetness import Wetness
from vpf_sim.seeding import stream


class WetSurface:
    """The puddles around the camera, in the core."""

    def __init__(self, core: Core, wetness: Wetness, shapes: list[LaneShape], seed: int) -> None:
        self._core = core
        self._puddles = Puddles(shapes, seed)
        self._given: HeightMap | None = None
        level = min(int(wetness.level), 255)
        own_seed = int(stream(seed, "rain on puddles").integers(0, 2**63))
        core.set_wet_road(wetness.reflectance, wetness.share, level, wetness.smear, wetness.ripple, own_seed)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """The core of a copy has no puddles yet."""
        self.__dict__.update(state)
        self._given = None

    def update(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Go to a place."""
        near = self._puddles.height_map(x_m, y_m, yaw_rad)
        if near is not self._given:
            x, y = near.corner_m.tolist()
            self._core.set_puddles(near.depths, (x, y), CELL_M)
            self._given = near


def wet_surface(
    core: Core, shapes: list[LaneShape], light: Light, atmosphere: Atmosphere, seed: int
) -> WetSurface | None:
    """The road's water, in the core; None where it is dry."""
    wetness = Wetness.of(core.camera, atmosphere)
    if wetness is None:
        return None
    strength = OPACITY * min(1.0, max(atmosphere.wetness, atmosphere.puddles))
    pictures = np.stack([puff_picture(variant) for variant in range(VARIANTS)])
    colour = np.maximum(light.horizon, LIT_BY_LAMPS) if light.has_lamps else light.horizon
    core.set_spray(strength, colour, pictures, int(stream(seed, "spray").integers(0, 2**63)))
    return WetSurface(core, wetness, shapes, seed)
