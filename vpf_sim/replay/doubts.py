"""What a reader of a replay should doubt: a line for each thing, with its size."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vpf_sim.replay.glass_points import Rider, RidingPoints
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.scores import rounded

SURE_RAD = 0.009  # half of the interval of an angle that nobody need doubt: half a degree
OFTEN = 0.05  # share of frames without flow or lane from which on it is told
LANES, NO_LANES = (3.0, 4.0), (1.0, 2.2)  # m: widths that lanes have, heights at which people mount cameras
ASSUMED_HEIGHT = "m above the road assumed"  # as the camera's origin says it
BY_LANES = "above the road by its lanes"
ASSUMED_LENS = "field of view"

Doubt = tuple[str, str]  # what, and why

RIDERS: dict[Rider, Doubt] = {
    "bonnet": ("bonnet", "it covers the lower edge of the picture and may mirror the scene: point the camera higher"),
    "overlay": ("overlay", "something that never moves stays in the picture: a text, a logo, or a mark on the glass"),
    "glass": ("reflections", "points stay in place while the car moves: water, dirt or a mirror image on the glass"),
}


def lines(
    recording: Recording, record: dict[str, Any], riding: RidingPoints, lane_widths_m: Sequence[float]
) -> list[Doubt]:
    """All of a drive, by its record, what rides along with the camera, and the lanes that were found."""
    found = [_lens(recording), _mounting(recording), _speed(recording, lane_widths_m)]
    found += [_share("flow", record["perception"]["foe"]["share"], "the last prediction holds")]
    found += [_share("lane", record["perception"]["road_found_share"], "course and speed are kept, unscored")]
    found += [RIDERS[name] for name in riding.found()]
    return [doubt for doubt in found if doubt is not None]


def mounting(recording: Recording) -> dict[str, Any]:
    """The angles found on the way, deg, with their intervals at 95 %."""
    return {name: _told(found) for name, found in recording.mounting_found.items()}


def _told(found: Angle) -> dict[str, Any]:
    value, half = np.degrees([found.rad, found.half_width_rad])
    ends = {"deg": value, "from_deg": value - half, "to_deg": value + half, "straight_s": found.seconds}
    return {"used": found.is_used, **{key: rounded(float(end)) for key, end in ends.items()}}


def _lens(recording: Recording) -> Doubt | None:
    if ASSUMED_LENS not in recording.origins["camera"].how:
        return None
    return "field of view", "60 deg across, assumed: distances, speed and angles are wrong with it; give fx_px"


def _mounting(recording: Recording) -> Doubt | None:
    doubtful = {
        name: found
        for name, found in recording.mounting_found.items()
        if not found.is_used or found.half_width_rad > SURE_RAD
    }
    if not doubtful:
        return None
    words = ", ".join(f"{name} {_interval(found)}" for name, found in doubtful.items())
    return "mounting", f"{words}: drive straight for longer, or give pitch_deg and yaw_deg"


def _interval(found: Angle) -> str:
    low, high = np.degrees([found.rad - found.half_width_rad, found.rad + found.half_width_rad])
    return f"{low:.1f} to {high:.1f} deg ({'used' if found.is_used else 'not used, 0 taken'})"


def _speed(recording: Recording, lane_widths_m: Sequence[float]) -> Doubt | None:
    """By the flow it is as exact as the camera's height, which the width of the lanes must bear out."""
    speed, camera = recording.origins["speed_mps"], recording.origins["camera"]
    if "flow" not in speed.how:
        return None
    height, width = recording.camera.height_m, 3.5
    if BY_LANES in camera.how:
        why, scale = "lanes are 3 to 4 m wide", np.array(LANES) / width
    elif ASSUMED_HEIGHT in camera.how:
        why, scale = f"the camera may hang {NO_LANES[0]:g} to {NO_LANES[1]:g} m high", np.array(NO_LANES) / height
    else:
        return "speed", "from the road's flow, as exact as the camera's height and focal length"
    lanes_m = float(np.median(lane_widths_m)) if len(lane_widths_m) else width
    if not LANES[0] <= lanes_m <= LANES[1]:
        why += f", and lanes come out {lanes_m:.1f} m wide"
    times = f"{scale[0]:.2f} to {scale[1]:.2f} times as told"
    return "speed", f"from the road's flow, {times}, for {why}: give height_m, or a table with the speed"


def _share(what: str, found: float | None, then: str) -> Doubt | None:
    if found is None or 1.0 - found < OFTEN:
        return None
    return what, f"none in {100.0 * (1.0 - found):.0f} % of the frames: there {then}"
