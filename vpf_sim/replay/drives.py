"""The recorded drives of the shared folder, each in its own layout: frames, camera, rate and speed.

What a drive does not say is estimated from its pictures, and named in `assumed`.
"""

import csv
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import readers
from vpf_sim.types import Camera, Image

KITTI_HEIGHT_M = 1.65


@dataclass(frozen=True, slots=True)
class Clip:
    """A recorded drive for looking at: no poses, no truth."""

    name: str
    camera: Camera
    rate_hz: float
    speed_mps: float  # median
    frames: Callable[[], Iterator[Image]]  # (H, W, 3) RGB each, from the first
    assumed: tuple[str, ...] = ()


def read(folder: Path) -> Clip:
    """The drive in a folder, by the folder's name."""
    readers = {
        "kitti_vo_seq1": _kitti_odometry,
        "kitti_raw_leadcar": _kitti_raw,
        "carnd_highway": _carnd,
        "radiate_fog": _radiate,
    }
    if folder.name not in readers:
        raise InputError(f"{folder}: expected one of {', '.join(readers)}")
    if not folder.is_dir():
        raise InputError(f"{folder}: expected the folder of a drive, found nothing")
    return readers[folder.name](folder)


def _kitti_odometry(folder: Path) -> Clip:
    recording = readers.read(folder)
    speed = float(np.median(recording.speed_mps))

    def frames() -> Iterator[Image]:
        return (frame.image for frame in recording.frames() if frame.image is not None)

    return Clip(recording.name, recording.camera, recording.rate_hz, speed, frames, recording.derived)


def _kitti_raw(folder: Path) -> Clip:
    matrix = np.loadtxt(folder / "K.txt")
    files = sorted((folder / "image").glob("*.jpg"))
    height, width = _image(files[0]).shape[:2]
    focal_x, focal_y, centre_x, centre_y = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    camera = Camera(width, height, focal_x, focal_y, centre_x, centre_y, height_m=KITTI_HEIGHT_M)
    times, speeds = _columns(folder / "labels_lidar_odometry.csv", "t_s", "speed_smooth_mps")
    return Clip(folder.name, camera, _rate_hz(times), float(np.median(speeds)), lambda: map(_image, files))


def _radiate(folder: Path) -> Clip:
    text = (folder / "calib.yaml").read_text("utf-8").split("left_cam_calib:")[1].split("_cam_calib:")[0]
    value = {key: float(number) for key, number in re.findall(r"(\w+): (-?[\d.e+-]+)\s*$", text, re.MULTILINE)}
    files = sorted((folder / "image").iterdir())
    height, width = _image(files[0]).shape[:2]
    camera = Camera(
        width,
        height,
        value["fx"],
        value["fy"],
        value["cx"],
        value["cy"],
        height_m=1.6,
        k1=value["k1"],
        k2=value["k2"],
    )
    times, speeds = _columns(folder / "labels.csv", "t_unix", "speed_mps_lidar")
    speed = float(np.median(speeds))
    return Clip(folder.name, camera, _rate_hz(times), speed, lambda: map(_image, files), ("height_m",))


def _carnd(folder: Path) -> Clip:
    """Camera and speed by the marks of a highway of California: lanes of 3.66 m, a dash of 3.05 m every 12.2 m."""
    camera = Camera(960, 540, 860.0, 860.0, 485.0, 269.5, height_m=1.18, pitch_rad=-0.047)
    path = folder / "solidWhiteRight.mp4"

    def frames() -> Iterator[Image]:
        with av.open(str(path)) as video:
            for frame in video.decode(video=0):
                yield frame.to_ndarray(format="rgb24").astype(np.uint8, copy=False)

    return Clip(folder.name, camera, 25.0, 25.3, frames, ("camera", "speed_mps"))


def _image(file: Path) -> Image:
    """(H, W, 3) RGB."""
    decoded = cv2.imread(str(file), cv2.IMREAD_COLOR)
    if decoded is None:
        raise InputError(f"{file}: expected an image, got something that does not decode as one")
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)


def _columns(file: Path, *names: str) -> list[list[float]]:
    """The columns of a table with a header that have these names."""
    with file.open(encoding="utf-8", newline="") as table:
        rows = list(csv.DictReader(table))
    return [[float(row[name]) for row in rows] for name in names]


def _rate_hz(times_s: list[float]) -> float:
    return 1.0 / float(np.median(np.diff(times_s)))
