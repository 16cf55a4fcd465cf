"""A frame that shows nothing new or nothing true is not looked at; a whole one always is."""

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim.perception.frame_gate import FrameGate
from vpf_sim.types import Image

RATE_HZ, STEP_M = 60.0, 0.09
WORLD = np.kron(np.random.default_rng(3).integers(80, 160, (1600, 80)), np.ones((1, 8))).astype(np.uint8)


def picture(k: int) -> Image:
    """(480, 640, 3) that moves down by 3 px a frame."""
    top = 1100 - 3 * k
    return np.repeat(WORLD[top : top + 480, :, None], 3, axis=2)


def gate_after(count: int) -> FrameGate:
    """One that has seen so many good frames, and passed them."""
    gate = FrameGate(ROBUST.frame_gate)
    assert all(passes(gate, k, picture(k)) for k in range(count))
    return gate


def passes(gate: FrameGate, k: int, image: Image, moved: bool = True) -> bool:
    return gate.passes(image, k / RATE_HZ, (k * STEP_M if moved else 0.0, 0.0))


def spoilt(how: str) -> Image:
    """The frame 30, spoilt."""
    image = picture(30).copy()
    if how == "black":
        image[:] = 0
    elif how == "frozen":
        image = picture(29)
    elif how == "torn":
        image[200:] = picture(29)[200:]
    elif how == "noise":
        image[100:130] = np.random.default_rng(1).integers(256, size=(30, 640, 3))
    elif how == "brighter":
        image = np.minimum(image * 2.0, 255.0).astype(np.uint8)
    elif how == "darker":
        image //= 2
    return image


@pytest.mark.parametrize("how", ["black", "frozen", "torn", "noise", "brighter", "darker"])
def test_a_spoilt_frame_does_not_pass_and_the_next_good_one_does(how: str) -> None:
    gate = gate_after(30)
    assert not passes(gate, 30, spoilt(how))
    assert passes(gate, 31, picture(31))


def test_a_frame_that_was_seen_before_is_not_new() -> None:
    gate = gate_after(30)
    assert not passes(gate, 29, picture(29))


def test_a_car_that_stands_sees_the_same_picture() -> None:
    gate = FrameGate(ROBUST.frame_gate)
    assert all(passes(gate, k, picture(0), moved=False) for k in range(20))


def test_a_frozen_picture_is_told_however_slowly_the_car_moves() -> None:
    gate = FrameGate(ROBUST.frame_gate)
    passed = [gate.passes(picture(0), k / RATE_HZ, (0.005 * k, 0.0)) for k in range(10)]
    assert passed == [k * 0.005 <= 0.02 for k in range(10)]


def test_a_change_of_exposure_that_stays_is_taken_up() -> None:
    gate = gate_after(30)
    assert [passes(gate, 30 + k, picture(30 + k) // 2) for k in range(5)] == [False, False, False, True, True]


def test_the_cars_own_bonnet_is_no_torn_frame() -> None:
    gate = FrameGate(ROBUST.frame_gate)
    for k in range(60):
        image = picture(k).copy()
        image[400:] = picture(0)[400:]
        assert passes(gate, k, image)
