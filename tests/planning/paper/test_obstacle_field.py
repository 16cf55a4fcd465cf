"""F_rep from the obstacle map: its sign table, in closed form by error functions."""

from dataclasses import replace
from math import erf, exp, pi, sqrt

import numpy as np
import pytest
from driver_settings import ROBUST
from paper_planner import PAPER

from vpf_sim.perception.paper.obstacle_map import smoothed_gradient
from vpf_sim.planning.paper.obstacle_field import force
from vpf_sim.types import Camera, Floats, ObstacleMap

CAMERA = Camera()
LATERAL = replace(PAPER.obstacle_field, gamma=1.0)


def box_map(centre_x: float, half: float = 32.0) -> ObstacleMap:
    """A square of 64 px about (centre_x, 240), on whole cells."""
    reduction = 8
    plane = np.zeros((60, 80))
    columns = slice(int((centre_x - half) // reduction), int((centre_x + half) // reduction))
    plane[int((240 - half) // reduction) : int((240 + half) // reduction), columns] = 1.0
    gradient = smoothed_gradient(plane, replace(ROBUST.obstacle_map, sigma_px=320.0, reduction=reduction))
    return ObstacleMap(np.empty(0, np.bool_), plane, gradient, reduction)


def lateral(centre_x: float) -> float:
    return float(force(box_map(centre_x), np.empty(0), CAMERA, LATERAL)[0])


def closed_form(centre_x: float, sigma: float = 320.0, half: float = 32.0) -> float:
    """Mean over the frame of d (G * O) / dx: the edges' difference in x, an integral of erf over the rows in y."""

    def column(x: float) -> float:
        a, b = (x - centre_x + half) / (sigma * sqrt(2)), (x - centre_x - half) / (sigma * sqrt(2))
        return 0.5 * (erf(a) - erf(b))

    def antiderivative(u: float) -> float:  # of the cumulative normal distribution
        z = u / sigma
        return sigma * (z * 0.5 * (1 + erf(z / sqrt(2))) + exp(-0.5 * z * z) / sqrt(2 * pi))

    rows = (
        antiderivative(240 + half)
        - antiderivative(-240 + half)
        - antiderivative(240 - half)
        + antiderivative(-240 - half)
    )
    return (column(640.0) - column(0.0)) * rows / (640 * 480)


@pytest.mark.parametrize("centre_x", [120.0, 224.0, 320.0, 344.0, 424.0, 520.0])
def test_the_lateral_term_agrees_with_its_closed_form(centre_x: float) -> None:
    """It points to the obstacle, so that F_att - F_rep leads away from it; dead ahead there is none."""
    assert lateral(centre_x) == pytest.approx(closed_form(centre_x), rel=0.03, abs=1e-12)


def test_the_printed_sum_of_the_ttc_grows_with_safety() -> None:
    printed = replace(LATERAL, gamma=640.0 * 480.0, terms="printed")
    near, far = (force(box_map(320.0), np.full(40, ttc), CAMERA, printed)[1] for ttc in (1.0, 4.0))
    assert (near, far) == (pytest.approx(40.0), pytest.approx(160.0))
    some: Floats = np.array([2.0, np.inf, 3.0])
    assert force(box_map(320.0), some, CAMERA, printed)[1] == pytest.approx(5.0)
    assert force(box_map(320.0), some, CAMERA, LATERAL)[1] == 0.0
