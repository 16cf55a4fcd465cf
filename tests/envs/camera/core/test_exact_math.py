"""Sine, cosine and distance: correct nearly to the last bit."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from vpf_sim.envs.camera.core import _core
from vpf_sim.types import Floats

ANGLES = np.concatenate(
    [
        np.linspace(-7.0, 7.0, 301),
        np.arange(-12, 13) * (math.pi / 2),  # where one of the two is next to nothing
        np.random.default_rng(1).uniform(-1e6, 1e6, 200),
        [1e-9, -1e-5],
    ]
)
SERIES_ERROR = Decimal(10) ** -60  # of the truth below


def computed(function: str) -> Floats:
    result = np.empty_like(ANGLES)
    getattr(_core, function)(ANGLES, result)
    return result


def cosine(angle: Decimal) -> Decimal:
    """Taylor's series; the context gives the digits that its large terms cancel."""
    term, total, n = Decimal(1), Decimal(1), 0
    while abs(term) > SERIES_ERROR:
        n += 2
        term *= -angle * angle / (n * (n - 1))
        total += term
    return total


def exact(function: str, angle: float) -> Decimal:
    """The value to 40 digits."""
    pi = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534")
    with localcontext() as context:
        context.prec = 90
        turned = Decimal(angle) - (pi / 2 if function == "sin" else 0)
        return cosine(turned % (2 * pi))


@pytest.mark.parametrize("function", ["sin", "cos"])
def test_a_value_is_within_three_quarters_of_its_last_bit(function: str) -> None:
    for angle, value in zip(ANGLES.tolist(), computed(function).tolist(), strict=True):
        error = abs(Decimal(value) - exact(function, angle))
        assert error <= Decimal("0.75") * Decimal(math.ulp(value)) + SERIES_ERROR, angle


@pytest.mark.parametrize("function", ["sin", "cos"])
def test_numpy_agrees_to_the_last_bit(function: str) -> None:
    theirs = getattr(np, function)(ANGLES)
    assert np.all(np.abs(computed(function) - theirs) <= np.spacing(np.abs(theirs)))


def test_a_distance_is_right() -> None:
    assert _core.hypot(3.0, -4.0) == 5.0
    assert _core.hypot(1.0, 1.0) == math.sqrt(2.0)


def test_arrays_must_fit() -> None:
    with pytest.raises(ValueError, match="two arrays of doubles of one size"):
        _core.sin(np.zeros(3), np.zeros(2))
