"""What is unlike the inputs that a policy learned from: pictures and speeds that are drawn, so that it is known."""

import numpy as np
import pytest

from vpf_sim.drivers.learned.familiarity import Familiarity, learned_from
from vpf_sim.seeding import stream
from vpf_sim.types import Image


def pictures(count: int, level: float, texture: float, seed: int = 0) -> list[Image]:
    """(1, 32, 64) pictures of a brightness that varies a little, with grain."""
    random = stream(seed, "pictures")
    shades = random.normal(level, 8.0, count)
    grain = random.normal(0.0, texture, (count, 1, 32, 64))
    return [np.clip(shade + one, 0, 255).astype(np.uint8) for shade, one in zip(shades, grain, strict=True)]


KNOWN = learned_from(pictures(60, 110.0, 6.0), np.linspace(0.0, 6.0, 60))


def remark(shown: list[Image], speed_mps: float) -> str:
    counted = Familiarity(KNOWN)
    for picture in shown:
        counted.add(picture, speed_mps)
    return counted.remark()


def test_inputs_as_in_training_have_no_remark() -> None:
    assert remark(pictures(40, 110.0, 6.0, seed=1), 5.0) == ""


@pytest.mark.parametrize(
    ("level", "texture"), [(200.0, 6.0), (20.0, 6.0), (110.0, 60.0)], ids=["bright", "dark", "rough"]
)
def test_other_pictures_are_remarked(level: float, texture: float) -> None:
    assert "the picture is unlike" in remark(pictures(40, level, texture, seed=1), 5.0)


def test_speed_outside_of_the_training_is_remarked_with_its_range() -> None:
    said = remark(pictures(40, 110.0, 6.0, seed=1), 10.0)
    assert said == "the speed is outside of the 0.0 to 6.0 m/s that it learned from in 100 % of the decisions"


def test_a_few_unlike_pictures_are_no_remark() -> None:
    assert remark([*pictures(40, 110.0, 6.0, seed=1), *pictures(10, 220.0, 6.0)], 5.0) == ""
