"""What a candidate must keep, apart from objects: the vehicle's limits and the road's edges.

Each limit gives a price, 0 where it is kept, that grows with how far it is broken. A candidate whose price is above
`REJECTED` is taken only if there is no other: then the least broken one.
"""

import numpy as np

from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.settings import LimitSettings
from vpf_sim.types import Integers, Reals

REJECTED = 5.0  # about a third of what standing for the whole horizon costs
PER_MPS2, PER_SQUARE_MPS4, PER_CURVATURE, PER_CURVATURE_RATE, PER_EDGE_M = 60.0, 18.0, 6000.0, 120.0, 300.0
EDGE_S = 3.0  # an edge counts e times less so much later: the path will have been planned again


def prices(settings: LimitSettings, motions: Motions, times_s: Reals, overhang_m: float) -> dict[str, Reals]:
    """(P, M) each, by the limit's name."""
    return {
        "acceleration": PER_MPS2 * _acceleration(settings, motions)[None],
        "lateral_acceleration": PER_SQUARE_MPS4 * _lateral_acceleration(settings, motions) ** 2,
        "curvature": PER_CURVATURE * _curvature(settings, motions),
        "steering_rate": PER_CURVATURE_RATE * _steering_rate(settings, motions, times_s),
        "road_edge": PER_EDGE_M * _off_road(settings, motions, times_s, overhang_m),
    }


def room_m(motions: Motions, overhang_m: float) -> Reals:
    """(P, N) m between the car's side and the nearer edge; < 0 beyond it."""
    left, right = motions.leftmost_m - motions.left_m, motions.right_m - motions.rightmost_m
    return np.minimum(left, right) + np.float32(overhang_m)


def _acceleration(settings: LimitSettings, motions: Motions) -> Reals:
    """(M,) m/s^2 above the limits."""
    too_fast = np.maximum(motions.acceleration_mps2 - settings.acceleration_mps2, 0.0)
    too_hard = np.maximum(-settings.deceleration_mps2 - motions.acceleration_mps2, 0.0)
    excess: Reals = too_fast.max(axis=1) + too_hard.max(axis=1)
    return excess


def _lateral_acceleration(settings: LimitSettings, motions: Motions) -> Reals:
    """(P, M) m/s^2 above the limit."""
    sharp = np.abs(motions.curvature_per_m)
    paths = np.flatnonzero(sharp.max(axis=1) * motions.speed_mps.max() ** 2 > settings.lateral_mps2)
    lateral = motions.speed_mps**2 * motions.in_time(sharp[paths])
    return _of_all(motions, paths, lateral.max(axis=2) - np.float32(settings.lateral_mps2))


def _curvature(settings: LimitSettings, motions: Motions) -> Reals:
    """(P, M) 1/m above the limit."""
    sharp = np.abs(motions.curvature_per_m)
    paths = np.flatnonzero(sharp.max(axis=1) > settings.curvature_per_m)
    return _of_all(motions, paths, motions.in_time(sharp[paths]).max(axis=2) - np.float32(settings.curvature_per_m))


def _steering_rate(settings: LimitSettings, motions: Motions, times_s: Reals) -> Reals:
    """(P, M) 1/(m s) above the limit."""
    most = (np.abs(np.diff(motions.curvature_per_m, axis=1)) / np.diff(motions.ahead_m)).max(axis=1)
    paths = np.flatnonzero(most * motions.speed_mps.max() > settings.curvature_rate_per_ms)
    rate = np.abs(np.diff(motions.in_time(motions.curvature_per_m[paths]), axis=2)) / np.float32(times_s[1])
    return _of_all(motions, paths, rate.max(axis=2) - np.float32(settings.curvature_rate_per_ms))


def _off_road(settings: LimitSettings, motions: Motions, times_s: Reals, overhang_m: float) -> Reals:
    """(P, M) m of room that are lacking; a car that is beyond an edge already may come back."""
    room = room_m(motions, overhang_m)
    paths = np.flatnonzero((room < settings.edge_m).any(axis=1))
    room = motions.in_time(room[paths])
    lacking = np.clip(settings.edge_m - room, 0.0, 1.0) * np.exp(-times_s / EDGE_S).astype(np.float32)
    is_beyond = room[:, :, 1:].min(axis=2) < settings.edge_m
    return _of_all(motions, paths, lacking.max(axis=2) * is_beyond)


def _of_all(motions: Motions, paths: Integers, excess: Reals) -> Reals:
    """(P, M) what is above 0, of some paths; the others cannot break the limit with any profile."""
    found = np.zeros(motions.shape, np.float32)
    found[paths] = np.maximum(excess, 0.0)
    return found
