"""Warnings about the reliability of a replay, one line each with its size."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vpf_sim.replay import speed_interval
from vpf_sim.replay.camera_fixed_points import Artefact, CameraFixedPoints
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.scores import rounded

CERTAIN_RAD = 0.009  # half width of an interval that needs no warning: half a degree
MOST_MISSING_SHARE = 0.05  # share of frames without flow or lane that needs a warning
MOVING_MPS, FULL_BRAKE, MOST_BRAKING_SHARE = 2.0, -0.95, 0.5  # share of such commands that needs a warning

DriveWarning = tuple[str, str]  # (what, why)

ARTEFACTS: dict[Artefact, DriveWarning] = {
    "bonnet": ("bonnet", "it covers the lower edge of the image and may reflect the scene: point the camera higher"),
    "overlay": ("overlay", "a text, a logo or a mark on the windscreen stays in place"),
    "glass": ("reflections", "points stay in place while the car moves: water, dirt or a reflection on the windscreen"),
}


def collect(
    recording: Recording, record: dict[str, Any], fixed_points: CameraFixedPoints, lane_widths_m: Sequence[float]
) -> list[DriveWarning]:
    """All warnings for a drive, by its record, camera-fixed points and lane widths."""
    found = [_lens(recording), _mounting(recording), _speed(recording, lane_widths_m)]
    found += [_share("flow", record["perception"]["foe"]["share"], "the last prediction is held")]
    found += [_share("lane", record["perception"]["road_found_share"], "course and speed are held, not scored")]
    found += [ARTEFACTS[name] for name in fixed_points.found()]
    return [warning for warning in found if warning is not None]


def of_commands(unlike_training: str, table: FrameTable) -> list[DriveWarning]:
    """Warnings about a driver's commands: inputs unlike those of its training, and lasting full braking."""
    found: list[DriveWarning] = []
    if unlike_training:
        found.append(("driver", f"{unlike_training}: its commands mean little here"))
    moving = np.isfinite(table.throttle) & (table.speed_mps > MOVING_MPS)
    braking = float(np.mean(table.throttle[moving] <= FULL_BRAKE)) if moving.any() else 0.0
    if braking > MOST_BRAKING_SHARE:
        found.append(("braking", f"the driver brakes fully in {100.0 * braking:.0f} % of the frames of a moving car"))
    return found


def mounting(recording: Recording) -> dict[str, Any]:
    """The estimated angles, deg, with 95 % intervals."""
    return {name: _interval_deg(found) for name, found in recording.mounting_found.items()}


def _interval_deg(found: Angle) -> dict[str, Any]:
    value, half = np.degrees([found.rad, found.half_width_rad])
    ends = {"deg": value, "from_deg": value - half, "to_deg": value + half, "straight_s": found.seconds}
    return {"used": found.is_used, **{key: rounded(float(end)) for key, end in ends.items()}}


def _lens(recording: Recording) -> DriveWarning | None:
    if "lens" not in recording.assumed:
        return None
    narrow, wide = sorted(speed_interval.VIEWS_DEG)
    why = f"60 deg across, assumed; cameras have {narrow:g} to {wide:g} deg"
    return "field of view", f"{why}: distances, speed and angles depend on it; give field_of_view_deg or fx_px"


def _mounting(recording: Recording) -> DriveWarning | None:
    uncertain = {
        name: found
        for name, found in recording.mounting_found.items()
        if not found.is_used or found.half_width_rad > CERTAIN_RAD
    }
    if not uncertain:
        return None
    words = ", ".join(f"{name} {_interval(found)}" for name, found in uncertain.items())
    return "mounting", f"{words}: drive straight for longer, or give pitch_deg and yaw_deg"


def _interval(found: Angle) -> str:
    low, high = np.degrees([found.rad - found.half_width_rad, found.rad + found.half_width_rad])
    return f"{low:.1f} to {high:.1f} deg ({'used' if found.is_used else 'not used, 0 assumed'})"


def _speed(recording: Recording, lane_widths_m: Sequence[float]) -> DriveWarning | None:
    """The interval of a speed by the flow, and whether the lanes have an unusual width."""
    found = speed_interval.of(recording)
    if found is None:
        return None
    (narrow, wide), what = speed_interval.LANE_WIDTHS_M, speed_interval.text(found)
    lanes_m = float(np.median(lane_widths_m)) if len(lane_widths_m) else None
    if lanes_m is not None and not narrow <= lanes_m <= wide:
        what += f"; lanes come out {lanes_m:.1f} m wide"
    return "speed", what


def _share(what: str, found: float | None, then: str) -> DriveWarning | None:
    if found is None or 1.0 - found < MOST_MISSING_SHARE:
        return None
    return what, f"none in {100.0 * (1.0 - found):.0f} % of the frames: then {then}"
