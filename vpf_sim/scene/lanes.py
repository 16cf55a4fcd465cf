"""The lanes that a track is going to drive in, where they are known."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class LaneLine:
    """The middle of a lane and of those that it leads into, as N points; it goes straight on beyond both ends."""

    along_m: Floats  # (N,) from the lane's beginning
    x_m: Floats  # (N,) in the world
    y_m: Floats
    heading_rad: Floats  # (N,) continuous

    def at(self, along_m: Floats) -> tuple[Floats, Floats, Floats]:
        """x m, y m and heading rad at places of any shape."""
        x, y, heading = (np.interp(along_m, self.along_m, values) for values in (self.x_m, self.y_m, self.heading_rad))
        beyond = along_m - np.clip(along_m, self.along_m[0], self.along_m[-1])
        return x + beyond * np.cos(heading), y + beyond * np.sin(heading), heading


class LanePlace(NamedTuple):
    """A track's place in its lane."""

    line: LaneLine
    along_m: float
    right_m: float  # of the lane's middle
