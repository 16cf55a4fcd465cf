"""The frame table: what was recorded, predicted and seen at each frame of a replayed drive; scores are made from it."""

from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vpf_sim.evaluation import parquet
from vpf_sim.types import Floats


class FrameRow(NamedTuple):
    """One frame. nan where something is unknown, 1 and 0 for yes and no; what is seen comes from the frame alone."""

    frame: float
    time_s: float
    segment: float  # counted from 0
    image: float  # 0: a gap, nothing was seen and the last prediction holds
    speed_mps: float
    yaw_rate_radps: float
    recorded_throttle: float
    recorded_steering: float  # road wheels / 40 deg, + is right
    obstacle_labelled: float
    lead_gap_m: float
    throttle: float = nan  # predicted
    steering: float = nan
    road_found: float = nan
    road_confidence: float = nan
    obstacle_seen: float = nan  # a body that the driver believes to stand in the way
    bodies: float = nan
    foe_x_px: float = nan  # the recorded rotation removed; nan where it is not to be used
    foe_y_px: float = nan
    foe_confidence: float = nan
    held: float = nan  # the flow was not to be trusted, so the last prediction holds
    own_foe_x_px: float = nan  # told of no rotation
    own_foe_y_px: float = nan
    true_foe_x_px: float = nan
    true_foe_y_px: float = nan
    flow_yaw_rate_radps: float = nan  # from the flow alone
    flow_speed_mps: float = nan  # by the flow of the road ahead and the camera's height above it
    ttc_s: float = nan  # to the body ahead where `lead_gap_m` has it; inf where its image does not grow


class FrameTable:
    """The rows as an array (N, columns); `table.steering` is the (N,) column so called."""

    def __init__(self, rows: Floats) -> None:
        self.rows = rows

    @classmethod
    def of(cls, rows: list[FrameRow]) -> "FrameTable":
        return cls(np.array(rows, dtype=float).reshape(-1, len(FrameRow._fields)))

    def __getattr__(self, name: str) -> Floats:
        if name not in FrameRow._fields:
            raise AttributeError(f"the frame table has no column '{name}'")
        column: Floats = self.rows[:, FrameRow._fields.index(name)]
        return column

    def replaced(self, name: str, values: Floats) -> "FrameTable":
        """The same table with other values (N,) in a column."""
        rows = self.rows.copy()
        rows[:, FrameRow._fields.index(name)] = values
        return FrameTable(rows)

    def __len__(self) -> int:
        return len(self.rows)


def write(table: FrameTable, path: Path) -> None:
    """A Parquet file, whole or not at all."""
    parquet.write(table.rows, FrameRow._fields, path)


def read(path: Path) -> FrameTable:
    """The table that `write` stored; InputError where there is none of this version's."""
    return FrameTable(parquet.read(path, FrameRow._fields, "the frames of a replayed drive", "frame"))
