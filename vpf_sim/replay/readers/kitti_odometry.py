"""Reader of a sequence of KITTI's odometry benchmark (Geiger, Lenz and Urtasun, CVPR 2012; readme of its kit).

sequences/<n>/: image_0 (grey) or image_2 (colour), calib.txt, times.txt; poses/<n>.txt, or poses.txt beside the images.
Poses are camera to world, x right, y down, z forward; `paths` converts them to our axes. Images are rectified.
"""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, image_files, paths, plausible, series
from vpf_sim.replay.plausible import Location
from vpf_sim.replay.readers.kitti_raw import CAMERA_AHEAD_M, HEIGHT_M, WHEELBASE_M
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.replay.rectify import Lens, Mounting
from vpf_sim.types import Floats

LAYOUT = "KITTI odometry"
EXPECTED = "image_0/ (or image_2/, image/), calib.txt, poses.txt (or ../../poses/<n>.txt), times.txt"
# Folders of images, and the row of their projection in calib.txt.
IMAGE_FOLDERS = {"image": 0, "image_0": 0, "image_1": 1, "image_2": 2, "image_3": 3}
RATE_HZ = 10.0  # of the cameras


def recognises(folder: Path) -> bool:
    return any((folder / name).is_dir() for name in IMAGE_FOLDERS) or (folder / "poses.txt").exists()


def read(folder: Path) -> Recording:
    """The sequence; steering, throttle and brake are derived."""
    files, row = _images(folder)
    size = image_files.size(files, files[0].parent)
    lens = _lens(folder / "calib.txt", row, size)
    poses_file = _poses_file(folder)
    camera_to_world = _poses(poses_file, len(files))
    times, times_origin = _times(folder / "times.txt", files)
    directions = paths.directions(camera_to_world)
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=times,
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=lens,
        mounting=Mounting(paths.mounted_pitch(directions), height_m=HEIGHT_M),
        wheelbase_m=WHEELBASE_M,
        camera_ahead_m=CAMERA_AHEAD_M,
        directions_m=directions,
    )
    source.origins["camera"] = Origin(
        "recorded", "calib.txt; pitch by the poses; 1.65 m above the road, as on KITTI's car"
    )
    source.origins["times_s"] = times_origin
    source.put("poses", paths.planar(paths.extended(camera_to_world, len(files))), poses_file.name)
    if len(camera_to_world) < len(files):
        source.notes.append(f"{poses_file.name}: the last image has no pose: the motion continues")
    return assemble.recording(source)


def _images(folder: Path) -> tuple[list[Path], int]:
    """Images of the drive in order, and the row of their projection."""
    for name, row in IMAGE_FOLDERS.items():
        if (folder / name).is_dir() and (files := image_files.listed(folder / name)):
            return files, row
    places = ", ".join(f"{name}/" for name in IMAGE_FOLDERS)
    raise InputError(f"{folder}: expected .png or .jpg images in one of {places}; found none")


def _lens(file: Path, row: int, size: tuple[int, int]) -> Lens:
    """The pinhole of projection P<row>, or the first one if there are fewer."""
    wanted = "projections of 12 numbers, P0: first"
    projections = [values for values in series.numbers(file, wanted) if len(values) == 12]
    if not projections:
        raise InputError(f"{file}: expected a row of 12 numbers (P0: of KITTI), found none")
    matrix = np.reshape(projections[row if row < len(projections) else 0], (3, 4))
    if matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
        raise InputError(f"{file}: expected focal lengths > 0, got {matrix[0, 0]:g} and {matrix[1, 1]:g}")
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return Lens(*size, fx, fy, cx, cy)


def _poses_file(folder: Path) -> Path:
    """poses.txt beside the images, or where the benchmark has it."""
    own, shared = folder / "poses.txt", folder.resolve().parents[1] / "poses" / f"{folder.resolve().name}.txt"
    return shared if shared.exists() and not own.exists() else own


def _poses(file: Path, images: int) -> Floats:
    """(M, 3, 4) camera to world, one for each image; the last one may be missing."""
    rows = series.numbers(file, "a pose of 12 numbers for each image")
    for number, values in enumerate(rows, 1):
        if len(values) != 12:
            raise InputError(f"{file}: row {number}: expected 12 numbers, got {len(values)}")
    if len(rows) not in (images, images - 1) or len(rows) < 2:
        raise InputError(f"{file}: expected {images} rows for {images} images (or {images - 1}), got {len(rows)}")
    poses = np.reshape(rows, (-1, 3, 4))
    if np.abs(poses[:, :, 3]).max() > plausible.LIMITS["x_m"].highest:
        raise InputError(f"{file}: expected positions up to {plausible.LIMITS['x_m'].highest:g} m, got larger ones")
    turned = np.clip(poses[:, :, :3], -2.0, 2.0)
    if np.abs(turned @ turned.transpose(0, 2, 1) - np.eye(3)).max() > 1e-2 or np.linalg.det(turned).min() < 0.0:
        raise InputError(f"{file}: expected camera-to-world rotations in the first three columns, got other matrices")
    return poses


def _times(file: Path, files: list[Path]) -> tuple[Floats, Origin]:
    """(N,) s."""
    images = len(files)
    if not file.exists():
        return image_files.steps(files) / RATE_HZ, Origin("assumed", f"{RATE_HZ:g} Hz, of KITTI's cameras")
    times = np.array([values[0] for values in series.numbers(file, "the time of each image")])
    if len(times) != images:
        raise InputError(f"{file}: expected {images} rows for {images} images, got {len(times)}")
    return series.ascending(Location(str(file), "time", range(1, images + 1), "line"), times), Origin(
        "recorded", "times.txt"
    )
