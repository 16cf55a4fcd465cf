"""Recordings that we rendered ourselves: a camera on a known path along a road of ours, so that all truth is known."""

import csv
from collections.abc import Iterator
from functools import cache
from pathlib import Path as File
from typing import Any

import cv2
import numpy as np

from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.gallery.poses import Path, ScriptedDrive
from vpf_sim.geometry import unwrapped
from vpf_sim.replay.recording import Frame, Origin, Recording
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Camera, Floats, Image, VehicleModel

RATE_HZ, SPEED_MPS, START_M, FRAMES = 15.0, 8.0, 20.0, 36
RECORDED = ("camera", "times_s", "poses", "speed_mps", "yaw_rate_radps", "steering_rad", "throttle")
CAMERA = Camera(forward_m=0.0, height_m=1.4)
WHEELBASE_M = VehicleModel().wheelbase_m


def scenario(radius_m: float, bodies: tuple[dict[str, Any], ...] = ()) -> Scenario:
    """Four lanes in a bend, + right, or straight where the radius is infinite."""
    arc = {"kind": "arc", "length_m": 120.0, "radius_m": radius_m}
    line = {"kind": "line", "length_m": 120.0}
    return Scenario.model_validate(
        {
            "schema": 1,
            "road": {"lanes": 4, "lane_width_m": 3.5, "segments": [arc if np.isfinite(radius_m) else line]},
            "goal": {"s_m": 110.0},
            "bodies": list(bodies),
        }
    )


@cache
def shots(
    radius_m: float, lane: int, right_m: float, body_s_m: float | None, frames: int
) -> tuple[tuple[Image, ...], Floats]:
    """The pictures of a drive `right_m` right of the middle of a lane, and its poses (N, 3)."""
    bodies = () if body_s_m is None else ({"kind": "car", "s_m": body_s_m, "lane": lane},)
    road = scenario(radius_m, bodies)
    offset = road.road.lane_offset_m(lane) + right_m
    drive = ScriptedDrive(road, Path(START_M, SPEED_MPS, lambda _: offset), Rig(CAMERA), RATE_HZ)
    taken = list(drive.shots(weathers.load("clear"), 1, frames))
    return tuple(shot.image for shot in taken), np.array([shot.pose for shot in taken])


def recording(
    radius_m: float,
    lane: int = 2,
    right_m: float = 0.0,
    body_s_m: float | None = None,
    frames: int = FRAMES,
    **changes: Any,
) -> Recording:
    """All of it recorded, as a car drove that knows its steering."""
    images, poses = shots(radius_m, lane, right_m, body_s_m, frames)
    steps_m = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    rate = np.gradient(unwrapped(poses[:, 2]), 1.0 / RATE_HZ)
    speed = np.full(frames, steps_m.mean() * RATE_HZ)

    def pictures() -> Iterator[Frame]:
        return (Frame(k, image) for k, image in enumerate(images))

    values: dict[str, Any] = {
        "name": "rendered",
        "layout": "rendered",
        "camera": CAMERA,
        "times_s": np.arange(frames) / RATE_HZ,
        "poses": poses,
        "speed_mps": speed,
        "yaw_rate_radps": rate,
        "frames": pictures,
        "origins": dict.fromkeys(RECORDED, Origin("recorded", "rendered")),
        "foe_px": np.full((frames, 2), [CAMERA.cx_px, CAMERA.cy_px]),  # half way between, an arc leads straight ahead
        "steering_rad": np.arctan(WHEELBASE_M * rate / speed),
        "throttle": np.zeros(frames),
        "weather": "cloudy",
    }
    return Recording(**{**values, **changes})


DRIVE_TOML = """\
schema = 1
weather = "light rain"
[camera]
fx_px = 320.0
height_m = 1.4
pitch_deg = 0.0
yaw_deg = 0.0
ahead_of_rear_axle_m = 0.0
[vehicle]
steering_ratio = 15.0
"""


def write(folder: File, radius_m: float) -> None:
    """The drive as anyone's recording: pictures, drive.toml, and a table with the steering wheel's angle."""
    known = recording(radius_m)
    (folder / "images").mkdir(parents=True)
    (folder / "drive.toml").write_text(DRIVE_TOML)
    images, _ = shots(radius_m, 2, 0.0, None, FRAMES)
    with (folder / "signals.csv").open("w", newline="") as table:
        rows = csv.writer(table)
        rows.writerow(("file", "time_s", "speed_mps", "yaw_rate_radps", "steering_wheel_deg", "acceleration_mps2"))
        for k, image in enumerate(images):
            cv2.imwrite(str(folder / "images" / f"{k:03d}.jpg"), image[..., ::-1])
            wheel = 15.0 * np.degrees(known.steering_rad[k])
            rows.writerow((f"{k:03d}.jpg", known.times_s[k], known.speed_mps[k], known.yaw_rate_radps[k], wheel, 0.3))
