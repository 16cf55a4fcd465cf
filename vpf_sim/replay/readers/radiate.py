"""Reader of a sequence of RADIATE (Sheeny et al., ICRA 2021; README of marcelsheeny/radiate_sdk).

zed_left/*.png and zed_left.txt ("Frame: 000001 Time: 1574859772.428"), GPS_IMU_Twist/*.txt and its times, meta.json
with the weather, annotations/annotations.json: boxes on the radar's images. GPS_IMU_Twist has latitude and longitude
in line 1, and in the last two the velocity (north, east, down; m/s) and the yaw rate (rad/s; about down, + right). Its
own positions confirm this. The camera is that of the development kit, calib.yaml replaces it. Also an excerpt: image/,
calib.yaml and labels.csv (t_unix, speed_mps_lidar, yaw_rate_rads_lidar).
"""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, derived, image_files, paths, series
from vpf_sim.replay.plausible import Location
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.replay.rectify import Lens
from vpf_sim.types import Bools, Floats

LAYOUT = "RADIATE"
EXPECTED = "zed_left/ and zed_left.txt, or image/, calib.yaml and labels.csv"
LEFT_CAMERA = {  # of the development kit, config/default-calib.yaml
    "fx": 337.9191448899105,
    "fy": 338.6957068549526,
    "cx": 341.7366010946575,
    "cy": 200.7359735313929,
    "k1": -0.183879883467351,
    "k2": 0.0308609205858947,
    "k3": 0.0,
    "p1": 0.0,
    "p2": 0.0,
}
SIZE = (672, 376)
HEIGHT_M = 1.6  # of the camera above the road, approximate
RADAR_CENTRE_PX, RADAR_M_PER_PX = 576.0, 0.17361
ACROSS_M, REACH_M = 1.8, 40.0
WEATHERS = {"fog": "fog", "rain": "rain", "snow": "snow", "night": "night", "motorway": "overcast"}
STAMP = r"\s*Frame:\s*(0*[1-9][0-9]{0,6})\s+Time:\s*([0-9]{1,11}(?:\.[0-9]*)?)\s*"
VELOCITY_LINE, TURN_LINE = -2, -1


def recognises(folder: Path) -> bool:
    names = ("zed_left", "zed_left.txt", "calib.yaml")
    return any((folder / name).exists() for name in names) or _has_unix_times(folder / "labels.csv")


def _has_unix_times(file: Path) -> bool:
    """Whether the file is the table of an excerpt."""
    return file.exists() and "t_unix" in file.open(encoding="utf-8", errors="replace").readline()


def read(folder: Path) -> Recording:
    """The left camera's frames."""
    full = (folder / "zed_left").is_dir() or (folder / "zed_left.txt").exists()
    files, clock_s, notes = _listed(folder) if full else _excerpt(folder)
    size = image_files.size(files, folder)
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=clock_s - clock_s[0],
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=_lens(folder / "calib.yaml", size),
        height_m=HEIGHT_M,
        weather=_weather(folder),
        notes=notes,
    )
    place = "calib.yaml" if (folder / "calib.yaml").exists() else "the development kit's"
    source.origins["camera"] = Origin("recorded", f"{place} left camera; {HEIGHT_M:g} m above the road, assumed")
    source.origins["times_s"] = Origin("recorded", "zed_left.txt" if full else "labels.csv t_unix")
    if full:
        _motion(source, folder, clock_s)
        _labels(source, folder, clock_s)
    else:
        file = folder / "labels.csv"
        table = series.table(file, "a row for each frame")
        for name, column in (("speed_mps", "speed_mps_lidar"), ("yaw_rate_radps", "yaw_rate_rads_lidar")):
            source.put(name, table.signal(column, name, source.notes), "lidar odometry", "derived")
    return assemble.recording(source)


def _listed(folder: Path) -> tuple[list[Path], Floats, list[str]]:
    """The frames of zed_left.txt with an image, in order of time."""
    numbers, clock_s = _stamps(folder / "zed_left.txt")
    files = [folder / "zed_left" / f"{number:06d}.png" for number in numbers]
    there = np.array([file.exists() for file in files])
    if not there.any():
        raise InputError(f"{folder}: expected images zed_left/{numbers[0]:06d}.png and so on, found none")
    after = _after(clock_s) & there
    notes = []
    if not there.all():
        notes.append(f"zed_left/: {np.count_nonzero(~there)} of {len(there)} images are missing")
    if np.count_nonzero(there & ~after):
        notes.append(
            f"zed_left.txt: {np.count_nonzero(there & ~after)} frames are removed, since their times run backward"
        )
    return [file for file, used in zip(files, after, strict=True) if used], clock_s[after], notes


def _excerpt(folder: Path) -> tuple[list[Path], Floats, list[str]]:
    if not (folder / "image").is_dir():
        raise InputError(f"{folder}: expected images in zed_left/ or image/, found neither")
    files, file = image_files.listed(folder / "image"), folder / "labels.csv"
    clock_s = series.table(file, "a row for each frame").times("t_unix")
    if len(files) != len(clock_s):
        raise InputError(f"{file}: expected {len(files)} rows for {len(files)} images, got {len(clock_s)}")
    return files, clock_s, []


def _stamps(file: Path) -> tuple[list[int], Floats]:
    """Numbers and times, s, of a sensor's frames."""
    numbers, times = [], []
    for row, line in enumerate(series.lines(file, "the time of each frame"), 1):
        found = re.fullmatch(STAMP, line)
        if found:
            numbers.append(int(found[1]))
            times.append(float(found[2]))
        elif line.strip():
            raise InputError(f"{file}: line {row}: expected 'Frame: 000001 Time: 1574859772.4', got {line[:40]!r}")
    if not numbers:
        raise InputError(f"{file}: expected a line for each frame, found none")
    return numbers, np.array(times)


def _after(times_s: Floats) -> Bools:
    """Which (N,) times exceed all before them: the recorder dropped zeros of some fractions."""
    latest = np.maximum.accumulate(times_s)
    return np.concatenate([[True], times_s[1:] > latest[:-1]])


def _lens(file: Path, size: tuple[int, int]) -> Lens:
    """The left camera, by calib.yaml if there is one."""
    value = dict(LEFT_CAMERA)
    expected = SIZE
    if file.exists():
        text = "\n".join(series.lines(file, "RADIATE's calibration")).partition("left_cam_calib:")[2]
        rows = re.findall(
            r"^\s+(\w+):\s*(-?[0-9]+\.?[0-9]*(?:e[+-]?[0-9]+)?)\s*$", text.partition("_cam_calib:")[0], re.MULTILINE
        )
        value = {key: float(number) for key, number in rows}
        if missing := [key for key in LEFT_CAMERA if key not in value]:
            raise InputError(f"{file}: left_cam_calib: expected numbers {', '.join(missing)}, found none")
        if found := re.search(
            r"^\s+res:\s*\[([0-9]{1,6}),\s*([0-9]{1,6})\]", text.partition("_cam_calib:")[0], re.MULTILINE
        ):
            expected = (int(found[1]), int(found[2]))
    if size != expected:
        wanted, actual = (f"{width} x {height}" for width, height in (expected, size))
        raise InputError(f"{file.parent}: expected images of {wanted} px, those of the calibration, got {actual}")
    fx, fy, cx, cy = (value[key] for key in ("fx", "fy", "cx", "cy"))
    distortion = tuple(value[key] for key in ("k1", "k2", "p1", "p2", "k3"))
    return Lens(*size, fx, fy, cx, cy, distortion if any(distortion[2:]) else distortion[:2])


def _weather(folder: Path) -> str:
    """By meta.json, else by the sequence's name such as fog_6_0."""
    kind = folder.resolve().name.removeprefix("tiny_").removeprefix("radiate_").partition("_")[0]
    if (folder / "meta.json").exists():
        meta = _json(folder / "meta.json")
        if not isinstance(meta, dict):
            raise InputError(f"{folder / 'meta.json'}: expected an object with 'type', got other JSON")
        kind = str(meta.get("type", kind))
    return WEATHERS.get(kind, "")


def _json(file: Path) -> Any:
    try:
        return json.loads("\n".join(series.lines(file, "JSON")))
    except ValueError as error:
        raise InputError(f"{file}: expected JSON, got: {error}") from None
    except RecursionError:
        raise InputError(f"{file}: expected JSON, got too deeply nested brackets") from None


def _motion(source: assemble.Source, folder: Path, clock_s: Floats) -> None:
    """Store speed, yaw rate and poses of GPS and inertial unit, if its clock fits the camera's."""
    if not (folder / "GPS_IMU_Twist.txt").exists():
        source.notes.append("no GPS_IMU_Twist.txt: no motion was recorded")
        return
    numbers, sampled = _stamps(folder / "GPS_IMU_Twist.txt")
    files = [folder / "GPS_IMU_Twist" / f"{number:06d}.txt" for number in numbers]
    used = np.flatnonzero(_after(sampled) & np.array([file.exists() for file in files]))
    sampled = sampled[used]
    if len(used) < 2 or sampled[-1] < clock_s[0] or sampled[0] > clock_s[-1]:
        apart = sampled[0] - clock_s[0] if len(used) else np.nan
        source.notes.append(f"GPS_IMU_Twist: its clock is {apart:.1f} s off the camera's: not used")
        return
    rows = np.array([_twist(files[k]) for k in used])
    along = [source.checked("velocity_mps", rows[:, k], "GPS_IMU_Twist, north or east") for k in (2, 3)]
    speed = np.hypot(*along)
    rate = source.checked("yaw_rate_radps", rows[:, 4], "GPS_IMU_Twist")
    source.put("speed_mps", series.at(clock_s, sampled, speed), "GPS_IMU_Twist velocity")
    source.put("yaw_rate_radps", series.at(clock_s, sampled, rate), "GPS_IMU_Twist angular velocity about down")
    flat = paths.fixes(sampled, rows[:, 0], rows[:, 1], Location(str(folder), "GPS_IMU_Twist"), source.notes)
    path = paths.poses(flat, paths.course(sampled, flat))
    source.put("poses", derived.poses_at(clock_s, sampled, path), "GPS_IMU_Twist positions")


def _twist(file: Path) -> tuple[float, float, float, float, float]:
    """Latitude, longitude, velocity north and east, yaw rate about down."""
    lines = [line for line in series.lines(file, "RADIATE's GPS_IMU_Twist") if line.strip()]
    try:
        place, velocity, turn = ([float(cell) for cell in lines[i].split(",")] for i in (0, VELOCITY_LINE, TURN_LINE))
        return place[0], place[1], velocity[0], velocity[1], turn[2]
    except (ValueError, IndexError):
        raise InputError(f"{file}: expected lines of three numbers, 'a,b,c', got other text") from None


def _labels(source: assemble.Source, folder: Path, clock_s: Floats) -> None:
    """Store which frames are blocked by a labelled object, by the nearest radar image in time."""
    file, times_file = folder / "annotations" / "annotations.json", folder / "Navtech_Cartesian.txt"
    if not file.exists() or not times_file.exists():
        return
    numbers, radar_s = _stamps(times_file)
    gap = np.full(max(numbers), np.inf)  # by the radar's frame, 1 is the first
    try:
        for item in _json(file):
            for index, box in enumerate(item["bboxes"][: len(gap)]):
                if box:
                    gap[index] = min(gap[index], _ahead(*box["position"]))
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{file}: expected a list of bboxes with position, got other JSON") from None
    middle = 0.5 * (radar_s[1:] + radar_s[:-1])
    nearest = gap[np.array(numbers)[np.searchsorted(np.sort(middle), clock_s)] - 1]
    where = f"annotations.json, within {ACROSS_M:g} m of straight ahead and {REACH_M:g} m"
    source.put("obstacle", np.isfinite(nearest).astype(float), where)
    source.put("lead_gap_m", np.where(np.isfinite(nearest), nearest, np.nan), f"{where}, from the radar")


def _ahead(x_px: float, y_px: float, width_px: float, height_px: float) -> float:
    """m from the radar to the near side of a box in the corridor, else inf; up in the image is ahead."""
    across = (x_px + 0.5 * width_px - RADAR_CENTRE_PX) * RADAR_M_PER_PX
    near = (RADAR_CENTRE_PX - y_px - height_px) * RADAR_M_PER_PX
    return near if abs(across) < ACROSS_M and 0.0 < near < REACH_M else np.inf
