"""KITTI's GPS and inertial unit: a file of 30 numbers for each record (dataformat.txt of the raw data's kit).

Its axes are forward, left, up; its heading counter-clockwise from east, its turn about up + left.
"""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import gps, series
from vpf_sim.replay.plausible import Location
from vpf_sim.types import Floats

FIELDS = 30
RECEPTION = 5  # last fields, about reception; some drives lack them
ATTITUDE = [3, 4, 5]
LATITUDE, LONGITUDE, ALTITUDE, ROLL, PITCH, YAW, FORWARD_MPS, FORWARD_MPS2, UP_RADPS = 0, 1, 2, 3, 4, 5, 8, 14, 22


def read(folder: Path) -> Floats:
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


def fixes(rows: Floats, times_s: Floats, folder: Path, notes: list[str]) -> Floats:
    """(M, 2) m north and east of the first fix; nan without a fix."""
    return gps.fixes(times_s, rows[:, LATITUDE], rows[:, LONGITUDE], Location(str(folder), "lat, lon"), notes)


def path(rows: Floats, flat: Floats, place: Floats) -> Floats:
    """(M, 3) poses of a position (3,) on the unit, which is at `flat` (M, 2)."""
    result = gps.poses(flat, 0.5 * np.pi - rows[:, YAW])
    cosine, sine, ahead, right = np.cos(result[:, 2]), np.sin(result[:, 2]), place[0], -place[1]
    result[:, 0] += cosine * ahead - sine * right
    result[:, 1] += sine * ahead + cosine * right
    return result


def camera_to_world(rows: Floats, flat: Floats, place: Floats, unit_to_camera: Floats) -> Floats:
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
