"""Layouts of a road that moves on, below something that does not."""

import cv2
import numpy as np
import pytest

from vpf_sim.perception.obstacles.planar_parallax.windscreen_mask import (
    Grid,
    WindscreenMaskConfig,
    static_texture,
    texture,
)
from vpf_sim.seeding import stream
from vpf_sim.types import Image

CELL_M, CONFIG = 0.05, WindscreenMaskConfig()
ROWS, COLUMNS, STEP = 160, 100, 11  # of the patch, and by how many rows the road moves between two
ASPHALT = 90.0 + cv2.GaussianBlur(stream(41, "asphalt").normal(0.0, 12.0, (ROWS + STEP, COLUMNS)), (0, 0), 2.0)
DROP = slice(60, 70), slice(40, 46)


def layout(row: int, is_wet: bool, line: bool = False) -> Grid:
    """The road from a row on; a drop hides some of it, a line along the way lies on it."""
    patch = ASPHALT[row : row + ROWS].copy()
    if line:
        patch[:, 20:23] += 60.0
    if is_wet:
        patch[DROP] = 140.0
    levels: Image = np.clip(patch, 0, 255).astype(np.uint8)
    return texture(levels, CELL_M, CONFIG)


def water(seen: tuple[bool, bool], line: bool = False) -> Image:
    """What stays from one layout to the next, when there is a drop in the first or the second."""
    now, before = layout(STEP, seen[1], line), layout(0, seen[0], line)
    moved = np.vstack([before[STEP:], np.zeros((STEP, COLUMNS), np.float32)])
    return static_texture(now, before, moved, CELL_M, CONFIG)


def test_a_drop_is_water_and_the_road_about_it_is_not() -> None:
    stays = water((True, True))
    assert stays[DROP][0].all()  # its rims, and what is between them is not far
    assert stays[DROP][-1].all()
    stays[DROP[0].start - 12 : DROP[0].stop + 12, DROP[1].start - 6 : DROP[1].stop + 6] = 0
    assert stays.mean() < 0.02


@pytest.mark.parametrize("seen", [(True, False), (False, True), (False, False)])
def test_what_is_seen_once_only_is_no_water(seen: tuple[bool, bool]) -> None:
    assert water(seen).mean() < 0.02


def test_a_line_along_the_way_is_no_water() -> None:
    assert water((False, False), line=True).mean() < 0.02


@pytest.mark.parametrize("wrong", [{"least_way_m": 0.0}, {"contrast": -1.0}, {"share": 1.0}])
def test_nonsense_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="expected"):
        WindscreenMaskConfig(**wrong)
