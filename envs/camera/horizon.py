"""The image rows that show the ground."""

import numpy as np

from vpf_sim.types import Camera


def horizon_row(camera: Camera) -> float:
    """Image row of the horizon, px."""
    return float(camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad))


def ground_top(camera: Camera) -> int:
    """The first image row that shows the road."""
    return int(np.clip(np.floor(horizon_row(camera)) + 1, 0, camera.height_px))
