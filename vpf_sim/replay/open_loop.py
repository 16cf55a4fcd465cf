"""A driver on a recorded drive: it sees the frames and says what it would do, and nobody does it."""

import csv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.perception.flow import grey
from vpf_sim.planning import variant
from vpf_sim.replay.own_derotation import OwnDerotation
from vpf_sim.replay.recording import Recording
from vpf_sim.report import overlay
from vpf_sim.report.video import Writer
from vpf_sim.types import Command, Driver, DriverSetup, Expansion, Floats, Image, Observation, Plan, VehicleModel

OWN_VARIANT = "robust"  # whose flow serves where a driver has none of its own
BEYOND_M = 40.0  # of route behind the last pose
COLUMNS = ("frame", "time_s", "speed_mps", "throttle", "steering", "foe_x_px", "foe_y_px", "foe_confidence")

Progress = Callable[[int, int], None]


@dataclass(slots=True)
class Errors:
    """Errors of the focus of expansion, frame by frame."""

    rows: list[Floats] = field(default_factory=list)

    def add(self, seen: Expansion, truth_px: Floats) -> None:
        if seen.confidence > 0.0 and np.all(np.isfinite(truth_px)):
            self.rows.append(np.array([seen.x_px, seen.y_px]) - truth_px)

    def median(self) -> dict[str, float] | None:
        """Of the absolute errors, px; None without a frame that has both."""
        if not self.rows:
            return None
        x, y = np.median(np.abs(self.rows), axis=0)
        return {"x": round(float(x), 3), "y": round(float(y), 3)}


def run(recording: Recording, driver_name: str, out: Path, progress: Progress = lambda *_: None) -> dict[str, Any]:
    """Drive along, write `<name>.mp4` and `<name>.csv` into `out`, and give the drive's entry of the answer."""
    driver = drivers.create(driver_name)
    driver.reset(_setup(recording, driver))
    own = OwnDerotation(recording.camera, variant.load(OWN_VARIANT), recording.rate_hz)
    recorded_errors, own_errors = Errors(), Errors()
    camera = recording.camera
    with (
        _draft(out / f"{recording.name}.csv") as csv_path,
        _draft(out / f"{recording.name}.mp4") as video_path,
        csv_path.open("w", newline="") as table,
        Writer(video_path, (camera.width_px, camera.height_px), recording.rate_hz) as video,
    ):
        rows = csv.writer(table)
        rows.writerow(COLUMNS)
        for k, frame in ((frame.index, frame.image) for frame in recording.frames() if frame.image is not None):
            command = drivers.command_of(driver, _observation(recording, k, frame))
            plan = drivers.trace_of(driver)
            if plan is not None:
                recorded_errors.add(plan.perception.expansion, recording.foe_px[k])
            own_errors.add(own.update(grey(frame), _step_m(recording, k)), recording.foe_px[k])
            rows.writerow(_row(recording, k, command, plan))
            video.write(frame if plan is None else overlay.draw(frame, plan, camera))
            progress(k + 1, len(recording))
    return {
        "name": recording.name,
        "frames": len(recording),
        "foe_median_error_px": recorded_errors.median(),
        "foe_median_error_own_derotation_px": own_errors.median(),
        "accuracy": None,  # KITTI's layout records no throttle and no steering
        "derived": list(recording.derived),
    }


@contextmanager
def _draft(path: Path) -> Iterator[Path]:
    """Another name to write under: at the end the file gets its own, or is removed if anything went wrong."""
    draft = path.with_name(f"{path.stem}.draft{path.suffix}")
    try:
        yield draft
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _setup(recording: Recording, driver: Driver) -> DriverSetup:
    """The goal is the last pose, the speed to keep that of the start, as in the paper."""
    if driver.privileged == "world":
        raise InputError(f"{recording.name}: the driver asks for the world, a recording has none")
    return DriverSetup(
        camera=recording.camera,
        vehicle=VehicleModel(),
        rate_hz=recording.rate_hz,
        speed_reference_mps=float(recording.speed_mps[0]),
        goal_m=(float(recording.poses[-1, 0]), float(recording.poses[-1, 1])),
        seed=0,
        route=_route(recording.poses) if driver.privileged == "route" else None,
    )


def _route(poses: Floats) -> Floats:
    """(M, 2) m, 1 m apart, along the way that was driven and straight on."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + BEYOND_M * np.array([np.cos(heading), np.sin(heading)])
    points = np.vstack([poses[:, :2], beyond])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    stations = np.arange(0.0, along[-1], 1.0)
    return np.stack([np.interp(stations, along, points[:, i]) for i in range(2)], axis=1)


def _observation(recording: Recording, k: int, frame: Image) -> Observation:
    x, y, yaw = (float(value) for value in recording.poses[k])
    return Observation(
        image=frame,
        time_s=float(recording.times_s[k]),
        x_m=x,
        y_m=y,
        yaw_rad=yaw,
        speed_mps=float(recording.speed_mps[k]),
        yaw_rate_radps=float(recording.yaw_rate_radps[k]),
        goal_m=(float(recording.poses[-1, 0]), float(recording.poses[-1, 1])),
    )


def _step_m(recording: Recording, k: int) -> float:
    return 0.0 if k == 0 else float(np.hypot(*(recording.poses[k, :2] - recording.poses[k - 1, :2])))


def _row(recording: Recording, k: int, command: Command, plan: Plan | None) -> list[Any]:
    foe: tuple[Any, ...] = ("", "", "")
    if plan is not None:
        seen = plan.perception.expansion
        foe = (f"{seen.x_px:.2f}", f"{seen.y_px:.2f}", f"{seen.confidence:.3f}")
    motion = (f"{recording.times_s[k]:.3f}", f"{recording.speed_mps[k]:.3f}")
    return [k, *motion, f"{command.throttle:.4f}", f"{command.steering:.4f}", *foe]
