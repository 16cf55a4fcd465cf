"""Candidate motions: paths d(s) across the road, each with speed profiles v(t) along it.

Werling, Ziegler, Kammel, Thrun, ICRA 2010 (doi:10.1109/ROBOT.2010.5509799): quintics across, and quartics of the
distance along, which are cubics of the speed. Across they are functions of the distance, as there for low speeds, so
that a car that stands keeps its path.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.planning.spacetime.settings import CandidateSettings
from vpf_sim.scene.road import Road
from vpf_sim.types import Reals, Rows

SAME_MPS = 1e-3  # end speeds that are nearer to each other are one
STRAIGHT, STRAIGHT_PER_M = 0.02, 0.02  # slope and bend of a car that may go straight on, and turn later
NARROW_M = 0.3  # a road that leaves less room for the car's middle is driven in its middle


@dataclass(frozen=True, slots=True)
class PathState:
    """Where a candidate begins: s and d of the rear axle, derivatives by s, speed and acceleration along the road."""

    s_m: float
    d_m: float
    slope: float  # d d / d s
    bend_per_m: float  # d^2 d / d s^2
    speed_mps: float
    acceleration_mps2: float


@dataclass(frozen=True, slots=True)
class Paths(Rows):
    """P quintics d(u) of u = (s - start) / length in [0, 1], constant before and beyond."""

    start_m: Reals  # (P,) s
    length_m: Reals  # (P,)
    coefficients: Reals  # (P, 6) m, of u^0 to u^5

    @property
    def end_m(self) -> Reals:
        """(P,) d at the end."""
        end: Reals = self.coefficients.sum(axis=1)
        return end

    def at(self, s_m: Reals) -> tuple[Reals, Reals, Reals]:
        """(P, ...) each: d m, d d / d s, d^2 d / d s^2 /m at s, which is (...) or has a first axis of P or 1."""
        rows = (-1, *(1,) * (s_m.ndim - 1))
        start, length = (values.reshape(rows).astype(s_m.dtype) for values in (self.start_m, self.length_m))
        c = [self.coefficients[:, power].reshape(rows).astype(s_m.dtype) for power in range(6)]
        u = np.clip((s_m - start) / length, 0.0, 1.0)
        d = ((((c[5] * u + c[4]) * u + c[3]) * u + c[2]) * u + c[1]) * u + c[0]
        slope = ((((5.0 * c[5] * u + 4.0 * c[4]) * u + 3.0 * c[3]) * u + 2.0 * c[2]) * u + c[1]) / length
        bend = (((20.0 * c[5] * u + 12.0 * c[4]) * u + 6.0 * c[3]) * u + 2.0 * c[2]) / length**2
        return d, slope, bend


@dataclass(frozen=True, slots=True)
class Profiles(Rows):
    """M motions along the road at T times; speeds are not below 0."""

    travelled_m: Reals  # (M, T)
    speed_mps: Reals  # (M, T)
    acceleration_mps2: Reals  # (M, T)


def paths(settings: CandidateSettings, start: PathState, road: Road, width_m: float, kept: Paths | None) -> Paths:
    """Paths to lateral positions over the road's width, to the lanes' middles and straight on, and the last plan's.

    A car that drives straight may go on so for a while first.
    """
    ahead = np.array([start.s_m + max(8.0, start.speed_mps)])
    section = road.at(ahead)
    low, high = float(section.left_m[0]) + 0.5 * width_m, float(section.right_m[0]) - 0.5 * width_m
    low, high = low + 0.1, high - 0.1
    if high - low < NARROW_M:
        low, high = 0.5 * (low + high - NARROW_M), 0.5 * (low + high + NARROW_M)
    count = int(min(settings.most_positions, max(3.0, (high - low) / settings.spacing_m + 2.0)))
    middles = road.lanes_at(ahead)[:, 0]
    middles = middles[(middles > low) & (middles < high)]
    goals = np.concatenate(
        [np.linspace(low, high, count), middles, [np.clip(start.d_m, low, high)], [np.clip(road.route_m, low, high)]]
    )
    lengths = np.maximum(settings.least_reach_m, np.array(settings.reach_s) * start.speed_mps)
    is_straight = abs(start.slope) < STRAIGHT and abs(start.bend_per_m) < STRAIGHT_PER_M
    waits = np.array([0.0, *settings.wait_s] if is_straight else [0.0]) * start.speed_mps
    goal, length, wait = (values.ravel() for values in np.meshgrid(goals, lengths, waits, indexing="ij"))
    slope, bend = (np.where(wait > 0.0, 0.0, value) for value in (start.slope, start.bend_per_m))
    coefficients = _quintic(start.d_m, slope, bend, goal, length)
    found = Paths(start.s_m + wait, length, coefficients)
    return found if kept is None else found.concatenate(kept)


def _quintic(start_m: float, slope: Reals, bend_per_m: Reals, end_m: Reals, length_m: Reals) -> Reals:
    """(P, 6) coefficients from the start's position, slope and bend to `end_m` without slope and bend."""
    c0, c1, c2 = np.broadcast_arrays(start_m, slope * length_m, 0.5 * bend_per_m * length_m**2)
    rest, slope, bend = end_m - c0 - c1 - c2, -(c1 + 2.0 * c2), -2.0 * c2
    c3, c4, c5 = (
        10.0 * rest - 4.0 * slope + 0.5 * bend,
        -15.0 * rest + 7.0 * slope - bend,
        6.0 * rest - 3.0 * slope + 0.5 * bend,
    )
    return np.stack([c0, c1, c2, c3, c4, c5], axis=-1)


def profiles(
    settings: CandidateSettings, start: PathState, reference_mps: float, times_s: Reals, kept_mps: Reals | None
) -> Profiles:
    """Cubics of the speed to every end speed, stops at given decelerations, and the last plan's speeds (T,)."""
    v0, a0 = start.speed_mps, start.acceleration_mps2
    targets = np.array([*(share * reference_mps for share in settings.speed_shares), v0])
    targets = np.unique(np.round(targets / SAME_MPS)) * SAME_MPS
    end, duration = (values.ravel()[:, None] for values in np.meshgrid(targets, settings.settling_s, indexing="ij"))
    t = np.minimum(times_s, duration)
    square = (3.0 * (end - v0) - 2.0 * a0 * duration) / duration**2
    cube = (-2.0 * (end - v0) + a0 * duration) / duration**3
    speeds = [v0 + (a0 + (square + cube * t) * t) * t, *(v0 - rate * times_s[None] for rate in settings.emergency_mps2)]
    if kept_mps is not None:
        speeds.append(kept_mps[None])
    speed = np.maximum(np.concatenate(speeds), 0.0)
    step_s = times_s[1] - times_s[0]
    travelled = np.cumsum(0.5 * (speed[:, 1:] + speed[:, :-1]) * step_s, axis=1)
    none = np.zeros((len(speed), 1))
    return Profiles(np.hstack([none, travelled]), speed, np.hstack([np.diff(speed, axis=1) / step_s, none]))
