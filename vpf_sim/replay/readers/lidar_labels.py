"""Reader of an excerpt of KITTI's raw data whose motion was taken from the lidar.

image/, K.txt (3 x 3), velo_to_rectcam_4x4.txt, labels_lidar_odometry.csv (t_s, speed_smooth_mps, yaw_rate_cam_y_rads),
lead_vehicle_lidar.csv (x_rear_median_m, from the lidar). The turn is about the camera's y axis, which points down: +
right.
"""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, image_files, series
from vpf_sim.replay.readers import kitti_raw
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.replay.rectify import Lens, Mounting, mounting_from_rotation
from vpf_sim.types import Floats

LAYOUT = "KITTI raw with lidar odometry"
EXPECTED = "image/, K.txt, labels_lidar_odometry.csv"
LABELS = "labels_lidar_odometry.csv"


def recognises(folder: Path) -> bool:
    return (folder / LABELS).exists() or (folder / "K.txt").exists()


def read(folder: Path) -> Recording:
    if not (folder / "image").is_dir():
        raise InputError(f"{folder}: expected images in image/, found no such folder")
    files, file = image_files.listed(folder / "image"), folder / LABELS
    size = image_files.size(files, folder / "image")
    table = series.table(file, "a row for each frame")
    times = table.times("t_s")
    if len(times) != len(files):
        raise InputError(f"{file}: expected {len(files)} rows for {len(files)} images, got {len(times)}")
    matrix = _matrix(folder / "K.txt", 3)
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    lens = Lens(*size, fx, fy, cx, cy)
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=times - times[0],
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=lens,
        mounting=_mounting(folder / "velo_to_rectcam_4x4.txt"),
        height_m=kitti_raw.HEIGHT_M,
        wheelbase_m=kitti_raw.WHEELBASE_M,
        camera_ahead_m=kitti_raw.CAMERA_AHEAD_M,
    )
    source.origins["camera"] = Origin("recorded", "K.txt, velo_to_rectcam_4x4.txt; 1.65 m high, as on KITTI's car")
    source.origins["times_s"] = Origin("recorded", f"{LABELS} t_s")
    for name, column in (("speed_mps", "speed_smooth_mps"), ("yaw_rate_radps", "yaw_rate_cam_y_rads")):
        source.put(name, table.signal(column, name, source.notes), "lidar odometry", "derived")
    _lead(source, folder)
    return assemble.recording(source)


def _matrix(file: Path, size: int) -> Floats:
    """(size, size) matrix in a text file."""
    rows = series.numbers(file, f"a matrix of {size} x {size}")
    if len(rows) != size or any(len(row) != size for row in rows):
        raise InputError(f"{file}: expected {size} rows of {size} numbers, got {len(rows)} rows")
    return np.array(rows)


def _mounting(file: Path) -> Mounting | None:
    """By the lidar's axes, assumed to be the car's; None without the file."""
    if not file.exists():
        return None
    return mounting_from_rotation(kitti_raw.FORWARD_LEFT_UP @ _matrix(file, 4)[:3, :3].T, kitti_raw.HEIGHT_M)


def _lead(source: assemble.Source, folder: Path) -> None:
    """Store the gap to the lead vehicle, from the camera."""
    file = folder / "lead_vehicle_lidar.csv"
    if not file.exists():
        return
    table = series.table(file, "a row for each frame")
    sampled, gap = table.times("t_s"), table.signal("x_rear_median_m", "lead_gap_m", source.notes)
    offset = folder / "velo_to_rectcam_4x4.txt"
    ahead = _matrix(offset, 4)[2, 3] if offset.exists() else 0.0
    gap = series.at(source.times_s, sampled, gap + ahead)
    source.put("lead_gap_m", gap, "lead_vehicle_lidar.csv, from the camera")
    source.put("obstacle", np.isfinite(gap).astype(float), "lead_vehicle_lidar.csv")
