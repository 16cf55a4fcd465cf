"""What drivers return: commands of numbers, of arrays and tensors with one number, and errors that name the value."""

from decimal import Decimal
from typing import Any

import numpy as np
import pytest

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver, Observation


class Tensor:
    """Behaves like a tensor of torch: `item` for one element, and no numpy array while a gradient is needed."""

    def __init__(self, *values: float) -> None:
        self.values = values

    def item(self) -> float:
        if len(self.values) != 1:
            raise RuntimeError(f"a Tensor with {len(self.values)} elements cannot be converted to Scalar")
        return self.values[0]

    def __array__(self, *_: Any, **__: Any) -> np.ndarray[Any, Any]:
        raise RuntimeError("Can't call numpy() on Tensor that requires grad.")


class Says(Driver):
    def __init__(self, throttle: Any, steering: Any) -> None:
        self.command = Command(throttle, steering)

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        return self.command


class Draws(Says):
    def act(self, observation: Observation) -> Command:
        observation.image[0] = 255
        return super().act(observation)

    def perceive(self, observation: Observation) -> None:
        observation.image[0] = 255


def command(throttle: Any, steering: Any = 0.0) -> Command:
    return drivers.command_of(Says(throttle, steering), seen())


def seen() -> Observation:
    return Observation(np.zeros((4, 4, 3), np.uint8), 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, (9.0, 0.0))


ONE_NUMBER = [
    0.25,
    np.float32(0.25),
    np.array(0.25),
    np.array([0.25]),
    np.array([[0.25]], np.float32),
    [0.25],
    [[0.25]],
    (0.25,),
    Decimal("0.25"),
    Tensor(0.25),
]


@pytest.mark.parametrize("value", ONE_NUMBER, ids=lambda value: repr(value).partition(" object at")[0])
def test_one_number_in_any_form_is_taken(value: Any) -> None:
    for given in (command(value, -0.5), command(-0.5, value)):
        assert {type(given.throttle), type(given.steering)} == {float}
        assert sorted((given.throttle, given.steering)) == [-0.5, 0.25]


NO_NUMBER = [
    np.array([0.1, 0.2]),
    np.array([[0.1], [0.2]]),
    np.empty(0),
    [],
    [0.1, [0.2]],
    None,
    "full",
    1j,
    {"throttle": 0.1},
    10**400,
    Tensor(0.1, 0.2),
    np.array([np.nan]),
]


@pytest.mark.parametrize("value", NO_NUMBER, ids=lambda value: repr(value)[:30])
@pytest.mark.parametrize("name", ["throttle", "steering"])
def test_anything_else_is_an_error_of_one_line_that_names_the_value(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"\Adriver: Command: {name}: expected a finite number, got [^\n]+\Z"):
        command(**{"throttle": 0.0, name: value})


def test_no_driver_draws_into_the_image_that_others_get() -> None:
    observation = seen()
    for use in (drivers.command_of, drivers.perception_of):
        with pytest.raises(ValueError, match="read-only"):
            use(Draws(0.0, 0.0), observation)
    assert not observation.image.any()
