"""Billboards of trees in the light of lamps, which falls off upwards."""

import cv2
import numpy as np

from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.view import View
from vpf_sim.geometry import horizon_px
from vpf_sim.types import Floats, Image

LEVELS = 8  # heights of a tree at which the light is worked out
SHARES = (np.arange(LEVELS) + 0.5) / LEVELS


def tree_factors(
    lamplight: Lamplight, view: View, feet_m: Floats, depths_m: Floats, tops_px: Floats, rows: Floats
) -> Floats:
    """(n, LEVELS, 1, 4) RGB factors, and 1 for the transparency, from the top of each image down.

    Trees stand at `feet_m` (n, 2); their images begin at the row `tops_px` (n,) and have `rows` (n,).
    """
    camera = view.camera
    places_px = tops_px[:, None] + SHARES * rows[:, None]
    points = np.empty((*places_px.shape, 3))
    points[..., :2] = feet_m[:, None]
    fall_m = (places_px - horizon_px(camera)) / camera.fy_px * depths_m[:, None]
    points[..., 2] = np.maximum(camera.height_m - fall_m, 0.0)
    factors = np.ones((*places_px.shape, 1, 4), np.float32)
    factors[..., 0, :3] = lamplight.on_leaves(view, points.reshape(-1, 3)).reshape(*places_px.shape, 3)
    return factors


def lit(picture: Image, factors: Floats) -> Image:
    """(h, w, 4) a tree's image under the `factors` (LEVELS, 1, 4)."""
    rows = cv2.resize(factors, (1, len(picture)), interpolation=cv2.INTER_LINEAR).reshape(-1, 1, 4)
    return np.asarray(np.minimum(picture * rows, np.float32(255.0)), np.uint8)
