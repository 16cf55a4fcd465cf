"""The shift of rows by a rolling shutter, against interpolation in floating point."""

import numpy as np
import pytest

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.types import Camera


@pytest.mark.parametrize("shift_px", [0.0, 0.013, -0.4, 7.0, -1e9])
def test_each_row_is_moved_by_its_distance_from_the_middle(shift_px: float) -> None:
    camera = Camera(96, 60)
    frame = np.random.default_rng(0).integers(0, 256, (60, 96, 3), dtype=np.uint8)
    read = Core(camera, ground_top(camera)).read_out(frame, shift_px)
    for y in range(60):
        places = np.arange(96) + shift_px * (y - camera.cy_px)
        for channel in range(3):
            expected = np.interp(places, np.arange(96), frame[y, :, channel])  # the ends go on beyond it
            assert np.abs(read[y, :, channel] - expected).max() < 1.1  # places are rounded to 1 / 256 px
