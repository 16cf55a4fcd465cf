"""The cars ahead and behind on a lane, from an index that is made once a tick."""

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from highway_env.road.road import LaneIndex, Road
from highway_env.vehicle.objects import Landmark, RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.highway.lane_table import LaneTable
from vpf_sim.types import Bools, Floats

MARGIN_M = 1.0  # beside the lane, as in highway-env's search


@dataclass(frozen=True, slots=True)
class _Row:
    """The objects on a lane and those it is connected with, in order of s; of equal s, in the road's order."""

    s_m: list[float]
    numbers: list[int]


class Neighbours:
    """The results of `Road.neighbour_vehicles` while nothing moves; objects are the road's, numbered in its order."""

    def __init__(self, road: Road, table: LaneTable) -> None:
        self._road, self._table = road, table
        self.objects: list[RoadObject] = [*road.vehicles, *road.objects]
        self.number = {id(obj): number for number, obj in enumerate(self.objects)}
        positions = np.array([obj.position for obj in self.objects])
        self.s_m, self.lateral_m = table.coordinates(positions)  # (L, N)
        counted = [not isinstance(obj, Landmark) for obj in road.objects]
        self._counts: Bools = np.array([True] * len(road.vehicles) + counted)
        self._on: Bools = table.are_on(self.s_m, self.lateral_m, MARGIN_M) & self._counts
        self._rows: dict[LaneIndex, _Row] = {}

    def around(self, number: int, lane: LaneIndex) -> tuple[int, int]:
        """The numbers of the objects ahead of and behind another on a lane; -1 where there is none."""
        row = self._rows.get(lane)
        if row is None:
            row = self._rows[lane] = self._row(lane)
        s = float(self.s_m[self._table.number[lane], number])
        first = bisect_left(row.s_m, s)
        return _ahead(row, first, number), _behind(row, first)

    def _row(self, lane: LaneIndex) -> _Row:
        on, s = self._placed(lane)
        numbers = np.flatnonzero(on)
        order = np.argsort(s[numbers], kind="stable")
        return _Row(s[numbers][order].tolist(), numbers[order].tolist())

    def _placed(self, lane: LaneIndex) -> tuple[Bools, Floats]:
        """(N,) whether objects are on a lane or one that it is connected with, and s along the first."""
        here = self._table.number[lane]
        if not self._road.neighbour_vehicles_connected_lanes:
            return self._on[here], self.s_m[here]
        lanes, offsets = self._connected(lane)
        on = self._on[lanes]
        first: NDArray[np.intp] = np.argmax(on, axis=0)
        columns = np.arange(len(first))
        return np.any(on, axis=0), self.s_m[lanes][first, columns] + np.array(offsets)[first]

    def _connected(self, lane: LaneIndex) -> tuple[list[int], list[float]]:
        """The lane, those that it leads into and that lead into it, and what to add to s on each."""
        table, graph = self._table, self._road.network.graph
        start, end, wanted = lane
        lanes, offsets = [table.number[lane]], [0.0]
        for following, onward in graph.get(end, {}).items():
            if onward:
                lanes.append(table.number[end, following, wanted if wanted < len(onward) else 0])
                offsets.append(float(table.lanes[lanes[0]].length))
        for before, ends in graph.items():
            if ends.get(start):
                lanes.append(table.number[before, start, wanted if wanted < len(ends[start]) else 0])
                offsets.append(-float(table.lanes[lanes[-1]].length))
        return lanes, offsets


def _ahead(row: _Row, first: int, number: int) -> int:
    """The nearest from a position in the row on; of equally near ones the last, as in highway-env."""
    found, nearest_m = -1, 0.0
    for position in range(first, len(row.s_m)):
        if found >= 0 and row.s_m[position] > nearest_m:
            break
        if row.numbers[position] != number:
            found, nearest_m = row.numbers[position], row.s_m[position]
    return found


def _behind(row: _Row, first: int) -> int:
    """The nearest before a position in the row; of equally near ones the first, as in highway-env."""
    return -1 if first == 0 else row.numbers[bisect_left(row.s_m, row.s_m[first - 1])]
