"""All lanes of a highway-env network at once, with highway-env's own arithmetic: its results to the last bit.

A lane's coordinates are highway-env's: s along it and lateral to its right. `numpy.vecdot` is `numpy.dot` row by row,
so products are added in the same order as for a single point.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from highway_env.road.lane import AbstractLane, CircularLane, SineLane, StraightLane
from highway_env.road.road import LaneIndex, RoadNetwork
from highway_env.utils import wrap_to_pi
from numpy.typing import NDArray

from vpf_sim.types import Bools, Floats


class LaneKind(Protocol):
    """Lanes of one kind: (L,) of them at (L, N) points or coordinates."""

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        """(L, N) s and lateral of points (N, 2)."""
        ...

    def headings(self, s_m: Floats) -> Floats:
        """(L, N) rad at s (L, N)."""
        ...

    def widths(self, s_m: Floats) -> Floats:
        """(L, N) or (L, 1) m at s (L, N)."""
        ...


def _column(lanes: Sequence[AbstractLane], name: str) -> Floats:
    """(L, 1) an attribute of each lane."""
    return np.array([[getattr(lane, name)] for lane in lanes], float)


class _FixedWidth:
    def __init__(self, lanes: Sequence[AbstractLane]) -> None:
        self._width = _column(lanes, "width")

    def widths(self, s_m: Floats) -> Floats:  # noqa: ARG002
        return self._width


class _Straight(_FixedWidth):
    def __init__(self, lanes: Sequence[StraightLane]) -> None:
        super().__init__(lanes)
        self._start, self._along, self._right = (
            np.array([getattr(lane, name) for lane in lanes], float)[:, None]
            for name in ("start", "direction", "direction_lateral")
        )
        self._heading = _column(lanes, "heading")

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        delta = points_m - self._start
        return np.vecdot(delta, self._along), np.vecdot(delta, self._right)

    def headings(self, s_m: Floats) -> Floats:
        return np.broadcast_to(self._heading, s_m.shape)


class _Sine(_Straight):
    def __init__(self, lanes: Sequence[SineLane]) -> None:
        super().__init__(lanes)
        self._amplitude, self._pulsation, self._phase = (
            _column(lanes, name) for name in ("amplitude", "pulsation", "phase")
        )

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        s, lateral = super().coordinates(points_m)
        return s, lateral - self._amplitude * np.sin(self._pulsation * s + self._phase)

    def headings(self, s_m: Floats) -> Floats:
        slope = self._amplitude * self._pulsation * np.cos(self._pulsation * s_m + self._phase)
        return np.asarray(self._heading + np.arctan(slope))


class _Circular(_FixedWidth):
    def __init__(self, lanes: Sequence[CircularLane]) -> None:
        super().__init__(lanes)
        self._centre = np.array([lane.center for lane in lanes], float)[:, None]
        self._radius, self._start, self._side = (
            _column(lanes, name) for name in ("radius", "start_phase", "direction")
        )

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        delta = points_m - self._centre
        phase = np.arctan2(delta[..., 1].copy(), delta[..., 0].copy())
        phase = self._start + wrap_to_pi(phase - self._start)
        away = np.sqrt(np.vecdot(delta, delta))
        return self._side * (phase - self._start) * self._radius, self._side * (self._radius - away)

    def headings(self, s_m: Floats) -> Floats:
        phase = self._side * s_m / self._radius + self._start
        return np.asarray(phase + np.pi / 2 * self._side)


class _Other:
    """Lanes of other kinds, computed one by one."""

    def __init__(self, lanes: Sequence[AbstractLane]) -> None:
        self._lanes = lanes

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        found = np.array([[lane.local_coordinates(point) for point in points_m] for lane in self._lanes], float)
        s, lateral = found.reshape(len(self._lanes), len(points_m), 2).transpose(2, 0, 1)
        return s, lateral

    def headings(self, s_m: Floats) -> Floats:
        return np.array([[lane.heading_at(s) for s in row] for lane, row in zip(self._lanes, s_m, strict=True)], float)

    def widths(self, s_m: Floats) -> Floats:
        return np.array([[lane.width_at(s) for s in row] for lane, row in zip(self._lanes, s_m, strict=True)], float)


KINDS: dict[type, type] = {StraightLane: _Straight, SineLane: _Sine, CircularLane: _Circular}


class LaneTable:
    """The lanes of a network in its order, number by number; rows of all arrays are lanes."""

    def __init__(self, network: RoadNetwork) -> None:
        self.network = network
        named = network.lanes_dict()
        self.indexes: list[LaneIndex] = list(named)
        self.lanes: list[AbstractLane] = list(named.values())
        self.number = {index: number for number, index in enumerate(self.indexes)}
        self.length_m = _column(self.lanes, "length")
        self.reach_m = _column(self.lanes, "VEHICLE_LENGTH")  # a lane goes on so far before its start and after its end
        self._kinds: list[tuple[list[int], LaneKind]] = []
        kinds = [KINDS.get(type(lane), _Other) for lane in self.lanes]
        for kind in dict.fromkeys(kinds):
            rows = [number for number, other in enumerate(kinds) if other is kind]
            self._kinds.append((rows, kind([self.lanes[row] for row in rows])))

    def coordinates(self, points_m: Floats) -> tuple[Floats, Floats]:
        """(L, N) s and lateral, m, of points (N, 2) on every lane."""
        if len(self._kinds) == 1:
            return self._kinds[0][1].coordinates(points_m)
        s, lateral = np.empty((2, len(self.lanes), len(points_m)))
        for rows, lanes in self._kinds:
            s[rows], lateral[rows] = lanes.coordinates(points_m)
        return s, lateral

    def headings(self, s_m: Floats) -> Floats:
        """(L, N) rad at s (L, N)."""
        return np.asarray(self._of_kinds("headings", s_m))

    def headings_on(self, lanes: NDArray[np.intp], s_m: Floats) -> Floats:
        """(N,) rad, each at its own s on its own lane."""
        everywhere = self.headings(np.broadcast_to(s_m, (len(self.lanes), len(s_m))))
        return np.asarray(everywhere[lanes, np.arange(len(lanes))])

    def are_on(self, s_m: Floats, lateral_m: Floats, margin_m: float) -> Bools:
        """(L, N) whether places are on the lanes, as highway-env's `on_lane` says."""
        across = np.abs(lateral_m) <= self._of_kinds("widths", s_m) / 2 + margin_m
        return np.asarray(across & (-self.reach_m <= s_m) & (s_m < self.length_m + self.reach_m))

    def nearest(self, points_m: Floats, headings_rad: Floats) -> NDArray[np.intp]:
        """(N,) the number of the lane nearest by position and heading, as `get_closest_lane_index` says."""
        s, lateral = self.coordinates(points_m)
        angle = np.abs(wrap_to_pi(headings_rad - self.headings(s)))
        beyond, before = np.maximum(s - self.length_m, 0), np.maximum(0 - s, 0)
        return np.asarray(np.argmin(np.abs(lateral) + beyond + before + 1.0 * angle, axis=0))

    def _of_kinds(self, name: str, s_m: Floats) -> Any:
        if len(self._kinds) == 1:
            return getattr(self._kinds[0][1], name)(s_m)
        found = np.empty(s_m.shape)
        for rows, lanes in self._kinds:
            found[rows] = getattr(lanes, name)(s_m[rows])
        return found
