"""All that is on the road or near it, as tracks."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from vpf_sim.scene.lanes import LanePlace
from vpf_sim.types import Bools, Floats, Integers

VEHICLE_M = 3.0, 1.2  # length and width, beyond which something is as large as a vehicle


def vehicle_sized(length_m: Floats, width_m: Floats) -> Bools:
    """(K,) what is as large as a vehicle."""
    return np.asarray((length_m > VEHICLE_M[0]) & (width_m > VEHICLE_M[1]))


@dataclass(frozen=True, slots=True)
class Tracks:
    """K rectangles that move along their heading.

    `s_m` and `d_m` are nan where the road's reference line does not pass. `covariance` is of the place and the velocity
    in the track's own axes: along m, across m, along m/s, across m/s. `lanes` has K places, or is empty where none is
    known.
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
    covariance: Floats  # (K, 4, 4)
    lanes: tuple[LanePlace | None, ...] = ()

    def __len__(self) -> int:
        return len(self.x_m)

    def select(self, rows: Integers) -> "Tracks":
        """Some of the tracks, by their rows."""
        columns = {field.name: getattr(self, field.name)[rows] for field in fields(self) if field.name != "lanes"}
        return Tracks(**columns, lanes=tuple(self.lanes[row] for row in rows.tolist()) if self.lanes else ())

    def concatenate(self, others: "Tracks") -> "Tracks":
        """These and others; lanes are not known."""
        columns: dict[str, Any] = {
            field.name: np.concatenate([getattr(self, field.name), getattr(others, field.name)])
            for field in fields(self)
            if field.name != "lanes"
        }
        return Tracks(**columns)


def probability(log_odds: Floats) -> Floats:
    """The probabilities that log-odds stand for."""
    share: Floats = 1.0 / (1.0 + np.exp(-log_odds))
    return share
