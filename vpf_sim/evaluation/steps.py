"""The step table: what happened in an episode, one row a frame; every score is a function of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vpf_sim.evaluation import parquet
from vpf_sim.types import Floats


class Step(NamedTuple):
    """One row: the state that the driver saw, and the command that it gave there (nan in the last row)."""

    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    yaw_rate_radps: float
    route_m: float  # driven along the route
    lane_offset_m: float  # from the centre of the ego's lane, + is right
    clearance_m: float  # between the ego's body and the nearest other; inf without bodies
    ttc_s: float = inf  # until the ego touches a body ahead, if all keep their velocities
    passing: float = 0.0  # 1 from 25 m before a body to 15 m after it
    throttle: float = nan
    steering: float = nan
    pid_throttle: float = nan  # what the PID would do in this state
    pid_steering: float = nan
    paired_throttle: float = nan  # what the PID did at this distance in its own run without obstacles
    paired_steering: float = nan
    foe_x_px: float = nan  # estimated; nan where the driver has no such thing or does not trust it
    foe_y_px: float = nan
    true_foe_x_px: float = nan
    true_foe_y_px: float = nan
    seen_left_m: float = nan  # distance from a point 10 m ahead to the left edge of the carriageway, as perceived
    seen_right_m: float = nan
    true_left_m: float = nan
    true_right_m: float = nan
    flow_error_px: float = nan  # median end-point error of the flow, and relative error of the times to contact, of
    ttc_error: float = nan  # the frames that were judged
    objects_right: float = nan  # reports of the driver in its corridor that have a body there,
    objects_wrong: float = nan  # that have none,
    new_wrong_objects: float = nan  # and how many of these were not wrong before
    met_kind: float = nan  # of a body in the corridor that the front bumper came to
    met_confirmed_m: float = nan  # from the bumper to that body when it was first reported; nan if it never was
    outside: float = 0.0  # 1 where a corner of the body is beyond the carriageway's edge
    in_lane: float = 1.0  # 1 where all of its corners are in one lane
    looked: float = 0.0  # 1 where the driver looked at the frame
    near_bearing_rad: float = nan  # of the nearest body's centre from the rear axle, off the heading, + is right
    near_bumper_m: float = nan  # from the front bumper to that body
    near_speed_mps: float = nan  # of that body


@dataclass(frozen=True, slots=True)
class StepTable:
    """The rows of n steps and of the state in which they ended; `table.speed_mps` is the (n + 1,) column so called."""

    rows: Floats  # (n + 1, len(Step._fields)), or no row where the episode never began

    @classmethod
    def of(cls, steps: Sequence[Step]) -> "StepTable":
        """The table of these rows."""
        return cls(np.array(steps, dtype=float).reshape(-1, len(Step._fields)))

    def __getattr__(self, name: str) -> Floats:
        if name not in Step._fields:
            raise AttributeError(f"the step table has no column '{name}'")
        column: Floats = self.rows[:, Step._fields.index(name)]
        return column

    def __len__(self) -> int:
        """n, the number of commands."""
        return max(0, len(self.rows) - 1)

    @property
    def positions_m(self) -> Floats:
        """(n + 1, 2)"""
        return np.column_stack([self.x_m, self.y_m])

    def replaced(self, columns: Mapping[str, Floats]) -> "StepTable":
        """The same table with other values, one a row, in some columns."""
        rows = self.rows.copy()
        for name, values in columns.items():
            rows[:, Step._fields.index(name)] = values
        return StepTable(rows)

    def states(self) -> bytes:
        """What makes two episodes the same: poses, speeds and commands, bit by bit."""
        names = ("time_s", "x_m", "y_m", "yaw_rad", "speed_mps", "yaw_rate_radps", "throttle", "steering")
        return np.column_stack([getattr(self, name) for name in names]).astype("<f8").tobytes()


def write(table: StepTable, path: Path) -> None:
    """A Parquet file, whole or not at all."""
    parquet.write(table.rows, Step._fields, path)


def read(path: Path) -> StepTable:
    """The table that `write` stored; InputError where there is none of this version's."""
    return StepTable(parquet.read(path, Step._fields, "the steps of an episode", "step"))
