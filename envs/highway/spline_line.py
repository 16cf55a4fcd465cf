"""A smooth line through points: a cubic spline over the distance along them."""

from bisect import bisect_left, bisect_right
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from vpf_sim.types import Floats

NEAR_M = 120.0  # part of the line, before and after a known place, that is searched
NEWTON_STEPS = 6


class SplineLine:
    """A `ReferenceLine` through points (N, 2) m that are about a metre apart.

    The spline is twice continuously differentiable, and its parameter is the length of the chords: over a metre of an
    arc of radius R the chord is 1 / (24 R^2) m shorter than the arc.
    """

    def __init__(self, points_m: Floats) -> None:
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points_m, axis=0).T))])
        self._points = points_m
        self.length_m = float(self._s[-1])
        spline = CubicSpline(self._s, points_m)
        self._spline, self._slope, self._bend = spline, spline.derivative(), spline.derivative(2)
        self._pieces: Any = spline.c.transpose(1, 2, 0).tolist()  # floats by piece, axis, power
        self._starts: list[float] = self._s.tolist()

    def position(self, s_m: ArrayLike, lateral_m: ArrayLike = 0.0) -> Floats:
        """(..., 2) m, the world points at s along the line and `lateral` right of it."""
        s, lateral = np.broadcast_arrays(np.asarray(s_m, float), np.asarray(lateral_m, float))
        on_line = np.clip(s, 0.0, self.length_m)
        heading = self.heading(s)
        along, right = (
            np.stack([np.cos(heading), np.sin(heading)], -1),
            np.stack([-np.sin(heading), np.cos(heading)], -1),
        )
        placed: Floats = self._spline(on_line) + (s - on_line)[..., None] * along + lateral[..., None] * right
        return placed

    def heading(self, s_m: ArrayLike) -> Floats:
        """(...) rad in (-pi, pi]."""
        slope = self._slope(np.clip(np.asarray(s_m, float), 0.0, self.length_m))
        return np.asarray(np.arctan2(slope[..., 1], slope[..., 0]))

    def curvature(self, s_m: ArrayLike) -> Floats:
        """(...) 1/m, > 0 turns right; 0 beyond both ends."""
        s = np.asarray(s_m, float)
        on_line = np.clip(s, 0.0, self.length_m)
        slope, bend = self._slope(on_line), self._bend(on_line)
        turn = slope[..., 0] * bend[..., 1] - slope[..., 1] * bend[..., 0]
        curvature = turn / np.hypot(slope[..., 0], slope[..., 1]) ** 3
        return np.asarray(np.where(s == on_line, curvature, 0.0))

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]:
        """`position` of one point."""
        x, y = self.position(s_m, lateral_m).tolist()
        return x, y

    def heading_at(self, s_m: float) -> float:
        """`heading` at one s."""
        return float(self.heading(s_m))

    def local_at(self, x_m: float, y_m: float, near_m: float | None = None) -> tuple[float, float]:
        """The inverse of `position`: (s, lateral) m of a world point.

        With `near_m` only that part of the line is searched; without, all of it. This matters where the line crosses
        itself or runs beside itself, as on a second lap.
        """
        s = self._nearest_knot(x_m, y_m, near_m)
        for _ in range(NEWTON_STEPS):
            x, y, dx, dy, ddx, ddy = self._state(s)
            away_x, away_y = x_m - x, y_m - y
            slope = max(dx * dx + dy * dy - away_x * ddx - away_y * ddy, 0.1)
            before, s = s, min(max(s + (away_x * dx + away_y * dy) / slope, 0.0), self.length_m)
            if abs(s - before) < 1e-9:
                break
        x, y, dx, dy, *_ = self._state(s)
        heading_x, heading_y = dx / hypot(dx, dy), dy / hypot(dx, dy)
        beyond = heading_x * (x_m - x) + heading_y * (y_m - y) if s in (0.0, self.length_m) else 0.0
        return s + beyond, heading_x * (y_m - y) - heading_y * (x_m - x)

    def _nearest_knot(self, x_m: float, y_m: float, near_m: float | None) -> float:
        """The s of the knot nearest to a point."""
        first, last = 0, len(self._starts)
        if near_m is not None:
            first = min(bisect_left(self._starts, near_m - NEAR_M), last - 2)
            last = max(bisect_left(self._starts, near_m + NEAR_M), first + 2)
        away = self._points[first:last] - (x_m, y_m)
        return self._starts[first + int(np.argmin(np.einsum("ij,ij->i", away, away)))]

    def _state(self, s: float) -> tuple[float, float, float, float, float, float]:
        """x, y and their first and second derivatives at s on the line, in plain floats for speed."""
        index = min(bisect_right(self._starts, s) - 1, len(self._pieces) - 1)
        v = s - self._starts[index]
        (a, b, c, x), (e, f, g, y) = self._pieces[index]
        return (
            ((a * v + b) * v + c) * v + x,
            ((e * v + f) * v + g) * v + y,
            (3.0 * a * v + 2.0 * b) * v + c,
            (3.0 * e * v + 2.0 * f) * v + g,
            6.0 * a * v + 2.0 * b,
            6.0 * e * v + 2.0 * f,
        )
