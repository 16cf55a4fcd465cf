"""Reader of a segment of comma2k19 (Schafer et al., arXiv:1812.05752, README of commaai/comma2k19).

video.hevc, 20 Hz, 1164 x 874 px; processed_log/<CAN, IMU, GNSS>/<signal>/{t, value} and global_pose/frame_*, NumPy
arrays whatever their suffix; times in seconds since the device's boot. CAN speed in m/s, steering wheel in degrees, +
left, as is the radar's side; poses of the camera in ECEF, quaternions of [forward, right, down].
"""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.geometry import mounting_in_words
from vpf_sim.replay import assemble, paths, plausible, series, video_file
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.replay.rectify import Lens, mounting_from_direction
from vpf_sim.types import Floats

LAYOUT = "comma2k19 segment"
EXPECTED = "video.hevc, processed_log/, global_pose/"
LENS = Lens(1164, 874, 910.0, 910.0, 582.0, 437.0)  # of the EON, by comma's transformations
HEIGHT_M = 1.22  # of the EON above the road, by comma's transformations
# Steering wheel over road wheel, and wheelbase, of the two cars as in openpilot; the radar's addresses identify it.
CARS = {"Toyota RAV4": (16.88, 2.65), "Honda Civic": (15.38, 2.70)}
HONDA_FIRST_ADDRESS = 0x400
EARTH_M = 6.367e6  # radius, within 0.2 %
ACROSS_M, RADAR_GAP_S = 1.5, 0.2  # half width of the corridor; longer than a radar's cycle
RIGHT_DOWN_FORWARD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # of [forward, right, down]


def recognises(folder: Path) -> bool:
    return (folder / "processed_log").is_dir() or (folder / "global_pose").is_dir() or len(_segments(folder)) > 0


def read(folder: Path) -> Recording:
    if not (folder / "processed_log").is_dir() and not (folder / "global_pose").is_dir():
        folder = _only_segment(folder)
    log = folder / "processed_log" / "CAN"
    stamps = _pose_array(folder, "frame_times", 1)[:, 0]
    plausible.frame_times(stamps, str(folder / "global_pose" / "frame_times"))
    source, stamps = _with_video(folder, stamps)
    widths = {"frame_positions": 3, "frame_orientations": 4, "frame_velocities": 3}
    arrays = {name: _pose_array(folder, name, width)[: len(stamps), :width] for name, width in widths.items()}
    for name, values in arrays.items():
        if len(values) < len(stamps):
            file = _named(folder / "global_pose", name)
            raise InputError(f"{file}: expected {len(stamps)} rows, one for each frame, got {len(values)}")
    _poses(source, *arrays.values())
    car = _radar(source, log, stamps)
    ratio, source.wheelbase_m = CARS[car]
    speed = _signal(source, log, "speed_mps", ("car_speed", "speed"), stamps)
    road_wheels = _signal(source, log, "steering_rad", ("steering_angle",), stamps, -np.pi / 180.0 / ratio)
    if speed is not None:
        source.put("speed_mps", speed, "CAN speed")
    if road_wheels is not None:
        source.put("steering_rad", road_wheels, f"CAN steering wheel over {ratio:g}, the ratio of a {car}")
    return assemble.recording(source)


def _segments(folder: Path) -> list[Path]:
    return sorted(path.parent for path in folder.glob("*/global_pose"))


def _only_segment(folder: Path) -> Path:
    """The folder of the only segment; InputError where there are several."""
    segments = _segments(folder)
    if len(segments) > 1:
        names = ", ".join(path.name for path in segments[:8])
        raise InputError(f"{folder}: expected one segment of comma2k19, found {len(segments)}: name one of {names}")
    return segments[0]


def _named(folder: Path, name: str) -> Path:
    """The array's file, with or without .npy: archives have none, copies often do."""
    return folder / f"{name}.npy" if (folder / f"{name}.npy").exists() else folder / name


def _pose_array(folder: Path, name: str, width: int) -> Floats:
    return series.array(_named(folder / "global_pose", name), f"the {name} of comma2k19", width)


def _with_video(folder: Path, stamps: Floats) -> tuple[assemble.Source, Floats]:
    """The source, and the frames' times on the device's clock."""
    path = folder / "video.hevc"
    name = folder.resolve().name
    if path.exists():
        video = video_file.read(path, stamps)
        stamps = stamps[: len(video.times_s)]
        lens, frames, notes, missing = _lens(path, video), video.frames, list(video.notes), ""
    else:
        lens, notes = LENS, []
        missing = (
            f"{folder}: no images: video.hevc is missing, get it from the data set's chunks; "
            f"the signals of {len(stamps)} frames are there to be checked and plotted"
        )
        frames = lambda: iter(())  # noqa: E731
    source = assemble.Source(
        name, LAYOUT, stamps - stamps[0], frames, lens, camera_ahead_m=assemble.CAMERA_AHEAD_M, notes=notes
    )
    source.no_images = missing
    source.files = [path] if path.exists() else []
    source.origins["times_s"] = Origin("recorded", "global_pose/frame_times")
    return source, stamps


def _lens(path: Path, video: video_file.Video) -> Lens:
    if (video.width_px, video.height_px) != (LENS.width_px, LENS.height_px):
        expected = f"{LENS.width_px} x {LENS.height_px}"
        raise InputError(f"{path}: expected the EON's {expected} px, got {video.width_px} x {video.height_px}")
    return LENS


def _poses(source: assemble.Source, position_m: Floats, quaternion: Floats, velocity_mps: Floats) -> None:
    """Store poses, mounting and the true focus of expansion."""
    with np.errstate(over="ignore", invalid="ignore"):
        far_m, length, speed = (np.linalg.norm(part, axis=1) for part in (position_m, quaternion, velocity_mps))
    on_earth = (np.abs(far_m / EARTH_M - 1.0) < 0.02) & (np.abs(length - 1.0) < 0.1)
    known = on_earth & (speed <= plausible.LIMITS["speed_mps"].highest)
    if not known.all():
        source.notes.append(f"global_pose: {np.count_nonzero(~known)} of {len(known)} poses removed: not on earth")
    if not known.any():
        return
    turn = _matrices(np.where(known[:, None], quaternion, np.nan)) @ RIGHT_DOWN_FORWARD.T  # from the camera to ECEF
    origin = position_m[np.argmax(known)]
    level = _level(origin)  # from ECEF to (east, down, north), x right, y down, z forward of a map
    poses = np.concatenate(
        [level @ turn, ((np.where(known[:, None], position_m, np.nan) - origin) @ level.T)[:, :, None]], axis=2
    )
    moved = np.einsum("nji,nj->ni", turn, np.where(known[:, None], velocity_mps, np.nan))  # in the camera's axes
    total = moved[known & (speed > 1.0)].sum(axis=0)
    if not np.linalg.norm(total):
        return  # it was stationary: the images may give the mounting
    source.mounting = mounting_from_direction(total, HEIGHT_M)
    pitch, yaw = np.degrees([source.mounting.pitch_rad, source.mounting.yaw_rad])
    angles = f"{mounting_in_words(pitch, yaw)}, by the poses"
    source.origins["camera"] = Origin("assumed", f"f = 910 px, centre and height 1.22 m of the EON; {angles}")
    path = paths.planar(poses)
    path[:, 2] -= source.mounting.yaw_rad
    source.put("poses", path, "global_pose")
    source.put("yaw_rate_radps", np.gradient(path[:, 2], source.times_s), "from global_pose", "derived")
    source.directions_m = paths.directions(poses)


def _matrices(quaternion: Floats) -> Floats:
    """(N, 3, 3) of Hamilton quaternions (N, 4), w first; as recorded they take [forward, right, down] to ECEF."""
    w, x, y, z = (quaternion / np.linalg.norm(quaternion, axis=1)[:, None]).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), 2, 0)


def _level(position_m: Floats) -> Floats:
    """(3, 3) from ECEF to east, down, north at a position; down by the WGS84 ellipsoid."""
    up = position_m / np.array([6378137.0, 6378137.0, 6356752.3142]) ** 2
    up = up / np.linalg.norm(up)
    east = np.cross([0.0, 0.0, 1.0], up)
    east = east / np.linalg.norm(east)
    return np.stack([east, -up, np.cross(up, east)])


def _signal(
    source: assemble.Source, log: Path, signal: str, names: tuple[str, ...], stamps: Floats, scale: float = 1.0
) -> Floats | None:
    """(N,) at the frames' times, in our unit; None if not recorded.

    The archives and the README use different names.
    """
    for name in names:
        if (log / name).is_dir():
            sampled, values = _logged(log / name, 1)
            order = np.argsort(sampled, kind="stable")
            checked = source.checked(signal, scale * values[order, 0], f"CAN {name}")
            return series.at(stamps, sampled[order], checked)
    return None


def _logged(folder: Path, width: int) -> tuple[Floats, Floats]:
    """(M,) times and (M, width or more) values of a logged signal."""
    sampled = series.array(_named(folder, "t"), f"the times of {folder.name}")[:, 0]
    values = series.array(_named(folder, "value"), f"the values of {folder.name}", width)
    if len(sampled) != len(values):
        raise InputError(f"{folder}: expected as many times as values, got {len(sampled)} and {len(values)}")
    return sampled, values


def _radar(source: assemble.Source, log: Path, stamps: Floats) -> str:
    """Store the gap to the nearest object ahead, and return which car this radar is from."""
    if not (log / "radar").is_dir():
        source.notes.append("no radar to identify the car: assumed to be a Toyota RAV4")
        return "Toyota RAV4"
    sampled, values = _logged(log / "radar", 6)
    rows = (np.abs(values[:, 1]) < ACROSS_M) & (values[:, 0] > 0.0)
    gap = np.full(len(stamps), np.inf)
    nearest = np.clip(np.searchsorted(0.5 * (stamps[1:] + stamps[:-1]), sampled[rows]), 0, len(stamps) - 1)
    close = np.abs(stamps[nearest] - sampled[rows]) < RADAR_GAP_S
    np.minimum.at(gap, nearest[close], values[rows, 0][close])
    gap = np.where(np.isinf(gap), np.nan, gap)
    source.put("lead_gap_m", gap, f"radar, nearest object within {ACROSS_M:g} m of straight ahead, from the bumper")
    return "Honda Civic" if np.median(values[:, 5]) >= HONDA_FIRST_ADDRESS else "Toyota RAV4"
