"""All that is on the road or near it, as tracks."""

from dataclasses import dataclass, fields

import numpy as np

from vpf_sim.types import Floats, Integers


@dataclass(frozen=True, slots=True)
class Tracks:
    """K rectangles that move along their heading.

    `s_m` and `d_m` are nan where the road's reference line does not pass. `covariance` is of the place and the velocity
    in the track's own axes: along m, across m, along m/s, across m/s.
    """

    x_m: Floats  # (K,) middle, in the world
    y_m: Floats  # (K,)
    heading_rad: Floats  # (K,) in the world
    speed_mps: Floats  # (K,) along the heading
    yaw_rate_radps: Floats  # (K,)
    length_m: Floats  # (K,)
    width_m: Floats  # (K,)
    s_m: Floats  # (K,) on the road
    d_m: Floats  # (K,)
    existence: Floats  # (K,) log-odds
    covariance: Floats  # (K, 4, 4)
    identity: Integers  # (K,) stays with a track

    def __len__(self) -> int:
        return len(self.x_m)

    def select(self, rows: Integers) -> "Tracks":
        """Some of the tracks, by their rows."""
        return Tracks(*(getattr(self, field.name)[rows] for field in fields(self)))

    @property
    def probability(self) -> Floats:
        """(K,) of existence."""
        odds: Floats = 1.0 / (1.0 + np.exp(-self.existence))
        return odds
