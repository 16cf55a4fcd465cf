"""Strength of the grain by distance, for an even image.

If the gradient grew from row to row, Lucas-Kanade would follow the rows at the sharper end of its window, which move at
another speed.
"""

from functools import lru_cache
from math import sqrt

import numpy as np
from scipy.ndimage import gaussian_filter1d

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.grain import Grain
from vpf_sim.envs.camera.ground.levels import Level, levels
from vpf_sim.envs.camera.ground.patches import patch_of, sample
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

GRADIENT = 2.7  # rms difference between neighbouring pixels of a row, in steps of the palette, at full detail
VIEWS = 6


@lru_cache(maxsize=4)
def even_gains(camera: Camera) -> tuple[Floats, ...]:
    """The grain's gain for each level that gives all rows the same gradient.

    Measured on a few views: one factor for a near level, (rows, 1) for a far level.
    """
    return tuple(_gain(camera, level) for level in levels(camera))


def _gain(camera: Camera, level: Level) -> Floats:
    patch = patch_of(camera, level, Grain(level, 0).draw)
    energies = []
    for place in stream(0, "grain gains").uniform(-500.0, 500.0, (VIEWS, 2)):
        view = View.at(camera, place, 0.0)
        patch.update(view, may_defer=False)
        if not level.steep:
            energies.append(_energy(patch.pixels))
            continue
        for band in level.bands:
            rows = np.empty((band.last - band.first, camera.width_px), np.uint8)
            sample(patch, band, view.ground_homography(), rows)
            energies.append(np.mean(_energy(rows), keepdims=True))
    gradient = np.sqrt(np.mean(energies, axis=0))
    return np.asarray(GRADIENT * sqrt(detail(camera)) / gaussian_filter1d(gradient, 1.5)[:, None], np.float32)


def _energy(rows: Image) -> Floats:
    return np.asarray(np.mean(np.diff(rows.astype(np.float32), axis=1) ** 2, axis=1))
