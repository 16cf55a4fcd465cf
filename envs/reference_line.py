"""The line along which a road's places are measured: s along it, and metres right of it."""

from typing import Protocol

from numpy.typing import ArrayLike

from vpf_sim.types import Floats


class ReferenceLine(Protocol):
    """A smooth line, extended straight beyond both ends; methods with the suffix `_at` take single points."""

    length_m: float

    def position(self, s_m: ArrayLike, lateral_m: ArrayLike = 0.0) -> Floats:
        """(..., 2) m, the world points at s along the line and `lateral` right of it."""
        ...

    def heading(self, s_m: ArrayLike) -> Floats:
        """(...) rad."""
        ...

    def curvature(self, s_m: ArrayLike) -> Floats:
        """(...) 1/m, > 0 turns right; 0 beyond both ends."""
        ...

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]:
        """`position` of one point."""
        ...

    def heading_at(self, s_m: float) -> float:
        """`heading` at one s."""
        ...
