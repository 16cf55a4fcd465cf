"""The record of one replayed drive: scores, notes, warnings, and where each signal comes from."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vpf_sim.files import file_name
from vpf_sim.replay import camera_fixed_points, drive_warnings, scores, speed_interval
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.open_loop_driver import DriverError, OpenLoopDriver
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.segments import goal_text
from vpf_sim.types import Floats


@dataclass(slots=True)
class Accumulated:
    """Values collected frame by frame for the whole drive."""

    fixed_points: camera_fixed_points.CameraFixedPoints
    rows: list[FrameRow] = field(default_factory=list)
    error: DriverError | None = None  # that ended the drive
    speed_votes: list[tuple[float, Floats]] = field(default_factory=list)  # (time s, m/s)
    faults: list[str] = field(default_factory=list)  # why images are missing

    def notes(self) -> list[str]:
        """Why there are gaps, in one line."""
        if not self.faults:
            return []
        more = len(self.faults) - 1
        return [f"gaps: {self.faults[0]}" + (f", and {more} more" if more else "")]


def of(
    recording: Recording, driver_name: str, replayed: OpenLoopDriver, table: FrameTable, accumulated: Accumulated
) -> dict[str, Any]:
    """The record, a function of recording, driver and code."""
    record = _without_warnings(recording, driver_name, replayed, table)
    record["notes"] += accumulated.notes()
    record["error"] = accumulated.error.entry() if accumulated.error else None
    lane_widths_m = table.lane_width_m[np.isfinite(table.lane_width_m)].tolist()
    record["warnings"] = drive_warnings.of_commands(replayed.unlike_training(), table) + drive_warnings.collect(
        recording, record, accumulated.fixed_points, lane_widths_m
    )
    return record


def _without_warnings(
    recording: Recording, driver_name: str, replayed: OpenLoopDriver, table: FrameTable
) -> dict[str, Any]:
    camera = recording.camera
    return {
        "name": recording.name,
        "file": file_name(recording.name),
        "driver": driver_name,
        "layout": recording.layout,
        "weather": recording.weather,
        "added": _added(recording),
        "frames": len(table),
        "held": int(np.count_nonzero(table.held == 1.0)),
        "gaps": int(np.count_nonzero(table.image == 0.0)),
        "rate_hz": scores.rounded(recording.rate_hz),
        "foe_median_error_px": scores.foe_error(table, "foe"),
        "foe_median_error_own_derotation_px": scores.foe_error(table, "own_foe"),
        "accuracy": scores.accuracies(table, recording),
        "perception": scores.perception(table, recording),
        "signal_checks": scores.signal_checks(recording),
        "derived": list(recording.derived),
        "origins": {name: {"kind": origin.kind, "how": origin.how} for name, origin in recording.origins.items()},
        "obstacles_by": _labelled_by(recording, table),
        "goal": goal_text(recording),
        "protocol": replayed.protocol,
        "segments": int(table.segment.max(initial=-1.0)) + 1,
        "restarts": replayed.restarts,
        "camera": {
            "width_px": camera.width_px,
            "height_px": camera.height_px,
            "focal_px": scores.rounded(camera.fx_px),
            "height_m": scores.rounded(camera.height_m),
        },
        "mounting": drive_warnings.mounting(recording) or None,
        "speed_interval": _speed_interval(recording),
        "notes": [*recording.notes, *scores.notes(table, recording)],
        "driven": bool(np.isfinite(table.throttle).any()),
        "no_images": recording.no_images or None,
    }


def _labelled_by(recording: Recording, table: FrameTable) -> str | None:
    if np.isfinite(recording.obstacle).any():
        return "label"
    return "own detection" if np.isfinite(table.obstacle_detected).any() else None


def _added(recording: Recording) -> str | None:
    """What was simulated on top of the recording, if anything."""
    origins = [recording.origins[name] for name in ("weather", "sensor_faults") if name in recording.origins]
    return "; ".join(origin.how for origin in origins if origin.kind != "recorded") or None


def _speed_interval(recording: Recording) -> dict[str, Any] | None:
    """The interval of the mean speed, and of its ratio to the stated one; None if it does not come from the images."""
    found = speed_interval.of(recording)
    if found is None:
        return None
    least, most = found.range_mps
    values = {"mean_mps": found.mean_mps, "from_mps": least, "to_mps": most, "low": found.low, "high": found.high}
    return {**{key: scores.rounded(value) for key, value in values.items()}, "narrowed_by": found.parts[0].remedy}
