"""What a candidate must keep, apart from objects: the vehicle's limits and the road's edges.

Each limit gives a price, 0 where it is kept, that grows with how far it is broken. A candidate whose price is above
`REJECTED` is taken only if there is no other: then the least broken one.
"""

import numpy as np

from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.settings import LimitSettings
from vpf_sim.types import Reals

REJECTED = 5.0  # about a third of what standing for the whole horizon costs
PER_MPS2, PER_SQUARE_MPS4, PER_CURVATURE, PER_CURVATURE_RATE, PER_EDGE_M = 60.0, 18.0, 6000.0, 120.0, 300.0
EDGE_S = 3.0  # an edge counts e times less so much later: the path will have been planned again


def prices(settings: LimitSettings, motions: Motions, times_s: Reals, overhang_m: float) -> dict[str, Reals]:
    """(P, M) each, by the limit's name."""
    step_s = float(times_s[1] - times_s[0])
    lateral = np.abs(motions.speed_mps**2 * motions.curvature_per_m)
    rate = np.abs(np.diff(motions.curvature_per_m, axis=2)) / step_s
    too_fast = np.maximum(motions.acceleration_mps2 - settings.acceleration_mps2, 0.0).max(axis=2)
    too_hard = np.maximum(-settings.deceleration_mps2 - motions.acceleration_mps2, 0.0).max(axis=2)
    return {
        "acceleration": PER_MPS2 * (too_fast + too_hard),
        "lateral_acceleration": PER_SQUARE_MPS4 * _above(lateral, settings.lateral_mps2) ** 2,
        "curvature": PER_CURVATURE * _above(np.abs(motions.curvature_per_m), settings.curvature_per_m),
        "steering_rate": PER_CURVATURE_RATE * _above(rate, settings.curvature_rate_per_ms),
        "road_edge": _off_road(settings, room_m(motions, overhang_m), times_s),
    }


def room_m(motions: Motions, overhang_m: float) -> Reals:
    """(P, M, T) m between the car's side and the nearer edge; < 0 beyond it."""
    left, right = motions.leftmost_m - motions.left_m, motions.right_m - motions.rightmost_m
    return np.minimum(left, right) + np.float32(overhang_m)


def _above(values: Reals, limit: float) -> Reals:
    """(P, M) by how much the largest value in time exceeds a limit."""
    excess: Reals = np.maximum(values.max(axis=2) - np.float32(limit), 0.0)
    return excess


def _off_road(settings: LimitSettings, room: Reals, times_s: Reals) -> Reals:
    """(P, M); a car that is beyond an edge already may come back."""
    lacking = np.clip(settings.edge_m - room, 0.0, 1.0) * np.exp(-times_s / EDGE_S).astype(np.float32)
    is_beyond = room[:, :, 1:].min(axis=2) < settings.edge_m
    return np.asarray(PER_EDGE_M * lacking.max(axis=2) * is_beyond, np.float32)
