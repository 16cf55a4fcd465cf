"""The image rows that show the ground."""

import numpy as np

from vpf_sim.geometry import horizon_px
from vpf_sim.types import Camera


def ground_top(camera: Camera) -> int:
    """The first image row that shows the road."""
    return int(np.clip(np.floor(horizon_px(camera)) + 1, 0, camera.height_px))
