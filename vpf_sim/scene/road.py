"""The road along a route, in road coordinates: s, metres along the reference line, and d, metres right of it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.types import Floats, Reals

PROJECTIONS = 4  # of a point on the road, each from the foot of the last
LEAST_STRETCH = 0.2  # of 1 - d * curvature, on the inside of a bend


def stretch_at(curvature_per_m: float, d_m: float) -> float:
    """Length of the way at d beside a road of a curvature, by that of its reference line."""
    return max(1.0 - curvature_per_m * d_m, LEAST_STRETCH)


class Section(NamedTuple):
    """Quantities of the road at some s, each of the shape of s."""

    x_m: Floats
    y_m: Floats
    heading_rad: Floats
    curvature_per_m: Floats
    left_m: Floats
    right_m: Floats
    own_left_m: Floats


@dataclass(frozen=True, slots=True)
class Road:
    """Tables of a road at M equidistant stations; it goes on straight, with its last edges, beyond both ends.

    `left_m` and `right_m` are d of the carriageway's edges, `own_left_m` of the left side of the lanes in our
    direction. `lanes_m` are d of the middles of these lanes, nan where a lane is missing. Where roads part, the
    reference line is the way to take.
    """

    station_m: Floats  # (M,)
    x_m: Floats  # (M,) of the reference line in the world
    y_m: Floats  # (M,)
    heading_rad: Floats  # (M,) continuous
    curvature_per_m: Floats  # (M,) + bends right
    left_m: Floats  # (M,)
    right_m: Floats  # (M,)
    own_left_m: Floats  # (M,)
    lanes_m: Floats  # (L, M)
    lane_width_m: float
    route_m: float  # d of the route
    overhang_m: float = 0.0  # by which the car's corners may be beyond an edge

    def at(self, s_m: Reals) -> Section:
        """The road's quantities at stations of any shape."""
        return Section(*self._tables_at(s_m, *Section._fields))

    def direction_at(self, s_m: float) -> tuple[float, float]:
        """Heading, rad, and curvature, 1/m, of the reference line at one s."""
        heading, curvature = self._tables_at(s_m, "heading_rad", "curvature_per_m")
        return float(heading), float(curvature)

    def lanes_at(self, s_m: Reals) -> Floats:
        """(L, ...) m, d of the lanes' middles at the nearest stations; nan where a lane is missing."""
        step_m = self.station_m[1] - self.station_m[0]
        rows = np.rint((s_m - self.station_m[0]) / step_m).astype(np.intp)
        found: Floats = self.lanes_m[:, np.clip(rows, 0, len(self.station_m) - 1)]
        return found

    def world(self, s_m: Floats, d_m: Floats) -> tuple[Floats, Floats, Floats]:
        """World x m, y m, and the road's heading, rad, at road coordinates."""
        x_m, y_m, heading = self._tables_at(s_m, "x_m", "y_m", "heading_rad")
        return x_m - d_m * np.sin(heading), y_m + d_m * np.cos(heading), heading

    def place_at(self, x_m: Floats, y_m: Floats, near_s_m: Floats) -> tuple[Floats, Floats]:
        """s and d (N,) m of points (N,) in the world, each the foot of the perpendicular nearest to `near_s_m`."""
        s = np.asarray(near_s_m, float)
        for _ in range(PROJECTIONS):
            along, d, curvature = self._seen_from(s, x_m, y_m)
            s = s + along / np.maximum(1.0 - curvature * d, LEAST_STRETCH)
        return s, self._seen_from(s, x_m, y_m)[1]

    def _seen_from(self, s_m: Floats, x_m: Floats, y_m: Floats) -> tuple[Floats, Floats, Floats]:
        """Points (N,) in the world from the reference line at s (N,): m along and right of it; its curvature, 1/m."""
        x, y, heading, curvature = self._tables_at(s_m, "x_m", "y_m", "heading_rad", "curvature_per_m")
        dx, dy, cosine, sine = x_m - x, y_m - y, np.cos(heading), np.sin(heading)
        return dx * cosine + dy * sine, dy * cosine - dx * sine, curvature

    def _tables_at(self, s_m: Reals | float, *names: str) -> list[Floats]:
        """Tables between their stations."""
        return [np.interp(s_m, self.station_m, getattr(self, name)) for name in names]
