"""The road's potential: a modified Morse field with a wall at each edge (paper, section IV-C).

Straight, with y the lateral position, y_r and y_l the edges (all from the preferred position, + is right):

    U_s = U_sr + U_sl,    U_sr = A (1 - e^(-b (y - y_r)))^2,    U_sl = A (1 - e^(b (y - y_l)))^2

Curved, y - y_r becomes sign(y - y_r) sqrt(((y - b_y) / m - (x + dx))^2 + (y_r - y)^2) with y_r = c_2 (x + dx)^n + c_0r,
m = -1 / (2 c_2 (x + dx)), b_y = y_r - m (x + dx). Since (y - b_y) / m - (x + dx) = (y - y_r) / m, that is (y - y_r)
sqrt(1 + 1 / m^2) exactly: with the slope s = -1 / m neither m, b_y, dx, root nor sign is needed.

Each term is a well on its own edge that rises steeply towards the other one; the sum has its only minimum midway
between the edges, 1.75 m left of the preferred position on four lanes of 3.5 m, which is a lane line.
"""

from collections import deque
from collections.abc import Callable
from math import exp, sqrt
from typing import Literal

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.planning.paper.lane import Lane
from vpf_sim.types import Camera, Floats

Bend = Literal[-1, 0, 1]  # left, straight, right
EXPONENT_LIMIT = 300.0  # keeps the square of a potential far off the road finite
STEP_M = 1e-6  # of the numerical gradient


@settings
class RoadFieldConfig:
    """The only minimum lies in the middle between the edges."""

    shape: Literal["printed", "repaired"] = setting(
        "Shape of the field: `printed`, the formulas as typed, or `repaired`, the same by the identity, + bends right."
    )
    depth: float = setting("Depth A of the field.", gt=0.0)
    b_per_m: float = setting("Factor b of the field.", gt=0.0)
    c2_straight: float = setting("Factor c_2 of a straight road, n = 1.")
    c2_curved_per_m: float = setting("Factor c_2 of a curved road, n = 2.")
    x_offset_m: float = setting("Offset delta x of the printed form.", gt=0.0)
    foe_dead_band_px: float = setting(
        "Distance of the FOE from the centre within which the road counts as straight.", ge=0.0
    )
    foe_median_s: float = setting("Time over which the FOE's median is taken.", ge=0.0)
    edges: Literal["carriageway", "lane", "preferred"] = setting(
        "Edges of the field: of the carriageway, of the own lane, or `preferred`, the right one mirrored at its middle."
    )


class FoeBend:
    """Direction of the road's bend by the side on which the FOE lies (paper, section IV-C).

    It measures the car's own yaw rate and slip, not the road ahead. Print has no threshold for "in the
    centre": the dead band and the median are ours.
    """

    def __init__(self, config: RoadFieldConfig, camera: Camera, rate_hz: float) -> None:
        self._dead_band_px = config.foe_dead_band_px
        self._centre_px = camera.cx_px
        self._recent: deque[float] = deque(maxlen=max(1, round(config.foe_median_s * rate_hz)))

    def update(self, foe_x_px: float) -> Bend:
        self._recent.append(foe_x_px)
        aside = float(np.median(self._recent)) - self._centre_px
        if abs(aside) <= self._dead_band_px:
            return 0
        return 1 if aside > 0.0 else -1


def edges(lane: Lane, lane_width_m: float, config: RoadFieldConfig) -> tuple[float, float]:
    """m, y of the right and of the left edge, from the own lane's middle."""
    if config.edges == "lane":
        return 0.5 * lane_width_m, -0.5 * lane_width_m
    return (lane.right_m, lane.left_m) if config.edges == "carriageway" else (lane.right_m, -lane.right_m)


def straight(y_m: float, right_m: float, left_m: float, depth: float = 0.5, b_per_m: float = 1.0) -> float:
    """U_s at y, edges at `right_m` and `left_m`."""
    right = min(EXPONENT_LIMIT, -b_per_m * (y_m - right_m))
    left = min(EXPONENT_LIMIT, b_per_m * (y_m - left_m))
    return depth * ((1.0 - exp(right)) ** 2 + (1.0 - exp(left)) ** 2)


def curved_printed(
    x_m: float, y_m: float, right_m: float, left_m: float, c2: float, power: int, config: RoadFieldConfig
) -> float:
    """U of the curved road as typed: the slope inside m is that of n = 2 even where n = 1."""
    x = x_m + config.x_offset_m
    m = -1.0 / (2.0 * c2 * x)
    total = 0.0
    for edge_m, side in ((right_m, -1.0), (left_m, 1.0)):
        edge = c2 * x**power + edge_m
        intercept = edge - m * x
        distance = np.sign(y_m - edge) * sqrt(((y_m - intercept) / m - x) ** 2 + (edge - y_m) ** 2)
        total += config.depth * (1.0 - exp(min(EXPONENT_LIMIT, side * config.b_per_m * float(distance)))) ** 2
    return total


def curved_repaired(
    x_m: float, y_m: float, right_m: float, left_m: float, c2: float, power: int, config: RoadFieldConfig
) -> float:
    """U of the curved road by the identity, with the true slope s = n c_2 x^(n - 1)."""
    drift = c2 * x_m**power
    stretch = sqrt(1.0 + (power * c2 * x_m ** (power - 1)) ** 2)
    return straight(y_m, right_m + drift, left_m + drift, config.depth, config.b_per_m * stretch)


def force(y_m: float, right_m: float, left_m: float, bend: Bend, config: RoadFieldConfig) -> Floats:
    """(2,) F_rep_rd = grad (U_sr + U_sl) at the vehicle, x = 0 of its own axes.

    x is the look-ahead in vehicle axes: with the world's x the printed form overflows. At x = 0 the bend
    has no influence on the force; it shapes the field ahead.
    """
    c2, power = (config.c2_straight, 1) if bend == 0 else (bend * config.c2_curved_per_m, 2)
    potential: Callable[..., float]
    if config.shape == "repaired":
        potential, c2 = curved_repaired, c2 if bend else 0.0  # a straight road does not drift sideways
    else:
        potential, c2 = curved_printed, -c2 if bend else c2  # as printed + is a left bend, though y grows to the right

    def at(x_m: float, y: float) -> float:
        return potential(x_m, y, right_m, left_m, c2, power, config)

    # The printed root has no derivative on the edge itself, and x >= 0 by construction: differences, forward in x.
    along = (at(STEP_M, y_m) - at(0.0, y_m)) / STEP_M
    across = (at(0.0, y_m + STEP_M) - at(0.0, y_m - STEP_M)) / (2.0 * STEP_M)
    return np.array([along, across])
