"""The frame table: recorded, predicted and perceived values at each frame of a replayed drive."""

from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vpf_sim.evaluation import parquet
from vpf_sim.files import file_name
from vpf_sim.types import Camera, Floats, Perception, RoadEdges


class FrameRow(NamedTuple):
    """One frame; nan where unknown, 1 and 0 for yes and no."""

    frame: float
    time_s: float
    segment: float  # from 0
    image: float  # 0: a gap, the last prediction is held
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
    obstacle_detected: float = nan  # an obstacle in the corridor ahead
    obstacles: float = nan  # reported objects, and how many of them
    obstacles_standing: float = nan  # do not move
    obstacles_in_lane: float = nan  # have their middle in the own lane, off its lines
    obstacles_on_line: float = nan  # have it on one of the lane's two lines
    obstacles_wide: float = nan  # are wider than a vehicle
    nearest_in_lane_m: float = nan  # from the camera; inf without one
    lane_m: float = nan  # middle of the own lane, + is right; nan without a lane
    lane_width_m: float = nan
    flow_points: float = nan
    foe_x_px: float = nan  # recorded rotation removed; nan where unusable
    foe_y_px: float = nan
    foe_confidence: float = nan
    held: float = nan  # the flow was unreliable, the last prediction is held
    own_foe_x_px: float = nan  # without recorded rotation
    own_foe_y_px: float = nan
    true_foe_x_px: float = nan
    true_foe_y_px: float = nan
    flow_yaw_rate_radps: float = nan  # from the flow alone
    flow_speed_mps: float = nan  # by the road's flow and the camera's height
    ttc_s: float = nan  # to the lead vehicle; inf without looming


class FrameTable:
    """The rows as an array (N, columns); `table.steering` is the column (N,) of that name."""

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
        """The table with other values (N,) in a column."""
        rows = self.rows.copy()
        rows[:, FrameRow._fields.index(name)] = values
        return FrameTable(rows)

    def __len__(self) -> int:
        return len(self.rows)


def write(table: FrameTable, path: Path) -> None:
    """Write a Parquet file, complete or not at all."""
    parquet.write(table.rows, FrameRow._fields, path)


def read(path: Path) -> FrameTable:
    """The stored table; InputError where there is none of this version."""
    later = FrameRow._field_defaults.keys()  # columns that tables of earlier versions may lack
    return FrameTable(parquet.read(path, FrameRow._fields, "the frames of a replayed drive", "frame", later))


FRAMES, VIDEOS = "frames", "videos"


def table_path(folder: Path, drive: str) -> Path:
    """The table of a drive's frames."""
    return folder / FRAMES / f"{file_name(drive)}.parquet"


def video_path(folder: Path, drive: str) -> Path:
    """The video of a drive."""
    return folder / VIDEOS / f"{file_name(drive)}.mp4"


LINE_M = 0.5  # an object whose middle is nearer to a line of the own lane is on that line
WIDE_M = 4.0  # no vehicle is as wide


def columns(perception: Perception, camera: Camera) -> dict[str, float]:
    """The columns of the frame table for the objects that are reported, and the number of flow points.

    An object is in the own lane, on one of its two lines, or beside them. Its distance is from the camera.
    """
    obstacles, road = perception.obstacles, perception.road
    from_line_m = np.abs(obstacles.middle_m - lane_middle_m(road, obstacles.forward_m)) - 0.5 * road.lane_width_m
    in_lane = from_line_m < -LINE_M
    return {
        "obstacles": len(obstacles),
        "obstacles_standing": int(np.count_nonzero(obstacles.identity >= 0)),
        "obstacles_in_lane": int(np.count_nonzero(in_lane)),
        "obstacles_on_line": int(np.count_nonzero(np.abs(from_line_m) <= LINE_M)),
        "obstacles_wide": int(np.count_nonzero(obstacles.width_m > WIDE_M)),
        "nearest_in_lane_m": float(np.min(obstacles.forward_m[in_lane], initial=np.inf)) - camera.forward_m,
        "flow_points": len(perception.flow),
    }


def lane_middle_m(road: RoadEdges, forward_m: Floats) -> Floats:
    """(K,) lateral position of the own lane's middle at distances ahead of the pose."""
    return np.asarray(road.lane_m + forward_m * np.sin(road.heading_rad) + 0.5 * road.curvature_per_m * forward_m**2)
