"""Strength of the grain by distance, for an even image.

If the gradient grew from row to row, Lucas-Kanade would follow the rows at the sharper end of its window, which move at
another speed.
"""

from dataclasses import replace
from functools import lru_cache
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.content import NO_POLYGONS, Grains, add_level, noise_tiles
from vpf_sim.envs.camera.ground.levels import Level, levels
from vpf_sim.envs.camera.ground.rasters import raster_shape
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

GRADIENT = 2.7  # rms difference between neighbouring pixels of a row, in steps of the palette, at full detail
VIEWS = 6
MIDDLE = 128  # palette value of the measured ground


@lru_cache(maxsize=4)
def even_gains(camera: Camera) -> tuple[Floats, ...]:
    """The grain's gain for each level that gives all rows the same gradient.

    Measured on a few views: (1,) for a near level, (rows,) for a far level.
    """
    return tuple(_gain(camera, level) for level in levels(camera))


def _gain(camera: Camera, level: Level) -> Floats:
    core = _grey(camera, level)
    frame = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
    shape, top, energies = raster_shape(camera, level), ground_top(camera), []
    for x, y in stream(0, "grain gains").uniform(-500.0, 500.0, (VIEWS, 2)):
        core.begin(x, y, 0.0, 0.0, np.empty((0, 4)))
        core.draw_backdrop(frame)
        if not level.steep:
            energies.append(_energy(core.raster(0, shape.rows, shape.columns)))
            continue
        rows = [frame[top + band.first : top + band.last, :, 1] for band in level.bands]
        energies += [np.mean(_energy(part), keepdims=True) for part in rows]
    gradient = np.sqrt(np.mean(energies, axis=0))
    return np.asarray(GRADIENT * sqrt(detail(camera)) / gaussian_filter1d(gradient, 1.5))


def _grey(camera: Camera, level: Level) -> Core:
    """A core with one level of grey ground and its grain, at a gain of 1."""
    core, ones = Core(camera, ground_top(camera)), np.ones(256, np.float32)
    greys = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)
    haze = np.empty((0, 4), np.uint8)
    core.set_ground(greys, 1.0, MIDDLE, noise_tiles(), (ones, 0.0 * ones), haze, NO_POLYGONS, NO_POLYGONS)
    sharp = replace(level, bands=[replace(band, faded=False) for band in level.bands])
    add_level(core, sharp, Grains.of(camera, level, 0), np.ones((1, 2), np.float32))
    return core


def _energy(rows: NDArray[Any]) -> Floats:
    return np.asarray(np.mean(np.diff(rows.astype(np.float32), axis=1) ** 2, axis=1))
