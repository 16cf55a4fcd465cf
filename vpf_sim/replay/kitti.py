"""Reader of a drive in the layout of KITTI's odometry benchmark: images, calib.txt, poses.txt, times.txt."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import camera_motion
from vpf_sim.replay.recording import Frame, Origin, Recording
from vpf_sim.types import Camera, Floats, Image

# Folders of images that are looked for, and which projection of calib.txt is theirs.
IMAGE_FOLDERS = {"image": 0, "image_0": 0, "image_1": 1, "image_2": 2, "image_3": 3}
LAYOUT = "KITTI odometry"
EXPECTED = "image_0/ (or image_2/, image/), calib.txt, poses.txt, times.txt"
SUFFIXES = (".png", ".jpg", ".jpeg")
RATE_HZ = 10.0  # KITTI's cameras
HEIGHT_M = 1.65  # of KITTI's cameras above the road


def recognises(folder: Path) -> bool:
    """Whether it has a folder of images, a calibration or poses by KITTI's names."""
    return any((folder / name).is_dir() for name in IMAGE_FOLDERS) or (folder / "poses.txt").exists()


def read(folder: Path | str) -> Recording:
    """The drive in `folder`; anything wrong with it is an InputError of one line."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(
            f"{folder}: expected the folder of a drive, found {'a file' if folder.exists() else 'nothing'}"
        )
    files, row = _images(folder)
    camera_to_world = _poses(folder / "poses.txt", len(files))
    times, times_origin = _times(folder / "times.txt", len(files))
    camera = _camera(folder / "calib.txt", row, _decode(files[0]))
    directions = camera_motion.directions(camera_to_world)
    camera = replace(camera, pitch_rad=camera_motion.mounted_pitch(directions))
    # Row k + 1: the motion from k to k + 1 is seen at k + 1. A last image without a pose has no truth.
    foe = np.full((len(files), 2), np.nan)
    foe[1 : len(camera_to_world)] = camera_motion.expansion(camera, directions)
    poses = camera_motion.planar(camera_motion.extended(camera_to_world, len(files)))
    return Recording(
        name=folder.resolve().name,
        layout=LAYOUT,
        camera=camera,
        times_s=times,
        poses=poses,
        speed_mps=_speed(poses, times),
        yaw_rate_radps=np.gradient(poses[:, 2], times),
        foe_px=foe,
        origins={
            "camera": Origin(
                "recorded", "calib.txt; pitch derived from the poses; 1.65 m above the road, of KITTI's car"
            ),
            "times_s": times_origin,
            "poses": Origin("recorded", "poses.txt"),
            "speed_mps": Origin("derived", "from the poses"),
            "yaw_rate_radps": Origin("derived", "from the poses"),
            "foe_px": Origin("derived", "from the poses"),
        },
        frames=lambda: _frames(files, (camera.height_px, camera.width_px)),
    )


def _images(folder: Path) -> tuple[list[Path], int]:
    """The drive's images in their order, and which projection is theirs."""
    for name, row in IMAGE_FOLDERS.items():
        if not (folder / name).is_dir():
            continue
        files = sorted(path for path in (folder / name).iterdir() if path.suffix.lower() in SUFFIXES)
        if len(files) == 1:
            raise InputError(f"{folder / name}: expected two images or more, found 1")
        if files:
            return files, row
    places = ", ".join(f"{name}/" for name in IMAGE_FOLDERS)
    raise InputError(f"{folder}: expected .png or .jpg images in one of {places}; found none")


def _decode(file: Path) -> Image:
    """(H, W, 3) RGB."""
    decoded = (
        cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR) if file.stat().st_size else None
    )
    if decoded is None:
        raise InputError(f"{file}: expected an image, got {file.stat().st_size} bytes that do not decode as one")
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)


def _frames(files: list[Path], size: tuple[int, int]) -> Iterator[Frame]:
    for index, file in enumerate(files):
        frame = _decode(file)
        if frame.shape[:2] != size:
            expected, actual = (f"{width} x {height}" for height, width in (size, frame.shape[:2]))
            raise InputError(f"{file}: expected an image of {expected} px like the first, got {actual}")
        yield Frame(index, frame)


def _numbers(file: Path, what: str) -> list[list[float]]:
    """The rows of numbers of a text file; a leading key such as "P0:" is left out, empty lines are skipped."""
    try:
        lines = file.read_text("utf-8").splitlines()
    except FileNotFoundError:
        raise InputError(f"{file}: expected {what}, found no file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: expected {what}, cannot be read: {error}") from None
    rows = []
    for number, line in enumerate(lines, 1):
        words = line.split(":", 1)[-1].split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            raise InputError(f"{file}: line {number}: expected numbers, got '{line.strip()[:40]}'") from None
        if not np.all(np.isfinite(values)):
            raise InputError(f"{file}: line {number}: expected finite numbers, got '{line.strip()[:40]}'")
        if values:
            rows.append(values)
    return rows


def _camera(file: Path, row: int, frame: Image) -> Camera:
    """The pinhole of projection P<row>, 12 numbers; the first one where there are fewer."""
    projections = [values for values in _numbers(file, "projections of 12 numbers, P0: first") if len(values) == 12]
    if not projections:
        raise InputError(f"{file}: expected a row of 12 numbers (P0: of KITTI), found none")
    matrix = np.reshape(projections[row if row < len(projections) else 0], (3, 4))
    if matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
        raise InputError(f"{file}: expected focal lengths > 0, got {matrix[0, 0]:g} and {matrix[1, 1]:g}")
    focal_x, focal_y, centre_x, centre_y = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    height, width = frame.shape[:2]
    return Camera(width, height, focal_x, focal_y, centre_x, centre_y, height_m=HEIGHT_M, forward_m=0.0)


def _poses(file: Path, images: int) -> Floats:
    """(M, 3, 4) camera to world, one a image; the last image may lack its own."""
    rows = _numbers(file, "a pose of 12 numbers for each image")
    for number, values in enumerate(rows, 1):
        if len(values) != 12:
            raise InputError(f"{file}: row {number}: expected 12 numbers, got {len(values)}")
    if len(rows) not in (images, images - 1) or len(rows) < 2:
        raise InputError(f"{file}: expected {images} rows for {images} images (or {images - 1}), got {len(rows)}")
    poses = np.reshape(rows, (-1, 3, 4))
    turned = poses[:, :, :3]
    if np.abs(turned @ turned.transpose(0, 2, 1) - np.eye(3)).max() > 1e-2 or np.linalg.det(turned).min() < 0.0:
        raise InputError(f"{file}: expected camera-to-world rotations in the first three columns, got other matrices")
    return poses


def _times(file: Path, images: int) -> tuple[Floats, Origin]:
    """(N,) s."""
    if not file.exists():
        return np.arange(images) / RATE_HZ, Origin("assumed", f"{RATE_HZ:g} Hz, of KITTI's cameras")
    rows = _numbers(file, "the time of each image")
    times = np.array([values[0] for values in rows])
    if len(times) != images:
        raise InputError(f"{file}: expected {images} rows for {images} images, got {len(times)}")
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        i = int(late[0])
        raise InputError(f"{file}: row {i + 2}: expected a time after {times[i]:g} s, got {times[i + 1]:g} s")
    return times, Origin("recorded", "times.txt")


def _speed(poses: Floats, times_s: Floats) -> Floats:
    velocity = np.gradient(poses[:, :2], times_s, axis=0)
    return np.asarray(np.hypot(velocity[:, 0], velocity[:, 1]))
