"""Reader of drives of Udacity's second challenge (udacity/self-driving-car, datasets/CH2 and the legacy HMB sets).

interpolated.csv of udacity-driving-reader: index, timestamp (ns), width, height, frame_id, filename, angle, torque,
speed, lat, long, alt, with the images beside it; or a table with units in its names (t_ns, file, steering_angle_rad,
speed_mps); or that of the final test, frame_id (ns) and steering_angle, with center/<frame_id>.jpg. The angle is that
of the steering wheel in rad, + left, of a Lincoln MKZ 2016; the speed in m/s.
"""

import os
import re
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, image_files, paths, series
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.types import Floats

LAYOUT = "Udacity challenge 2"
EXPECTED = "interpolated.csv (timestamp, frame_id, filename, angle, speed) or frame_id, steering_angle; its images"
STEERING_RATIO, WHEELBASE_M = 14.8, 2.85  # Lincoln MKZ 2016
HEIGHT_M = 1.4
SIZE = (640, 480)  # of the cameras
NAMES = {  # columns in each kind of table
    "time": ("timestamp", "t_ns", "frame_id"),
    "file": ("filename", "file", "file"),
    "steering": ("angle", "steering_angle_rad", "steering_angle"),
    "speed": ("speed", "speed_mps", "speed"),
}
CENTRE = "center_camera"
STAMP = re.compile(r"-?[0-9]{1,20}")


def recognises(folder: Path) -> bool:
    return _table(folder) is not None


def read(folder: Path) -> Recording:
    """The centre camera's frames."""
    file = _table(folder)
    assert file is not None
    table = _centre(series.table(file, "the rows of the frames"))
    final = "timestamp" not in table and "t_ns" not in table  # the final test has no speed
    if final:
        table.cells["file"] = [_image(folder, cell) for cell in table.texts("frame_id")]
    names = {key: _name(table, key) for key in NAMES if not (final and key == "speed")}
    times = series.ascending(table.where(names["time"]), 1e-9 * _nanoseconds(table, names["time"]))
    files = image_files.resolve_all(folder, table.texts(names["file"]), image_files.SUFFIXES)
    present = [os.path.exists(path) for path in files]
    size = image_files.size(files, folder) if all(present) else SIZE
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=times,
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=assemble.assumed_lens(*size),
        height_m=HEIGHT_M,
        assumed=frozenset({"lens", "height"}),
        wheelbase_m=WHEELBASE_M,
    )
    if not all(present):
        source.no_images = _missing(folder, files, present)
    degrees = np.degrees(assemble.FIELD_OF_VIEW_RAD)
    source.origins["camera"] = Origin("assumed", f"{degrees:.0f} deg across and {HEIGHT_M:g} m high, assumed")
    source.origins["times_s"] = Origin("recorded", f"{file.name} {names['time']}")
    if not final:
        speed = table.signal(names["speed"], "speed_mps", source.notes)
        source.put("speed_mps", speed, f"{file.name} {names['speed']}")
    steering = table.signal(names["steering"], "steering_rad", source.notes, -1.0 / STEERING_RATIO)
    how = f"{file.name} {names['steering']}, sign inverted, over {STEERING_RATIO:g}, the ratio of a Lincoln MKZ"
    source.put("steering_rad", steering, how)
    _poses(source, table)
    return assemble.recording(source)


def _poses(source: assemble.Source, table: series.Table) -> None:
    """Store poses by latitude and longitude, with the course as heading."""
    longitude = "lon" if "lon" in table else "long"
    if "lat" not in table or longitude not in table:
        return
    north = table.signal("lat", "latitude_deg", source.notes)
    east = table.signal(longitude, "longitude_deg", source.notes)
    flat = paths.fixes(source.times_s, north, east, table.where("lat"), source.notes)
    path = paths.poses(flat, paths.course(source.times_s, flat))
    source.put("poses", path, f"{table.file.name} lat, {longitude}; course as heading")
    source.heading_recorded = False


def _table(folder: Path) -> Path | None:
    """The table in the folder with one of the three headers."""
    for file in sorted(folder.glob("*.csv"), key=lambda path: path.name != "interpolated.csv"):
        with file.open(encoding="utf-8-sig", errors="replace") as stream:
            header = {name.strip() for name in stream.readline().split(",")}
        for time, steering in zip(NAMES["time"], NAMES["steering"], strict=True):
            if {time, steering} <= header:
                return file
    return None


def _image(folder: Path, frame_id: str) -> str:
    """The image of the frame in center/, .jpg unless there is another."""
    names = [f"center/{frame_id}{suffix}" for suffix in (".jpg", ".png")]
    return next((name for name in names if (folder / name).exists()), names[0])


def _name(table: series.Table, key: str) -> str:
    found = [name for name in NAMES[key] if name in table]
    if not found:
        raise InputError(
            f"{table.file}: expected a column {' or '.join(NAMES[key])}, found {series.listed(table.cells)}"
        )
    return found[0]


def _centre(table: series.Table) -> series.Table:
    """The rows of the centre camera, if there are several cameras."""
    cameras = table.cells.get("frame_id", [])
    return table.chosen([k for k, name in enumerate(cameras) if name == CENTRE]) if CENTRE in cameras else table


def _nanoseconds(table: series.Table, name: str) -> Floats:
    """(N,) ns from the first, exact: times since 1970 have too many digits for a float."""
    whole = []
    for line, cell in zip(table.lines, table.texts(name), strict=True):
        if not STAMP.fullmatch(cell):
            place = f"{table.file}: line {line}: {name}"
            raise InputError(f"{place}: expected times in whole nanoseconds, got {cell[:40]!r}")
        whole.append(int(cell))
    return np.array([value - whole[0] for value in whole], float)


def _missing(folder: Path, files: list[Path], present: list[bool]) -> str:
    first = f"{files[present.index(False)].parent.name}/{files[present.index(False)].name}"
    return (
        f"{folder}: {present.count(False)} of {len(files)} images are missing, the first is {first}: get them "
        "from the challenge's data set; the signals are there to be checked and plotted"
    )
