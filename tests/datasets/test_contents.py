"""What a frame holds: the state vector, and wrong wishes."""

import math

import numpy as np
import pytest

from vpf_sim.datasets.played_episode import STATE, Contents, state_of
from vpf_sim.driver_interface import Observation
from vpf_sim.errors import InputError

NO_IMAGE = np.empty((0, 0, 3), np.uint8)


def test_the_goal_is_in_the_axes_of_the_car() -> None:
    """The car looks along the world's Y axis; a goal at larger y is ahead, one at smaller x is right."""
    observation = Observation(NO_IMAGE, 0.0, 10.0, 20.0, math.pi / 2.0, 5.0, 0.1, (7.0, 50.0))
    state = dict(zip(STATE, state_of(observation).tolist(), strict=True))
    assert state == pytest.approx(
        {
            "speed_mps": 5.0,
            "yaw_rate_radps": 0.1,
            "x_m": 10.0,
            "y_m": 20.0,
            "yaw_rad": math.pi / 2.0,
            "goal_forward_m": 30.0,
            "goal_right_m": 3.0,
        }
    )


def test_a_picture_of_the_cameras_size_is_the_frame_itself() -> None:
    frame = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
    assert np.array_equal(Contents.of(None, False, ()).picture(frame), frame)


@pytest.mark.parametrize(
    ("size", "grey", "truth", "said"),
    [
        ((8, 84), False, (), "size: expected width and height in pixels, 16x16 to 640x480, got 8x84"),
        ((1280, 720), False, (), "size: expected width and height in pixels, 16x16 to 640x480, got 1280x720"),
        ("84x84", False, (), "size: expected width and height in pixels, 16x16 to 640x480, got '84x84'"),
        ((84.0, 84.0), False, (), "size: expected width and height in pixels, 16x16 to 640x480, got (84.0, 84.0)"),
        (None, "yes", (), "grey: expected True or False, got 'yes'"),
        (None, False, ("dept",), "unknown truth 'dept': did you mean 'depth'?"),
        (None, False, "depth", "truth: expected names, such as ('depth',), got 'depth'"),
    ],
)
def test_other_contents_are_refused_in_one_line(size: object, grey: object, truth: object, said: str) -> None:
    with pytest.raises(InputError) as caught:
        Contents.of(size, grey, truth)
    assert str(caught.value) == said
