"""The image rows that show the ground."""

import numpy as np

from vpf_sim.types import Camera


def ground_top(camera: Camera) -> int:
    """The first image row that shows the road."""
    horizon = camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad)
    return int(np.clip(np.floor(horizon) + 1, 0, camera.height_px))
