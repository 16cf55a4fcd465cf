"""The record of one replayed drive: scores, notes, warnings, and where each signal comes from."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from vpf_sim.files import file_name
from vpf_sim.replay import records, scores, speed_interval
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.model_vehicle import goal_text
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.open_loop_driver import DriverError, OpenLoopDriver
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.records import DriveRecord, DriveWarning, MountingAngle, PerceptionScores
from vpf_sim.replay.scores import rounded
from vpf_sim.types import Camera, Floats

CERTAIN_RAD = 0.009  # half width of an interval that needs no warning: half a degree
MOST_MISSING_SHARE = 0.05  # share of frames without flow or lane that needs a warning
MOVING_MPS, FULL_BRAKE, MOST_BRAKING_SHARE = 2.0, -0.95, 0.5  # share of such commands that needs a warning
THIRDS = ("upper", "middle", "lower")


@dataclass(slots=True)
class Accumulated:
    """Values collected frame by frame for the whole drive."""

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
    recording: Recording,
    driver_name: str,
    replayed: OpenLoopDriver,
    table: FrameTable,
    accumulated: Accumulated,
    fixed: FixedStructure | None,
) -> DriveRecord:
    """The record, a function of recording, driver and code."""
    perceived = scores.perception(table, recording)
    commands = of_commands(replayed.unlike_training(), table)
    doubtful = of_recording(recording, perceived, table.lane_width_m, fixed)
    return DriveRecord(
        name=recording.name,
        file=file_name(recording.name),
        driver=driver_name,
        layout=recording.layout,
        weather=recording.weather,
        added=_added(recording),
        frames=len(table),
        held=int(np.count_nonzero(table.held == 1.0)),
        gaps=int(np.count_nonzero(table.image == 0.0)),
        rate_hz=rounded(recording.rate_hz),
        foe_median_error_px=scores.foe_error(table, "foe"),
        foe_median_error_own_derotation_px=scores.foe_error(table, "own_foe"),
        accuracy=scores.accuracies(table, recording),
        perception=perceived,
        signal_checks=scores.signal_checks(recording),
        derived=recording.derived,
        origins={name: records.SignalOrigin(kind=one.kind, how=one.how) for name, one in recording.origins.items()},
        obstacles_by=_labelled_by(recording, table),
        goal=goal_text(recording),
        protocol=replayed.protocol,
        segments=int(table.segment.max(initial=-1.0)) + 1,
        restarts=replayed.restarts,
        camera=_shape(recording.camera),
        mounting={name: _angle(found) for name, found in recording.mounting_found.items()} or None,
        speed_interval=_mean_speed(recording),
        notes=(*recording.notes, *scores.notes(table, recording), *accumulated.notes()),
        driven=bool(np.isfinite(table.throttle).any()),
        no_images=recording.no_images or None,
        error=accumulated.error.fault() if accumulated.error else None,
        warnings=(*commands, *doubtful),
    )


def _shape(camera: Camera) -> records.CameraShape:
    focal_px, height_m = rounded(camera.fx_px), rounded(camera.height_m)
    return records.CameraShape(
        width_px=camera.width_px, height_px=camera.height_px, focal_px=focal_px, height_m=height_m
    )


def _labelled_by(recording: Recording, table: FrameTable) -> str | None:
    if np.isfinite(recording.obstacle).any():
        return "label"
    return "own detection" if np.isfinite(table.obstacle_detected).any() else None


def _added(recording: Recording) -> str | None:
    origins = [recording.origins[name] for name in ("weather", "sensor_faults") if name in recording.origins]
    return "; ".join(origin.how for origin in origins if origin.kind != "recorded") or None


def _angle(found: Angle) -> MountingAngle:
    low, high = found.interval_deg
    ends = {"deg": float(np.degrees(found.rad)), "from_deg": low, "to_deg": high, "straight_s": found.seconds}
    return MountingAngle(used=found.is_used, **{key: rounded(value) for key, value in ends.items()})


def _mean_speed(recording: Recording) -> records.MeanSpeed | None:
    """The interval of the mean speed; None if it does not come from the images."""
    found = speed_interval.of(recording)
    if found is None:
        return None
    least, most = found.range_mps
    values = {"mean_mps": found.mean_mps, "from_mps": least, "to_mps": most, "low": found.low, "high": found.high}
    return records.MeanSpeed(
        **{key: rounded(value) for key, value in values.items()}, narrowed_by=found.parts[0].remedy
    )


def of_commands(unlike_training: str, table: FrameTable) -> Iterator[DriveWarning]:
    """Warnings about a driver's commands: inputs unlike those of its training, and lasting full braking."""
    if unlike_training:
        yield DriveWarning("driver", f"{unlike_training}: its commands mean little here")
    moving = np.isfinite(table.throttle) & (table.speed_mps > MOVING_MPS)
    braking = float(np.mean(table.throttle[moving] <= FULL_BRAKE)) if moving.any() else 0.0
    if braking > MOST_BRAKING_SHARE:
        often = f"in {100.0 * braking:.0f} % of the frames of a moving car"
        yield DriveWarning("braking", f"the driver brakes fully {often}")


def of_recording(
    recording: Recording, perceived: PerceptionScores, lane_widths_m: Floats, fixed: FixedStructure | None
) -> Iterator[DriveWarning]:
    """Warnings about lens, mounting, speed, flow, lane, and what is `fixed` to the camera."""
    if "lens" in recording.assumed:
        narrow, wide = sorted(speed_interval.VIEWS_DEG)
        why = (
            f"60 deg across, assumed; cameras have {narrow:g} to {wide:g} deg: distances, speed and angles depend on it"
        )
        yield DriveWarning("field of view", f"{why}; give field_of_view_deg or fx_px")
    yield from _mounting(recording)
    yield from _speed(recording, lane_widths_m)
    yield from _missing("flow", perceived.foe.share, "the last prediction is held")
    yield from _missing("lane", perceived.road_found_share, "course and speed are held, not scored")
    yield from _fixed(fixed)


def _mounting(recording: Recording) -> Iterator[DriveWarning]:
    uncertain = {
        name: found
        for name, found in recording.mounting_found.items()
        if not found.is_used or found.half_width_rad > CERTAIN_RAD
    }
    if uncertain:
        words = ", ".join(f"{name} {_interval(found)}" for name, found in uncertain.items())
        yield DriveWarning("mounting", f"{words}: drive straight for longer, or give pitch_deg and yaw_deg")


def _interval(found: Angle) -> str:
    low, high = found.interval_deg
    return f"{low:.1f} to {high:.1f} deg ({'used' if found.is_used else 'not used, 0 assumed'})"


def _speed(recording: Recording, lane_widths_m: Floats) -> Iterator[DriveWarning]:
    """The interval of a speed by the flow, and whether the lanes (N,) have an unusual width."""
    found = speed_interval.of(recording)
    if found is None:
        return
    (narrow, wide), why = speed_interval.LANE_WIDTHS_M, speed_interval.text(found)
    widths_m = lane_widths_m[np.isfinite(lane_widths_m)]
    if len(widths_m) and not narrow <= (lanes_m := float(np.median(widths_m))) <= wide:
        why += f"; lanes come out {lanes_m:.1f} m wide"
    yield DriveWarning("speed", why)


def _missing(what: str, share: float | None, then: str) -> Iterator[DriveWarning]:
    if share is not None and 1.0 - share >= MOST_MISSING_SHARE:
        yield DriveWarning(what, f"none in {100.0 * (1.0 - share):.0f} % of the frames: then {then}")


def _fixed(fixed: FixedStructure | None) -> Iterator[DriveWarning]:
    if fixed is not None and fixed.is_visible:
        mask = fixed.off_centre
        third = THIRDS[int(np.argmax([part.mean() for part in np.array_split(mask, 3)]))]
        where = f"{100.0 * mask.mean():.1f} % of the image, most of it in the {third} third"
        what = "a bonnet, a text, or dirt, drops or reflections on the windscreen"
        yield DriveWarning("fixed to the camera", f"{where}, does not move while the car does: {what}")
