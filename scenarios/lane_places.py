"""Where the borders of lanes lie beside a road's centre line: piecewise linear functions of the distance along it."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from vpf_sim.types import Floats


class WidthsAt(Protocol):
    """The widths of lanes at one place."""

    @property
    def s_m(self) -> float: ...
    @property
    def lanes_m(self) -> tuple[float, ...]: ...
    @property
    def left_edge_m(self) -> float | None: ...


class LanePlaces:
    """The borders of lanes, m right of the centre line: linear between places, constant beyond the ends.

    Border 0 is the left edge of the carriageway; lane 1 is the rightmost, between the last two borders.
    """

    def __init__(self, widths: Sequence[WidthsAt]) -> None:
        self.s_m: Floats = np.array([one.s_m for one in widths])  # (K,)
        self._borders_m: Floats = np.array([_borders(one) for one in widths])  # (K, lanes + 1)

    def borders(self, s_m: ArrayLike) -> Floats:
        """(lanes + 1, ...) m, from the left, at each s."""
        s = np.asarray(s_m, float)
        return np.stack([np.interp(s, self.s_m, border) for border in self._borders_m.T])

    def middle(self, lane: int, s_m: ArrayLike) -> Floats:
        """(...) m, the centre of a lane, counted from the right."""
        borders = self.borders(s_m)
        return np.asarray(0.5 * (borders[-lane] + borders[-lane - 1]))

    @property
    def widest_m(self) -> float:
        """How far an edge is from the centre line at most."""
        return float(max(-self._borders_m[:, 0].min(), self._borders_m[:, -1].max()))

    def reach_within(self, low_m: float, high_m: float) -> tuple[float, float]:
        """(left, right) m, how far the edges are from the centre line at most between two s."""
        borders = self._within(low_m, high_m)
        return float(-borders[0].min()), float(borders[-1].max())

    def edges_within(self, low_m: float, high_m: float) -> tuple[float, float]:
        """(left, right) m, the edges of the narrowest carriageway between two s."""
        borders = self._within(low_m, high_m)
        return float(borders[0].max()), float(borders[-1].min())

    def _within(self, low_m: float, high_m: float) -> Floats:
        """(lanes + 1, N) m, the borders at two s and at each place between them."""
        inside = self.s_m[(self.s_m > low_m) & (self.s_m < high_m)]
        return self.borders(np.array([low_m, *inside, high_m]))


def _borders(widths: WidthsAt) -> list[float]:
    total = sum(widths.lanes_m)
    left = -0.5 * total if widths.left_edge_m is None else widths.left_edge_m
    return [left, *(left + np.cumsum(widths.lanes_m[::-1])).tolist()]
