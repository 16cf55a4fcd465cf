"""A route as a polyline: nearest points and look-ahead points."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from vpf_sim.geometry import unwrapped, wrap_angle
from vpf_sim.types import Floats

SEARCHED = 30  # segments that are searched from the last one on


class Foot(NamedTuple):
    """The foot of a point on the line."""

    right_m: float  # of the point, right of the line
    heading_rad: float  # of the line there


class Polyline:
    """Waypoints (M, 2) m as a polyline, followed from its start: passed segments are never revisited."""

    def __init__(self, points_m: Floats) -> None:
        """Repeated waypoints, as from a stopped car, are left out."""
        goes_on = np.any(np.diff(points_m, axis=0) != 0.0, axis=1)
        self._points_m = points_m[np.concatenate([[True], goes_on])]
        self._along = np.diff(self._points_m, axis=0)
        self._length_m = np.hypot(*self._along.T)
        self._heading = _headings(self._along)
        self._segment = 0

    def nearest(self, x_m: float, y_m: float) -> Foot:
        """The foot of a point; the heading is interpolated between waypoints."""
        last = min(self._segment + SEARCHED, len(self._along))
        start, along = self._points_m[self._segment : last], self._along[self._segment : last]
        away = np.array([x_m, y_m]) - start
        share = np.clip(np.sum(away * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
        best = int(np.argmin(np.hypot(*(away - share[:, None] * along).T)))
        self._segment += best
        across = float(along[best, 0] * away[best, 1] - along[best, 1] * away[best, 0])
        before, after = self._heading[self._segment : self._segment + 2].tolist()
        heading = wrap_angle(before + float(share[best]) * (after - before))
        return Foot(across / float(self._length_m[self._segment]), heading)

    def ahead(self, x_m: float, y_m: float, reach_m: float) -> tuple[float, float]:
        """m, the first point of the line beyond the foot of (x, y) at the distance `reach_m` from (x, y).

        The foot itself if it is farther away, and the line's end if all of it is nearer.
        """
        self.nearest(x_m, y_m)
        for segment in range(self._segment, len(self._along)):
            share = self._exit_share(segment, x_m, y_m, reach_m)
            if share < 1.0:
                break
        x, y = (self._points_m[segment] + min(share, 1.0) * self._along[segment]).tolist()
        return x, y

    def _exit_share(self, segment: int, x_m: float, y_m: float, reach_m: float) -> float:
        """Share of a segment at which its line leaves the circle around (x, y); else its nearest point."""
        along, length_m = self._along[segment], float(self._length_m[segment])
        dx, dy = x_m - float(self._points_m[segment, 0]), y_m - float(self._points_m[segment, 1])
        foot_m = (dx * float(along[0]) + dy * float(along[1])) / length_m
        across_m = (float(along[0]) * dy - float(along[1]) * dx) / length_m
        leaving_m = foot_m + sqrt(max(reach_m**2 - across_m**2, 0.0))
        return max(leaving_m / length_m, 0.0)


def _headings(along: Floats) -> Floats:
    """(M,) rad, continuous: the mean of adjacent segments at waypoints, the segment's own at the ends."""
    heading = unwrapped(np.arctan2(along[:, 1], along[:, 0]))
    between = 0.5 * (heading[:-1] + heading[1:])
    return np.concatenate([heading[:1], between, heading[-1:]])
