"""Layouts of a road that moves on, below something that does not."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from driver_settings import static_obstacles, without

from vpf_sim.perception.obstacles.planar_parallax.grids import Grid
from vpf_sim.perception.obstacles.planar_parallax.windscreen_mask import static_texture, texture
from vpf_sim.seeding import stream
from vpf_sim.types import Image

CELL_M, CONFIG = 0.05, static_obstacles().planar_parallax.windscreen_mask
assert CONFIG is not None
ROWS, COLUMNS, STEP = 160, 100, 11  # of the patch, and by how many rows the road moves between two
ASPHALT = 90.0 + cv2.GaussianBlur(stream(41, "asphalt").normal(0.0, 12.0, (ROWS + STEP, COLUMNS)), (0, 0), 2.0)
DROP = slice(60, 70), slice(40, 46)


def layout(row: int, is_wet: bool, line: bool = False) -> Grid:
    """Texture of the road from a row on, with a drop or a line along the way."""
    patch = ASPHALT[row : row + ROWS].copy()
    if line:
        patch[:, 20:23] += 60.0
    if is_wet:
        patch[DROP] = 140.0
    levels: Image = np.clip(patch, 0, 255).astype(np.uint8)
    return texture(levels, CELL_M, CONFIG)


def water(seen: tuple[bool, bool], line: bool = False) -> Image:
    """The mask of two layouts, with a drop in the first, the second, or both."""
    now, before = layout(STEP, seen[1], line), layout(0, seen[0], line)
    moved = np.vstack([before[STEP:], np.zeros((STEP, COLUMNS), np.float32)])
    return static_texture(now, before, moved, CELL_M, CONFIG)


def test_a_drop_is_masked_and_the_road_about_it_is_not() -> None:
    stays = water((True, True))
    assert stays[DROP][0].all()  # its rims, and what is between them is not far
    assert stays[DROP][-1].all()
    stays[DROP[0].start - 12 : DROP[0].stop + 12, DROP[1].start - 6 : DROP[1].stop + 6] = 0
    assert stays.mean() < 0.02


@pytest.mark.parametrize("seen", [(True, False), (False, True), (False, False)])
def test_a_drop_in_one_layout_only_is_not_masked(seen: tuple[bool, bool]) -> None:
    assert water(seen).mean() < 0.02


def test_a_line_along_the_way_is_not_masked() -> None:
    assert water((False, False), line=True).mean() < 0.02


@pytest.mark.parametrize("wrong", [{"least_way_m": 0.0}, {"contrast": -1.0}, {"share": 1.0}])
def test_wrong_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="expected"):
        replace(CONFIG, **wrong)


def test_without_the_rim_fewer_cells_are_masked() -> None:
    now, before = layout(STEP, is_wet=True), layout(0, is_wet=True)
    moved = np.vstack([before[STEP:], np.zeros((STEP, COLUMNS), np.float32)])
    bare = static_texture(now, before, moved, CELL_M, without(CONFIG, "rim"))
    assert 0 < bare.sum() < water((True, True)).sum()


def test_without_road_motion_a_kerb_across_the_way_that_repeats_is_masked() -> None:
    """Stripes each STEP rows agree in place as well as moved."""
    rows = np.arange(ROWS + STEP)
    stripes = np.tile(((rows % STEP) < STEP // 2)[:, None] * 80, (1, COLUMNS)).astype(np.uint8)
    now, before = texture(stripes[STEP:], CELL_M, CONFIG), texture(stripes[:ROWS], CELL_M, CONFIG)
    low = replace(CONFIG, contrast=0.1)
    assert static_texture(now, before, before, CELL_M, low).mean() == 0.0
    assert static_texture(now, before, before, CELL_M, without(low, "road_motion")).mean() > 0.5
