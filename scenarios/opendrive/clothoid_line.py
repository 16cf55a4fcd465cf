"""A finished line of clothoids, and how far a map's points are from it."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.geometry import Complexes
from vpf_sim.scenarios.opendrive.spans import Element, Piece, points_along
from vpf_sim.types import Floats

TOLERANCE_M = 0.05
ROUNDING_M = 0.002
ALONG_M = 0.25  # a kink of 1 deg leaves such a gap, or overlap, along a lane 14 m beside the reference line
TANGENT_M = 1e-3


class Line(NamedTuple):
    """Clothoids from a start, and how far along them the points of a map's pieces are."""

    start: complex
    heading_rad: float
    elements: tuple[Element, ...]
    along_m: Sequence[Floats]  # of the points of each piece

    def apart(self, along_m: Floats, points: Complexes) -> Complexes:
        """(N,) m, from the line's places to points: the real part along the line, the imaginary one to its right."""
        here, ahead = (
            points_along(self.elements, self.start, self.heading_rad, along_m + step) for step in (0.0, TANGENT_M)
        )
        return np.asarray((points - here) * np.conj((ahead - here) / TANGENT_M))

    def check(self, pieces: Iterable[Piece]) -> None:
        """Raise InputError where the line is farther from the true curve than the tolerance."""
        for piece, along_m in zip(pieces, self.along_m, strict=True):
            apart = self.apart(along_m, piece.points)
            ahead, lateral = np.abs(apart.real), np.abs(apart.imag)
            if not (lateral.max() <= TOLERANCE_M + ROUNDING_M and ahead.max() <= ALONG_M):
                worst = int(np.abs(apart).argmax())
                place = piece.points[worst]
                raise InputError(
                    f"{piece.where}: planView: expected a line that goes on within {TOLERANCE_M:g} m, "
                    f"got {abs(apart[worst]):.3f} m at x = {place.real:.2f}, y = {-place.imag:.2f}"
                )
