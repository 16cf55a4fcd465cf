"""Candidates in the world: the car at N places of P paths, and where M profiles are then at T times.

A path is that of the rear axle's middle. There a kinematic bicycle's heading is its course and its curvature that of
its wheels, tan(steering) / wheelbase, also while the wheels turn: the rear axle is its flat output (Fliess, Levine,
Martin, Rouchon 1995, doi:10.1080/00207179508921959).
"""

from dataclasses import dataclass
from math import cos, sin, sqrt
from typing import TypeVar

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.scene.road import LEAST_STRETCH, Road, stretch_at
from vpf_sim.types import Integers, Reals, VehicleModel

Real = TypeVar("Real", float, Reals)
PLACES = 81
AHEAD_M = 20.0  # of a path, at least


@dataclass(frozen=True, slots=True)
class Motions:
    """P paths with M profiles at T times.

    A path has the car at N places; between them all quantities are linear. Places in the world are relative to
    `origin_m`, so that single precision has millimetres.
    """

    origin_m: tuple[float, float]
    ahead_m: Reals  # (N,) along the road from the start
    x_m: Reals  # (P, N) of the car's middle, from the origin
    y_m: Reals
    heading_rad: Reals  # (P, N) of the body
    d_m: Reals  # (P, N) of the car's middle
    curvature_per_m: Reals  # (P, N) of the rear axle's path
    leftmost_m: Reals  # (P, N) d of the body's corners
    rightmost_m: Reals
    left_m: Reals  # (N,) the road's left edge where the car's middle is, about: edges change little by little
    right_m: Reals
    own_left_m: Reals
    lane_offset_m: Reals  # (P, N) from the middle of the nearest lane
    speed_mps: Reals  # (M, T)
    acceleration_mps2: Reals  # (M, T)
    cell: Integers  # (M, T) the place before
    share: Reals  # (M, T) of the way to the next place

    @property
    def shape(self) -> tuple[int, int]:
        """P and M."""
        return len(self.x_m), len(self.cell)

    @property
    def poses(self) -> tuple[Reals, Reals, Reals]:
        """(P, N) each: x m, y m from the origin and heading rad."""
        return self.x_m, self.y_m, self.heading_rad

    def in_time(self, values: Reals) -> Reals:
        """(P, M, T) of quantities (P, N) at the places."""
        steps = np.diff(values, axis=1)
        found: Reals = np.take(values, self.cell, axis=1)
        found += np.take(steps, self.cell, axis=1) * self.share
        return found

    def along(self, values: Reals, path: Integers, profile: Integers) -> Reals:
        """(R, T) of quantities (P, N), for R motions by their paths and profiles."""
        return _between(values, path[:, None], self.cell[profile], self.share[profile])

    def last(self, values: Reals) -> Reals:
        """(P, M) of quantities (P, N), at the last time."""
        return _between(values, slice(None), self.cell[:, -1], self.share[:, -1])

    def mean(self, values: Reals, factor: Reals | float = 1.0) -> Reals:
        """(P, M) mean in time of quantities (P, N), times a factor (M, T)."""
        weights = np.zeros((len(self.ahead_m), len(self.cell)), np.float32)
        profile = np.arange(len(self.cell))[:, None]
        np.add.at(weights, (self.cell, profile), factor * (1.0 - self.share))
        np.add.at(weights, (self.cell + 1, profile), factor * self.share)
        found: Reals = np.einsum("pn,nm->pm", values, weights) / np.float32(self.cell.shape[1])
        return found


def motions(road: Road, start: PathState, paths: Paths, profiles: Profiles, vehicle: VehicleModel) -> Motions:
    """All paths with all profiles."""
    ahead = _ahead_m(float(profiles.travelled_m.max()))
    s = start.s_m + ahead
    here = road.at(s)
    origin = float(here.x_m[0]), float(here.y_m[0])
    rear_x, rear_y = (here.x_m - origin[0]).astype(np.float32), (here.y_m - origin[1]).astype(np.float32)
    heading, bend = (values.astype(np.float32) for values in (here.heading_rad, here.curvature_per_m))
    d, slope, second = paths.at(s[None].astype(np.float32))
    stretch = np.maximum(1.0 - bend * d, LEAST_STRETCH)
    turn = slope / stretch
    cosine = 1.0 / np.sqrt(1.0 + turn**2)  # of the course
    sine = turn * cosine
    forward, right = vehicle.l_r_m * cosine, d + vehicle.l_r_m * sine  # of the middle, by the road
    x = rear_x + forward * np.cos(heading) - right * np.sin(heading)
    y = rear_y + forward * np.sin(heading) + right * np.cos(heading)
    beside_s = s + vehicle.l_r_m
    away = 0.5 * bend / stretch * cosine**2  # 1/m: so much the road bends away from the body
    middle = right - away * vehicle.l_r_m**2
    front, back, half = vehicle.l_r_m + 0.5 * vehicle.length_m, vehicle.l_r_m - 0.5 * vehicle.length_m, 0.5 * cosine
    ends = d + sine * front - away * front**2, d + sine * back - away * back**2
    left, right_edge, own_left = (values.astype(np.float32) for values in road.at(beside_s)[4:])
    place = np.interp(profiles.travelled_m, ahead, np.arange(PLACES))
    cell = np.minimum(place.astype(np.intp), PLACES - 2)
    return Motions(
        origin, ahead, x, y, heading + np.arctan(turn), middle, path_curvature(turn, second, bend, stretch),
        np.minimum(*ends) - half * vehicle.width_m, np.maximum(*ends) + half * vehicle.width_m,
        left, right_edge, own_left, _lane_offset(road, beside_s, middle),
        profiles.speed_mps.astype(np.float32), profiles.acceleration_mps2.astype(np.float32),
        cell, (place - cell).astype(np.float32),
    )  # fmt: skip


def _between(values: Reals, paths: Integers | slice, cell: Integers, share: Reals) -> Reals:
    """Quantities (P, N) of some paths, between a place and the next."""
    before = values[paths, cell]
    found: Reals = before + share * (values[paths, cell + 1] - before)
    return found


def _ahead_m(farthest_m: float) -> Reals:
    """(N,) m, places along a path: 0.25 m apart at first, where slow motions turn sharply, and then ever farther."""
    share = np.linspace(0.0, 1.0, PLACES)
    places: Reals = AHEAD_M * share + max(farthest_m - AHEAD_M, 0.0) * share**4
    return places


def rear_axle(road: Road, s_m: float, d_m: float, yaw_rad: float, vehicle: VehicleModel) -> tuple[float, float, float]:
    """s and d, m, of a car's rear axle, and the car's heading from the road's there, from the place of its middle."""
    heading, bend = road.direction_at(s_m)
    course = wrap_angle(yaw_rad - heading)
    right_m = d_m - vehicle.l_r_m * sin(course)
    stretch = stretch_at(bend, right_m)
    back_m = vehicle.l_r_m * cos(course)
    s = s_m - back_m / stretch
    return s, right_m - 0.5 * bend / stretch * back_m**2, wrap_angle(yaw_rad - road.direction_at(s)[0])


def rear_speed(speed_mps: float, yaw_rate_radps: float, vehicle: VehicleModel) -> float:
    """m/s of the rear axle, which does not slip sideways, from the speed of the car's middle."""
    sideways_mps = abs(vehicle.l_r_m * yaw_rate_radps)
    return speed_mps * sqrt(1.0 - (sideways_mps / speed_mps) ** 2) if sideways_mps < speed_mps else 0.0


def path_second(turn: float, curvature_per_m: float, road_per_m: float, stretch: float) -> float:
    """1/m, d^2 d / d s^2 of a path of a curvature: the inverse of `path_curvature`."""
    square = 1.0 + turn**2
    return stretch**2 * curvature_per_m * square * sqrt(square) - stretch * road_per_m * (2.0 * square - 1.0)


def path_curvature(turn: Real, second: Real, road_per_m: Real, stretch: Real) -> Real:
    """1/m, of a path d(s) beside a road of a curvature; the road's change of curvature is left out.

    Werling et al. 2010, appendix I, with stretch = 1 - d * road curvature, and turn = (d d / d s) / stretch, the
    tangent of the angle to the road.
    """
    square = 1.0 + turn**2
    curvature: Real = (second / stretch**2 + road_per_m / stretch * (2.0 * square - 1.0)) / (square * np.sqrt(square))
    return curvature


def _lane_offset(road: Road, s_m: Reals, d_m: Reals) -> Reals:
    """|d| from the nearest lane's middle; from the route where there is no lane."""
    nearest = np.full(d_m.shape, np.inf, np.float32)
    offset = np.empty_like(nearest)
    for middle in road.lanes_at(s_m).astype(np.float32):
        np.abs(np.subtract(d_m, middle, out=offset), out=offset)
        np.fmin(nearest, offset, out=nearest)
    return np.where(np.isfinite(nearest), nearest, np.abs(d_m - np.float32(road.route_m)))
