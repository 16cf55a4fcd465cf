"""Reader of a drive of KITTI's raw data (Geiger et al., Int. J. Robot. Res. 32, 2013; readme of its development kit).

<date>/<date>_drive_<n>_sync/: image_02/data/*.png, image_02/timestamps.txt, oxts/data/*.txt, oxts/timestamps.txt,
tracklet_labels.xml; the calibration in <date>/. The unit of GPS and inertial sensors has forward, left, up: its turn
about up and its heading are + left, counter-clockwise. `_extract` drives are not rectified: their lens is taken out.
"""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from datetime import datetime
from math import prod
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, derived, image_files, paths, series
from vpf_sim.replay.plausible import Location
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.replay.rectify import Lens, mounting_from_rotation
from vpf_sim.types import Floats

LAYOUT = "KITTI raw"
EXPECTED = "image_02/data/, oxts/data/, and calib_cam_to_cam.txt there or one folder up"
# Shapes of the calibration's rows, by key without the camera's number.
SHAPES = {"S": (2,), "K": (3, 3), "D": (5,), "S_rect": (2,), "R_rect": (3, 3), "P_rect": (3, 4), "R": (3, 3), "T": (3,)}
CAMERAS = ("image_02", "image_00", "image_03", "image_01")
HEIGHT_M = 1.65  # of the cameras above the road
WHEELBASE_M = 2.71  # Volkswagen Passat B6
CAMERA_AHEAD_M = 1.68  # of the rear axle
FORWARD_LEFT_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # to right, down, forward
ACROSS_M, REACH_M = 1.8, 40.0  # corridor in which an object is in the way
FIELDS = 30
RECEPTION = 5  # last fields, about reception; some drives lack them
ATTITUDE = [3, 4, 5]
LATITUDE, LONGITUDE, ALTITUDE, ROLL, PITCH, YAW, FORWARD_MPS, FORWARD_MPS2, UP_RADPS = 0, 1, 2, 3, 4, 5, 8, 14, 22


def recognises(folder: Path) -> bool:
    return (folder / "oxts").is_dir() or any((folder / name / "data").is_dir() for name in CAMERAS)


def read(folder: Path) -> Recording:
    """A `_sync` or `_extract` drive; the calibration lies in it or one folder up."""
    camera = next((name for name in CAMERAS if (folder / name / "data").is_dir()), None)
    if camera is None:
        raise InputError(f"{folder}: expected images in one of {', '.join(f'{name}/data/' for name in CAMERAS)}")
    files = image_files.listed(folder / camera / "data")
    size = image_files.size(files, folder / camera / "data")
    clock_s = _stamps(folder / camera / "timestamps.txt", len(files))
    lens, rectify_turn = _lens(folder, camera[-2:], size)
    camera_pose = _camera_pose(folder, rectify_turn)
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=clock_s - clock_s[0],
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=lens,
        mounting=None
        if camera_pose is None
        else mounting_from_rotation(FORWARD_LEFT_UP @ camera_pose.unit_to_camera.T, HEIGHT_M),
        height_m=HEIGHT_M,
        wheelbase_m=WHEELBASE_M,
        camera_ahead_m=CAMERA_AHEAD_M,
    )
    source.origins["camera"] = Origin("recorded", "calib_cam_to_cam.txt; 1.65 m above the road, as on KITTI's car")
    source.origins["times_s"] = Origin("recorded", f"{camera}/timestamps.txt")
    _motion(source, folder / "oxts", clock_s, camera_pose)
    _labels(source, folder / "tracklet_labels.xml")
    return assemble.recording(source)


def _stamps(file: Path, count: int) -> Floats:
    """(N,) s since 1970, UTC, from times in nanoseconds."""
    rows = [line for line in series.lines(file, "the time of each frame") if line.strip()]
    if len(rows) != count:
        raise InputError(f"{file}: expected {count} rows for {count} files, got {len(rows)}")
    times = []
    for number, row in enumerate(rows, 1):
        try:
            whole, _, fraction = row.strip().partition(".")
            times.append(datetime.fromisoformat(f"{whole}+00:00").timestamp() + float(f"0.{fraction or 0}"))
        except ValueError:
            raise InputError(
                f"{file}: line {number}: expected a time like 2011-09-26 13:02:25.594360375, got {row[:40]!r}"
            ) from None
    return series.ascending(Location(str(file), "time", range(1, count + 1), "line"), np.array(times))


def _calibration(folder: Path, name: str) -> dict[str, Floats] | None:
    """The arrays of a calibration file by key; None without such a file."""
    file = next((place / name for place in (folder, folder.resolve().parent) if (place / name).exists()), None)
    if file is None:
        return None
    found = {}
    for line in series.lines(file, "KITTI's calibration"):
        key, _, values = line.partition(":")
        try:
            numbers = np.array([float(word) for word in values.split()])
        except ValueError:
            continue  # the date of the calibration
        shape = SHAPES.get(key.strip().rstrip("_0123456789"))
        if shape is not None and (numbers.size != prod(shape) or not np.isfinite(numbers).all()):
            raise InputError(
                f"{file}: {key.strip()}: expected {prod(shape)} finite numbers, got {values.strip()[:40]!r}"
            )
        found[key.strip()] = numbers if shape is None else numbers.reshape(shape)
    for key, matrix in found.items():
        turn = np.clip(matrix, -2.0, 2.0)
        if key.startswith("R") and turn.shape == (3, 3) and np.abs(turn @ turn.T - np.eye(3)).max() > 1e-2:
            raise InputError(f"{file}: {key}: expected a rotation, got another matrix")
    return found


def _lens(folder: Path, number: str, size: tuple[int, int]) -> tuple[Lens, Floats]:
    """The lens for images of this size, and (3, 3) the rotation by rectification."""
    values = _calibration(folder, "calib_cam_to_cam.txt")
    if values is None:
        raise InputError(f"{folder}: expected calib_cam_to_cam.txt in it or one folder up, found none")
    keys = [f"{name}_{number}" for name in ("S", "K", "D", "S_rect", "P_rect")]
    missing = [key for key in [*keys, f"R_rect_{number}", "R_rect_00"] if key not in values]
    if missing:
        raise InputError(f"{folder}: calib_cam_to_cam.txt: expected {', '.join(missing)}, found no such row")
    raw, matrix, distortion, rectified, projection = (values[key] for key in keys)
    if size == tuple(rectified.astype(int)):
        return _pinhole(size, projection), values["R_rect_00"]
    if size == tuple(raw.astype(int)):
        return _pinhole(size, matrix, tuple(distortion)), np.eye(3)
    expected = " or ".join(f"{part[0]:.0f} x {part[1]:.0f}" for part in (rectified, raw))
    raise InputError(f"{folder}: expected images of {expected} px by calib_cam_to_cam.txt, got {size[0]} x {size[1]}")


def _pinhole(size: tuple[int, int], matrix: Floats, distortion: tuple[float, ...] = ()) -> Lens:
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return Lens(*size, fx, fy, cx, cy, tuple(float(value) for value in distortion))


@dataclass(frozen=True, slots=True)
class _CameraPose:
    """Pose of the camera on the unit: rotation (3, 3) to its axes, position (3,) m forward, left, up."""

    unit_to_camera: Floats
    position_m: Floats


def _camera_pose(folder: Path, rectify_turn: Floats) -> _CameraPose | None:
    """By the chain unit to lidar to camera; None where a link is missing."""
    lidar, unit = (_calibration(folder, f"calib_{name}.txt") for name in ("velo_to_cam", "imu_to_velo"))
    if lidar is None or unit is None or not {"R", "T"} <= lidar.keys() & unit.keys():
        return None
    lidar_to_camera, unit_to_lidar = lidar["R"], unit["R"]
    position_m = -unit_to_lidar.T @ (lidar_to_camera.T @ lidar["T"] + unit["T"])
    return _CameraPose(rectify_turn @ lidar_to_camera @ unit_to_lidar, position_m)


def _motion(source: assemble.Source, folder: Path, clock_s: Floats, camera_pose: _CameraPose | None) -> None:
    """Store speed, yaw rate, acceleration and poses of the GPS and inertial unit.

    An `_extract` drive has ten times as many records as images.
    """
    if not folder.is_dir():
        source.notes.append("no oxts/: no motion was recorded")
        return
    rows = _records(folder)
    sampled = _stamps(folder / "timestamps.txt", len(rows))
    speed = source.checked("speed_mps", rows[:, FORWARD_MPS], "oxts vf")
    rate = source.checked("yaw_rate_radps", -rows[:, UP_RADPS], "oxts wu")
    acceleration = source.checked("acceleration_mps2", rows[:, FORWARD_MPS2], "oxts af")
    source.put("speed_mps", series.at(clock_s, sampled, speed), "oxts vf")
    source.put("yaw_rate_radps", series.at(clock_s, sampled, rate), "oxts wu, sign inverted")
    if np.isfinite(acceleration).any():
        source.acceleration_mps2 = series.filled(clock_s, series.at(clock_s, sampled, acceleration))[0]
    rows[:, ATTITUDE] = np.stack([source.checked("yaw_rad", rows[:, k], "oxts") for k in ATTITUDE], axis=1)
    rows[:, ALTITUDE] = source.checked("altitude_m", rows[:, ALTITUDE], "oxts alt")
    flat = _fixes(rows, sampled, folder, source.notes)
    path = _path(rows, flat, np.zeros(3) if camera_pose is None else camera_pose.position_m)
    source.put("poses", derived.poses_at(clock_s, sampled, path), "oxts lat, lon, yaw")
    if camera_pose is not None and len(rows) == len(clock_s):  # one record for each image
        poses = _camera_to_world(rows, flat, camera_pose.position_m, camera_pose.unit_to_camera)
        source.directions_m = paths.directions(poses)


def _labels(source: assemble.Source, file: Path) -> None:
    """Store which frames are blocked by a labelled object, and the gap; lidar axes, left is +."""
    if not file.exists():
        return
    count = len(source.times_s)
    gap = np.full(count, np.inf)
    try:
        root = ElementTree.parse(file).getroot()
        for item in root.iterfind("./tracklets/item"):
            length, first = float(item.findtext("l", "0")), int(item.findtext("first_frame", "0"))
            for step, pose in enumerate(item.iterfind("./poses/item")):
                ahead, left = (float(pose.findtext(key, "nan")) for key in ("tx", "ty"))
                if 0 <= first + step < count and 0.0 < ahead < REACH_M and abs(left) < ACROSS_M:
                    gap[first + step] = min(gap[first + step], ahead - 0.5 * length)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{file}: expected KITTI's tracklets, cannot be read: {error}") from None
    where = f"tracklet_labels.xml, within {ACROSS_M:g} m of straight ahead and {REACH_M:g} m"
    source.put("obstacle", np.isfinite(gap).astype(float), where)
    source.put("lead_gap_m", np.where(np.isfinite(gap), gap, np.nan), where)


def _records(folder: Path) -> Floats:
    """(M, 25) the records of oxts/data/ in their order."""
    files = sorted((folder / "data").glob("*.txt"))
    if not files:
        raise InputError(f"{folder}: expected records in data/*.txt, found none")
    return np.array([_row(file) for file in files])


def _row(file: Path) -> list[float]:
    try:
        values = [float(word) for word in series.lines(file, "a line of oxts")[0].split()]
    except (ValueError, IndexError):
        raise InputError(f"{file}: expected a line of {FIELDS} numbers, got other text") from None
    if len(values) < FIELDS - RECEPTION:
        raise InputError(f"{file}: expected {FIELDS} numbers, got {len(values)}")
    return values[: FIELDS - RECEPTION]


def _fixes(rows: Floats, times_s: Floats, folder: Path, notes: list[str]) -> Floats:
    """(M, 2) m north and east of the first fix; nan without a fix."""
    return paths.fixes(times_s, rows[:, LATITUDE], rows[:, LONGITUDE], Location(str(folder), "lat, lon"), notes)


def _path(rows: Floats, flat: Floats, place: Floats) -> Floats:
    """(M, 3) poses of a position (3,) on the unit, which is at `flat` (M, 2)."""
    result = paths.poses(flat, 0.5 * np.pi - rows[:, YAW])
    cosine, sine, ahead, right = np.cos(result[:, 2]), np.sin(result[:, 2]), place[0], -place[1]
    result[:, 0] += cosine * ahead - sine * right
    result[:, 1] += sine * ahead + cosine * right
    return result


def _camera_to_world(rows: Floats, flat: Floats, place: Floats, unit_to_camera: Floats) -> Floats:
    """(M, 3, 4) camera poses in a world of east, north, up; the camera is at `place` (3,) on the unit.

    The unit's attitude is yaw about up, then pitch about left, then roll about forward, as in the kit.
    """
    unit = _about(2, rows[:, YAW]) @ _about(1, rows[:, PITCH]) @ _about(0, rows[:, ROLL])
    position = np.column_stack([flat[:, 1], flat[:, 0], rows[:, ALTITUDE] - rows[0, ALTITUDE]]) + unit @ place
    return np.concatenate([unit @ unit_to_camera.T, position[:, :, None]], axis=2)


def _about(axis: int, angles_rad: Floats) -> Floats:
    """(M, 3, 3) right-handed rotations."""
    turns = np.zeros((len(angles_rad), 3, 3))
    second, third = (axis + 1) % 3, (axis + 2) % 3
    turns[:, axis, axis] = 1.0
    turns[:, second, second] = turns[:, third, third] = np.cos(angles_rad)
    turns[:, third, second] = np.sin(angles_rad)
    turns[:, second, third] = -np.sin(angles_rad)
    return turns
