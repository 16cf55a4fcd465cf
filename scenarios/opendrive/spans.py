"""The exact curve of the carriageway's centre: the reference line, shifted sideways by a polynomial.

At s, with the reference line's heading h, its speed v (1 unless a polynomial's length differs from its geometry's) and
the shift t to the left, the centre moves by a = v - t h' along the heading and by t' to the left, so that

    heading = h + atan2(t', a),    turn = h' + (t'' a - t' a') / (a^2 + t'^2).

Derivatives are by s. Curvature is the turn divided by the centre's own speed, the root of a^2 + t'^2.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.carriageway import Stretch
from vpf_sim.scenarios.opendrive.cubics import Complexes, Cubic
from vpf_sim.scenarios.opendrive.geometry import Geometry
from vpf_sim.types import Floats


class Centre(NamedTuple):
    """The carriageway's centre at some s, in our axes (y right) and along the drive."""

    point: Complexes  # m, x + iy
    heading_rad: Floats
    turn_per_m: Floats  # by s
    speed: Floats  # metres of the curve for a metre of s


@dataclass(frozen=True, slots=True)
class Span:
    """A smooth part of the centre's curve, driven from `first_m` to `last_m` of the road's s."""

    where: str  # the road in messages
    geometry: Geometry
    shift: Cubic
    first_m: float
    last_m: float

    def at(self, s_m: Floats) -> Centre:
        """Raises InputError where the road bends more than the shift allows."""
        line, (t, slope, bend) = self.geometry.at(s_m), self.shift.at(s_m)
        along = self.geometry.stretch - t * line.turn_per_m
        if along.min() <= 0.0:
            raise InputError(
                f"{self.where}: planView: expected bends wider than the lanes' distance from the reference line, "
                f"got a radius of {1.0 / np.abs(line.turn_per_m).max():.2f} m"
            )
        along_slope = -(slope * line.turn_per_m + t * line.turn_rate_per_m2)
        heading = line.heading_rad + np.arctan2(slope, along)
        turn = line.turn_per_m + (bend * along - slope * along_slope) / (along**2 + slope**2)
        point = line.point + 1j * np.exp(1j * line.heading_rad) * t
        forward = self.last_m > self.first_m
        # Our y has the other sign, and so have headings and turns; a drive against s changes the turn again.
        return Centre(
            np.conj(point),
            -heading if forward else np.pi - heading,
            -turn if forward else turn,
            np.hypot(along, slope),
        )


def span(stretch: Stretch, share: float) -> Span:
    """The curve of a stretch, between the inner edge of its lanes (0) and the outer one (1)."""
    geometries = stretch.leg.road.geometries
    middle_m = 0.5 * (stretch.low_m + stretch.high_m)
    geometry = next((one for one in reversed(geometries) if one.s_m <= middle_m), geometries[0])
    ends = (stretch.low_m, stretch.high_m)
    first_m, last_m = ends if stretch.leg.forward else reversed(ends)
    return Span(stretch.leg.road.where, geometry, stretch.line(share), first_m, last_m)
