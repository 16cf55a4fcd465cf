"""The trees of a road as content of the core."""

from functools import lru_cache
from math import ceil

import cv2
import numpy as np

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.trees import (
    CLEAR_TRANSMISSION,
    FADED_IN,
    HAZE_STEP_M,
    NOON,
    RANGES_M,
    VARIANTS,
    Trees,
    tree_picture,
)
from vpf_sim.types import Floats, Image


def plant(core: Core, trees: Trees, light: Light, haze: Haze) -> None:
    """Set the trees of a road."""
    tint = tuple((np.ones(3) if light.has_lamps else (light.sky + 0.5 * light.direct) / NOON).tolist())
    pictures = [tree_picture(variant) for variant in range(VARIANTS)]
    for variant, range_m in enumerate(RANGES_M):
        core.add_tree(range_m, _tinted(variant, tint), _hazes(range_m, light, haze))
    frames = np.array([(p.left, p.top, p.width, p.height) for p in pictures])
    placed = frames[trees.variants] * trees.heights_m[:, None]
    core.plant(np.column_stack([trees.feet_m, placed, trees.variants]))


@lru_cache(maxsize=4 * VARIANTS)
def _tinted(variant: int, tint: tuple[float, ...]) -> list[Image]:
    """A tree's picture in a light, with mip levels. Cached: roads of one weather have one light."""
    colours = np.diag([*tint, 1.0])
    return [np.asarray(cv2.transform(level, colours), np.uint8) for level in tree_picture(variant).levels]


def _hazes(range_m: float, light: Light, haze: Haze) -> Floats:
    """(n, 5) factor of the colours, opacity, and RGB of the air's light, by distance step.

    A pixel of coverage a and premultiplied colour a c, at transmission t and tree opacity o, becomes
    o (t a c + (1 - t) a h), with the horizon's colour h, and the transparency 1 - o a.
    """
    depths_m = np.arange(0.5, ceil(range_m / HAZE_STEP_M), dtype=np.float64) * HAZE_STEP_M
    left = haze.transmission(depths_m)
    left = np.where(left < CLEAR_TRANSMISSION, left, 1.0)
    opacity = np.clip((range_m - depths_m) / (range_m * (1.0 - FADED_IN)), 0.0, 1.0)
    airlight = (opacity * (1.0 - left))[:, None] * light.horizon
    return np.column_stack([opacity * left, opacity, airlight])
