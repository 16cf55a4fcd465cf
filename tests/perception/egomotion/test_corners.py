"""Eigenvalues of structure tensors that are made of known ones, and what counts as a corner."""

import numpy as np
import pytest

from vpf_sim.perception.egomotion.corners import eigenvalues, is_corner
from vpf_sim.types import Floats


def tensor(small: float, large: float, turn_rad: float) -> Floats:
    axes = np.array([[np.cos(turn_rad), -np.sin(turn_rad)], [np.sin(turn_rad), np.cos(turn_rad)]])
    made: Floats = axes @ np.diag([small, large]) @ axes.T
    return made


@pytest.mark.parametrize("turn_rad", [0.0, 0.4, 1.2, 2.9])
def test_the_eigenvalues_are_those_it_was_made_of(turn_rad: float) -> None:
    small, large = eigenvalues(np.stack([tensor(3.0, 80.0, turn_rad), tensor(50.0, 50.0, turn_rad)]))
    assert small == pytest.approx([3.0, 50.0])
    assert large == pytest.approx([80.0, 50.0])


@pytest.mark.parametrize("turn_rad", [0.0, 1.2])
def test_neither_an_edge_nor_a_faint_corner_is_one(turn_rad: float) -> None:
    made = np.stack([tensor(70.0, 700.0, turn_rad), tensor(20.0, 30.0, turn_rad), tensor(70.0, 200.0, turn_rad)])
    assert is_corner(made, 60.0, 0.25).tolist() == [False, False, True]
