"""The step table: one row per frame of an episode; every score is a function of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydantic import BaseModel

from vpf_sim.evaluation import parquet
from vpf_sim.types import Floats

if TYPE_CHECKING:
    import pandas as pd


class Step(NamedTuple):
    """One row: the state, and the driver's command in it (nan in the last row)."""

    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    yaw_rate_radps: float
    route_m: float  # driven along the route
    lane_offset_m: float  # from the centre of the ego's lane, + is right
    clearance_m: float  # from the ego's outline to the nearest object's; inf without objects
    ttc_s: float = inf  # until the ego touches an object ahead at constant velocities
    passing: float = 0.0  # 1 from 25 m before an obstacle to 15 m after it
    throttle: float = nan
    steering: float = nan
    pid_throttle: float = nan  # what the PID would do in this state
    pid_steering: float = nan
    paired_throttle: float = nan  # what the PID did at this distance in its own run without obstacles
    paired_steering: float = nan
    foe_x_px: float = nan  # estimated; nan without an estimate, or with confidence 0
    foe_y_px: float = nan
    true_foe_x_px: float = nan
    true_foe_y_px: float = nan
    seen_left_m: float = nan  # perceived offset of the left edge from a point 10 m ahead
    seen_right_m: float = nan
    true_left_m: float = nan
    true_right_m: float = nan
    flow_error_px: float = nan  # median end-point error of the flow, in scored frames
    ttc_error: float = nan  # median relative error of the times to contact, in scored frames
    objects_right: float = nan  # correct detections in the corridor
    objects_wrong: float = nan  # false positives in the corridor
    new_wrong_objects: float = nan  # false positives that were not false before
    met_kind: float = nan  # index in KINDS of an obstacle that the front bumper reached in the corridor
    met_confirmed_m: float = nan  # from the bumper to that obstacle at its first detection; nan if never detected
    outside: float = 0.0  # 1 where a corner of the ego is beyond the carriageway's edge
    in_lane: float = 1.0  # 1 where all corners of the ego are in one lane
    looked: float = 0.0  # 1 where the driver used the frame
    near_bearing_rad: float = nan  # of the nearest object's centre from the rear axle, off the heading, + is right
    near_bumper_m: float = nan  # from the front bumper to that object
    near_speed_mps: float = nan  # of that object
    near_confirmed_m: float = nan  # from the bumper to that object at its first detection; nan if never detected
    near_sticks_out_m: float = nan  # how far it reaches beyond what is reported of it, to a side or towards the car
    wrong_ahead_m: float = nan  # from the bumper to the nearest false positive in the corridor
    free_m: float = nan  # below walking speed: widest gap across the carriageway before it
    reference_mps: float = nan  # speed of the driver's plan
    heading_error_rad: float = nan  # heading less that of the plan
    motion_right_m: float = (
        nan  # from the beginning of the motion planned in space and time to its path's end, + is right
    )
    motion_1s_mps: float = nan  # its speed after a second
    motion_end_mps: float = nan  # and at the horizon
    motion_cost: float = nan
    motion_breaks_limit: float = nan  # 1 where it breaks a limit, as all other candidates do
    rejected_acceleration: float = nan  # candidates rejected for the acceleration along the road
    rejected_lateral_acceleration: float = nan
    rejected_curvature: float = nan
    rejected_steering_rate: float = nan
    rejected_road_edge: float = nan
    rejected_collision: float = nan  # of those that were compared with the objects
    uncertainty: float = nan  # that the driver states of its command; above 1 it calls itself unsure


LATER = Step._fields[Step._fields.index("near_confirmed_m") :]  # runs of earlier versions lack them


@dataclass(frozen=True, slots=True)
class StepTable:
    """The rows of n steps and of the final state; `table.speed_mps` is the (n + 1,) column of that name."""

    rows: Floats  # (n + 1, len(Step._fields)); no row if the episode never began

    @classmethod
    def of(cls, steps: Sequence[Step]) -> "StepTable":
        """The table of these rows."""
        return cls(np.array(steps, dtype=float).reshape(-1, len(Step._fields)))

    def __getattr__(self, name: str) -> Floats:
        if name not in Step._fields:
            raise AttributeError(f"the step table has no column '{name}'")
        column: Floats = self.rows[:, Step._fields.index(name)]
        return column

    def data_frame(self) -> "pd.DataFrame":
        """The rows with their names as a pandas data frame."""
        import pandas as pd

        return pd.DataFrame(self.rows, columns=list(Step._fields), copy=True)

    def __len__(self) -> int:
        """n, the number of commands."""
        return max(0, len(self.rows) - 1)

    @property
    def positions_m(self) -> Floats:
        """(n + 1, 2)"""
        return np.column_stack([self.x_m, self.y_m])

    def replaced(self, columns: Mapping[str, Floats]) -> "StepTable":
        """A copy with new (n + 1,) values in some columns."""
        rows = self.rows.copy()
        for name, values in columns.items():
            rows[:, Step._fields.index(name)] = values
        return StepTable(rows)

    def states(self) -> bytes:
        """Poses, speeds and commands as bytes; two episodes are equal if these are."""
        names = ("time_s", "x_m", "y_m", "yaw_rad", "speed_mps", "yaw_rate_radps", "throttle", "steering")
        return np.column_stack([getattr(self, name) for name in names]).astype("<f8").tobytes()


def write(table: StepTable, path: Path) -> None:
    """Write the table as a Parquet file, atomically."""
    parquet.write(table.rows, Step._fields, path)


def read(path: Path) -> StepTable:
    """The table that `write` stored; InputError where it is missing or of another version."""
    return StepTable(parquet.read(path, Step._fields, "the steps of an episode", "step", LATER))


class InvalidFrame(BaseModel, frozen=True, strict=True):
    """The camera frame that ended an episode."""

    frame: int
    time_s: float
    fault: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """The closed loop's result."""

    status: str
    steps: StepTable
    collided_with: str | None
    frames_sha256: str | None  # None: the driver uses no frames
    traceback: str | None = None  # of an exception in the driver or the harness
    invalid_frame: InvalidFrame | None = None
