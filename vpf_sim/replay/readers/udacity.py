"""Reader of drives of Udacity's second challenge (udacity/self-driving-car, datasets/CH2 and the legacy HMB sets).

interpolated.csv of udacity-driving-reader: index, timestamp (ns), width, height, frame_id, filename, angle, torque,
speed, lat, long, alt, with the pictures beside it; or a table with units in its names (t_ns, file, steering_angle_rad,
speed_mps); or that of the final test, frame_id (ns) and steering_angle, with center/<frame_id>.jpg. The angle is that
of the steering wheel in rad, + left, of a Lincoln MKZ 2016; the speed in m/s.
"""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, image_files, places, series
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.types import Floats

LAYOUT = "Udacity challenge 2"
EXPECTED = "interpolated.csv (timestamp, frame_id, filename, angle, speed) or frame_id, steering_angle; its pictures"
STEERING_RATIO, WHEELBASE_M = 14.8, 2.85  # Lincoln MKZ 2016
HEIGHT_M = 1.4
SIZE = (640, 480)  # of the cameras
NAMES = {  # of what we use, in each of the tables
    "time": ("timestamp", "t_ns", "frame_id"),
    "file": ("filename", "file", "file"),
    "steering": ("angle", "steering_angle_rad", "steering_angle"),
    "speed": ("speed", "speed_mps", "speed"),
}
CENTRE = "center_camera"


def recognises(folder: Path) -> bool:
    return _table(folder) is not None


def read(folder: Path) -> Recording:
    """The centre camera's frames."""
    file = _table(folder)
    assert file is not None
    columns = _centre(series.table(file, "the rows of the frames"))
    final = "timestamp" not in columns and "t_ns" not in columns  # the test's table has no speed
    if final:
        columns["file"] = [_picture(folder, cell) for cell in columns["frame_id"]]
    names = {key: _name(file, columns, key) for key in NAMES if not (final and key == "speed")}
    # ns since 1970 have more digits than a float: the first is taken off before.
    stamps = _nanoseconds(file, columns[names["time"]])
    times = series.ascending(file, (stamps - stamps[0]) * 1e-9)
    files = [folder / name for name in columns[names["file"]]]
    present = [path.exists() for path in files]
    size = image_files.size(files, folder) if all(present) else SIZE
    source = assemble.Source(
        name=folder.resolve().name,
        layout=LAYOUT,
        times_s=times,
        frames=lambda: image_files.frames(files, size),
        files=files,
        lens=assemble.assumed_lens(*size),
        height_m=HEIGHT_M,
        height_assumed=True,
        wheelbase_m=WHEELBASE_M,
    )
    if not all(present):
        source.no_images = _missing(folder, files, present)
    degrees = np.degrees(assemble.FIELD_OF_VIEW_RAD)
    source.origins["camera"] = Origin("assumed", f"{degrees:.0f} deg across and {HEIGHT_M:g} m high: none is recorded")
    source.origins["times_s"] = Origin("recorded", f"{file.name} {names['time']}")
    if not final:
        source.put("speed_mps", series.column(file, columns, names["speed"]), f"{file.name} {names['speed']}")
    wheel = series.column(file, columns, names["steering"])
    how = f"{file.name} {names['steering']}, its sign turned, over {STEERING_RATIO:g}, the ratio of a Lincoln MKZ"
    source.put("steering_rad", -wheel / STEERING_RATIO, how)
    _places(source, file, columns)
    return assemble.recording(source)


def _places(source: assemble.Source, file: Path, columns: dict[str, list[str]]) -> None:
    """The way by latitude and longitude, heading where it goes."""
    longitude = "lon" if "lon" in columns else "long"
    if not {"lat", longitude} <= set(columns):
        return
    place = [series.filled(series.column(file, columns, name))[0] for name in ("lat", longitude)]
    if np.isfinite(place).all():
        flat = places.north_east(*place)
        way = places.way(flat, places.course(source.times_s, flat))
        source.put("poses", way, f"{file.name} lat, {longitude}; heading by the course")
        source.heading_recorded = False


def _table(folder: Path) -> Path | None:
    """The table of the folder whose header is one of the three."""
    for file in sorted(folder.glob("*.csv"), key=lambda path: path.name != "interpolated.csv"):
        with file.open(encoding="utf-8-sig", errors="replace") as stream:
            header = {name.strip() for name in stream.readline().split(",")}
        for time, steering in zip(NAMES["time"], NAMES["steering"], strict=True):
            if {time, steering} <= header:
                return file
    return None


def _picture(folder: Path, frame_id: str) -> str:
    """The frame's picture in center/, .jpg unless there is another."""
    names = [f"center/{frame_id}{suffix}" for suffix in (".jpg", ".png")]
    return next((name for name in names if (folder / name).exists()), names[0])


def _name(file: Path, columns: dict[str, list[str]], key: str) -> str:
    found = [name for name in NAMES[key] if name in columns]
    if not found:
        raise InputError(f"{file}: expected a column {' or '.join(NAMES[key])}, found {', '.join(columns)}")
    return found[0]


def _centre(columns: dict[str, list[str]]) -> dict[str, list[str]]:
    """The rows of the centre camera, where there are those of several."""
    if CENTRE not in columns.get("frame_id", []):
        return columns
    chosen = [k for k, name in enumerate(columns["frame_id"]) if name == CENTRE]
    return {name: [cells[k] for k in chosen] for name, cells in columns.items()}


def _nanoseconds(file: Path, cells: list[str]) -> Floats:
    """(N,) from the first, exact; the first itself is lost."""
    try:
        whole = [int(cell) for cell in cells]
    except ValueError:
        wrong = next(cell for cell in cells if not cell.lstrip("-").isdigit())
        raise InputError(f"{file}: expected times in whole nanoseconds, got '{wrong[:40]}'") from None
    return np.array([value - whole[0] for value in whole], float)


def _missing(folder: Path, files: list[Path], present: list[bool]) -> str:
    first = files[present.index(False)].relative_to(folder)
    return (
        f"{folder}: {present.count(False)} of {len(files)} pictures are missing, the first is {first}: get them "
        "from the challenge's data set; the signals are there, so the recording can be listed and plotted, not driven"
    )
