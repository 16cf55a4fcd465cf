"""Valid camera frames, and the faults of invalid ones."""

import numpy as np
import pytest

from vpf_sim.envs.ending import frame_fault
from vpf_sim.types import Image

SHAPE = (120, 160, 3)


def picture(seed: int = 0) -> Image:
    return np.random.default_rng(seed).integers(0, 256, SHAPE, np.uint8)


def with_pixel(frame: Image, row: int, column: int) -> Image:
    changed = frame.copy()
    changed[row, column, 1] ^= 1
    return changed


def test_valid_frame_has_no_fault() -> None:
    assert frame_fault(picture(), SHAPE) is None
    assert frame_fault(picture(), SHAPE, last=picture(1)) is None


def test_frame_of_one_colour_is_invalid() -> None:
    assert frame_fault(np.zeros(SHAPE, np.uint8), SHAPE) == "black"
    assert frame_fault(np.full(SHAPE, [10, 20, 30], np.uint8), SHAPE) == "constant"


@pytest.mark.parametrize(("row", "column"), [(0, 0), (37, 41), (119, 159)])
def test_one_grey_level_in_one_pixel_is_a_difference(row: int, column: int) -> None:
    black, frame = np.zeros(SHAPE, np.uint8), picture()
    assert frame_fault(with_pixel(black, row, column), SHAPE) is None
    assert frame_fault(frame, SHAPE, last=with_pixel(frame, row, column)) is None


def test_repeated_frame_is_stale() -> None:
    assert frame_fault(picture(), SHAPE, last=picture()) == "stale"


@pytest.mark.parametrize(
    "frame", [picture()[1:], picture()[..., 0], picture().astype(float)], ids=["row", "grey", "float"]
)
def test_wrong_shape_or_type_is_reported(frame: Image) -> None:
    assert frame_fault(frame, SHAPE) == "wrong shape"


def test_frame_after_one_of_another_shape_is_valid() -> None:
    assert frame_fault(picture(), SHAPE, last=picture()[1:]) is None
