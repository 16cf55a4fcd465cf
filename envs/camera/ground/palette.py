"""The ground's palette: one ramp from dark grass over gravel and asphalt to white paint."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Floats

# (value, red, green, blue)
RAMP = np.array(
    [
        (0, 38, 52, 20),
        (25, 62, 80, 32),
        (45, 88, 104, 46),
        (60, 116, 124, 62),
        (80, 138, 132, 92),
        (98, 128, 121, 103),
        (124, 104, 102, 97),
        (138, 92, 92, 93),
        (150, 106, 106, 107),
        (200, 166, 166, 165),
        (222, 214, 213, 208),
        (240, 244, 243, 238),
        (255, 250, 249, 245),
    ],
    float,
)


# (value, gain of the grain)
STRENGTH = np.array([(0, 1.2), (60, 1.2), (98, 1.3), (138, 1.0), (160, 1.0), (222, 0.6)])
BLOTCHES = np.array([(0, 0.3), (70, 0.3), (98, 0.12), (138, 0.05), (222, 0.05)])  # (value, gain of the coarse noise)
ASPHALT_GREY, PAINT_GREY = 106.0, 255.0
WET_FACTOR = 0.6  # brightness of wet over dry asphalt (Angstrom 1925)
WET_SHARE = np.array([(60, 0.5), (124, 1.0)])  # (value, share of the wetting effect): less for leaves than for stone


def ground_table(light: Light, wetness: float, ramp: Floats = RAMP) -> NDArray[np.uint8]:
    """(256, 1, 3) RGB of the palette values under a light, for cv2.applyColorMap; wetness is 0 to 1.

    The ramp, (value, red, green, blue), holds the colours of ClearNoon. Wet surfaces are darker and more saturated: a
    power law keeps bright paint bright (Lagarde, "Water drop 3", 2013) and gives asphalt 0.6 of its brightness.
    """
    return _table(_wet(ramp, wetness) * light.ground / _noon().ground)


def lamp_table(wetness: float, ramp: Floats, efficiency: Floats) -> NDArray[np.uint8]:
    """(256, 1, 3) RGB of the palette values in full light of lamps; `efficiency` is (256,), see `paint_efficiency`."""
    return _table(_wet(ramp, wetness) * efficiency[:, None])


def _wet(ramp: Floats, wetness: float) -> Floats:
    """(256, 3) RGB of the palette values at ClearNoon, on a wet surface."""
    values = np.arange(256)
    colours = np.stack([np.interp(values, ramp[:, 0], ramp[:, i]) for i in (1, 2, 3)], axis=1)
    soaked = wetness * np.interp(values, WET_SHARE[:, 0], WET_SHARE[:, 1])[:, None]
    exponent = 1.0 + soaked * np.log(WET_FACTOR) / np.log(ASPHALT_GREY / PAINT_GREY)
    return np.asarray(PAINT_GREY * (colours / PAINT_GREY) ** exponent)


def _table(colours: Floats) -> NDArray[np.uint8]:
    """(256, 1, 3) colours (256, 3) as 8 bits."""
    table: NDArray[np.uint8] = np.rint(np.clip(colours, 0.0, 255.0)[:, None, :]).astype(np.uint8)
    return table


@lru_cache(maxsize=1)
def grain_strength() -> NDArray[np.float32]:
    """(256,) gain of the grain for each palette value, 1 on asphalt."""
    return np.asarray(np.interp(np.arange(256), STRENGTH[:, 0], STRENGTH[:, 1]), np.float32)


@lru_cache(maxsize=1)
def blotch_strength() -> NDArray[np.float32]:
    """(256,) gain of the coarse noise for each palette value."""
    return np.asarray(np.interp(np.arange(256), BLOTCHES[:, 0], BLOTCHES[:, 1]), np.float32)


@lru_cache(maxsize=1)
def _noon() -> Light:
    return Light.of(weather.PRESETS["ClearNoon"])
