"""What is coloured stands out from grey: against luma + R - B worked out without saturation on the way."""

import numpy as np
import pytest

from vpf_sim.perception.contrast import contrast
from vpf_sim.perception.flow import grey
from vpf_sim.seeding import stream


def test_grey_stays_as_it_is() -> None:
    image = np.repeat(np.arange(256, dtype=np.uint8).reshape(16, 16, 1), 3, axis=2)
    assert np.array_equal(contrast(image, grey(image)), image[..., 0])


def test_red_is_added_and_blue_taken_off() -> None:
    image = stream(1, "colours").integers(0, 256, (48, 64, 3)).astype(np.uint8)
    luma = grey(image)
    expected = luma.astype(int) + image[..., 0].astype(int) - image[..., 2].astype(int)
    assert np.array_equal(contrast(image, luma), np.clip(expected, 0, 255))


@pytest.mark.parametrize("colour", [(140, 105, 60), (200, 90, 40), (190, 40, 45)], ids=["wood", "orange", "red"])
def test_what_is_as_bright_as_the_road_is_seen_by_its_colour(colour: tuple[int, int, int]) -> None:
    image = np.empty((4, 2, 3), np.uint8)
    image[:, 0] = colour
    image[:, 1] = round(float(np.dot(colour, [0.299, 0.587, 0.114])))
    luma = grey(image)
    assert np.ptp(luma.astype(int)) <= 1
    assert np.ptp(contrast(image, luma)[0].astype(int)) > 60
