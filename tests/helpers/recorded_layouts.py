"""One drive whose motion is known, written in the layout of each source: signs, units, clocks and names are theirs.

The car turns right, faster and faster: x forward, y right, yaw clockwise from north-east.
"""

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import av
import cv2
import numpy as np

from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

FRAMES, RATE_HZ = 24, 10.0
START_MPS, ACCELERATION_MPS2, YAW_RATE_RADPS = 8.0, 0.9, 0.2
CLOCK_S = 1574859772.5
LATITUDE_DEG, LONGITUDE_DEG, COURSE_RAD = 49.0, 8.4, 0.8  # course clockwise from north
EARTH_RADIUS_M = 6378137.0
FINE = 50  # steps of the integration between two frames


@dataclass(frozen=True)
class Truth:
    """At each frame; or at each time that a sensor of its own rate has."""

    times_s: Floats
    speed_mps: Floats
    yaw_rate_radps: Floats
    poses: Floats  # (N, 3)


def truth(times_s: Floats | None = None) -> Truth:
    times = np.arange(FRAMES) / RATE_HZ if times_s is None else times_s
    fine = np.linspace(0.0, max(times[-1], 1e-9), FINE * len(times))
    speed, yaw = START_MPS + ACCELERATION_MPS2 * fine, YAW_RATE_RADPS * fine
    step = np.diff(fine) * 0.5 * (speed[1:] + speed[:-1])
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    path = [np.concatenate([[0.0], np.cumsum(step * part)]) for part in (np.cos(middle), np.sin(middle))]
    poses = np.stack([np.interp(times, fine, part) for part in (*path, yaw)], axis=1)
    return Truth(times, START_MPS + ACCELERATION_MPS2 * times, np.full(len(times), YAW_RATE_RADPS), poses)


def places(poses: Floats) -> tuple[Floats, Floats]:
    """Latitude and longitude, deg, of poses that start north-east."""
    cosine, sine = np.cos(COURSE_RAD), np.sin(COURSE_RAD)
    north, east = cosine * poses[:, 0] - sine * poses[:, 1], sine * poses[:, 0] + cosine * poses[:, 1]
    scale = np.cos(np.radians(LATITUDE_DEG)) * EARTH_RADIUS_M
    return LATITUDE_DEG + np.degrees(north / EARTH_RADIUS_M), LONGITUDE_DEG + np.degrees(east / scale)


def picture(index: int, width: int = 96, height: int = 64) -> Image:
    """(H, W, 3), another for each frame."""
    noise = stream(index, "picture").integers(0, 256, (8, 12, 3), dtype=np.uint8)
    return cv2.resize(noise, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.uint8, copy=False)


def pictures(folder: Path, names: list[str], width: int = 96, height: int = 64) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for index, name in enumerate(names):
        cv2.imwrite(str(folder / name), picture(index, width, height))


def video(path: Path, frames: list[Image], rate_hz: float = RATE_HZ, stamps: list[int] | None = None) -> None:
    """`stamps` in milliseconds; evenly at the rate without. A stream in a raw .hevc has none."""
    raw = path.suffix == ".hevc"
    with av.open(str(path), "w", format="hevc" if raw else None) as container:
        quiet = {"x265-params": "log-level=none:pools=1", "crf": "35"} if raw else {"g": "6", "crf": "10"}
        stream_ = container.add_stream("libx265" if raw else "libx264", rate=1000 if stamps else round(rate_hz))
        stream_.options = {**quiet, "preset": "ultrafast"}
        stream_.width, stream_.height, stream_.pix_fmt = frames[0].shape[1], frames[0].shape[0], "yuv420p"
        for index, image in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            if stamps:
                frame.pts = stamps[index]
            container.mux(stream_.encode(frame))
        container.mux(stream_.encode())


def kitti_raw(day: Path) -> Path:
    """A _sync drive with its calibration one folder up; headings counter-clockwise from east."""
    folder = day / "2011_09_26_drive_0001_sync"
    known = truth()
    pictures(folder / "image_02" / "data", [f"{k:010d}.png" for k in range(FRAMES)])
    (folder / "oxts" / "data").mkdir(parents=True)
    yaw = known.poses[:, 2]
    unit = known.poses.copy()  # 1 m behind and 0.3 m to the right of the camera
    unit[:, 0] -= np.cos(yaw) * 1.0 + np.sin(yaw) * 0.3
    unit[:, 1] -= np.sin(yaw) * 1.0 - np.cos(yaw) * 0.3
    latitude, longitude = places(unit)
    for k in range(FRAMES):
        row = np.zeros(30)
        row[:3] = latitude[k], longitude[k], 112.8
        row[5] = np.pi / 2.0 - COURSE_RAD - known.poses[k, 2]
        row[8], row[14], row[22] = known.speed_mps[k], ACCELERATION_MPS2, -known.yaw_rate_radps[k]
        (folder / "oxts" / "data" / f"{k:010d}.txt").write_text(" ".join(f"{value:.15g}" for value in row) + "\n")
    stamps = [datetime.fromtimestamp(CLOCK_S + time, UTC) for time in known.times_s]
    text = "".join(f"{stamp:%Y-%m-%d %H:%M:%S.%f}000\n" for stamp in stamps)
    for name in ("image_02", "oxts"):
        (folder / name / "timestamps.txt").write_text(text)
    kitti_calibration(day)
    return folder


def kitti_calibration(day: Path) -> None:
    """A camera of 96 x 64 px that looks 0.02 rad down, in a car whose lidar and unit are level."""
    turn = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    down, _ = cv2.Rodrigues(np.array([0.02, 0.0, 0.0]))
    numbers = {
        "corner_dist": "9.95e-02",
        "S_02": "100 70",
        "K_02": "90 0 50 0 91 33 0 0 1",
        "D_02": "-0.36 0.2 0.001 0.0005 -0.08",
        "S_rect_02": "96 64",
        "R_rect_02": "1 0 0 0 1 0 0 0 1",
        "P_rect_02": "80 0 48.5 4.5 0 80 31.5 0.2 0 0 1 0.003",
        "R_rect_00": "1 0 0 0 1 0 0 0 1",
    }
    rows = ["calib_time: 09-Jan-2012 13:57:47", *(f"{key}: {value}" for key, value in numbers.items())]
    (day / "calib_cam_to_cam.txt").write_text("\n".join(rows) + "\n")
    # The lidar is 0.8 m ahead of the unit, the camera another 0.2 m and 0.3 m to the left.
    chain = {"velo_to_cam": (down @ turn, -down @ turn @ [0.2, 0.3, 0.0]), "imu_to_velo": (np.eye(3), [-0.8, 0.0, 0.0])}
    for name, (matrix, shift) in chain.items():
        values, moved = (" ".join(f"{value:.9e}" for value in np.ravel(part)) for part in (matrix, shift))
        (day / f"calib_{name}.txt").write_text(f"calib_time: 15-Mar-2012 11:37:16\nR: {values}\nT: {moved}\n")


def tracklets(folder: Path, ahead_m: float, left_m: float, first_frame: int, count: int) -> None:
    """One labelled car, 4 m long."""
    pose = f"<item><tx>{ahead_m}</tx><ty>{left_m}</ty><tz>-1</tz></item>"
    body = f"<objectType>Car</objectType><h>1.5</h><w>1.6</w><l>4.0</l><first_frame>{first_frame}</first_frame>"
    poses = f"<poses><count>{count}</count>{pose * count}</poses>"
    text = (
        f"<boost_serialization><tracklets><count>1</count><item>{body}{poses}</item></tracklets></boost_serialization>"
    )
    (folder / "tracklet_labels.xml").write_text(text)


def comma2k19(folder: Path, with_video: bool = True) -> Path:
    """A segment; ECEF, Hamilton quaternions, arrays without a suffix; the camera looks 0.03 rad down."""
    known = truth()
    boot_s = 46408.5
    if with_video:
        folder.mkdir(parents=True)
        video(folder / "video.hevc", [picture(k, 1164, 874) for k in range(FRAMES)])
    level, origin = _east_north_up()
    cosine, sine = np.cos(COURSE_RAD), np.sin(COURSE_RAD)
    north = cosine * known.poses[:, 0] - sine * known.poses[:, 1]
    east = sine * known.poses[:, 0] + cosine * known.poses[:, 1]
    heading = COURSE_RAD + known.poses[:, 2]
    velocity = known.speed_mps[:, None] * np.stack([np.sin(heading), np.cos(heading), 0.0 * heading], axis=1)
    pose = folder / "global_pose"
    _save(pose / "frame_times", boot_s + known.times_s)
    _save(pose / "frame_positions", origin + np.stack([east, north, 0.0 * east], axis=1) @ level)
    _save(pose / "frame_velocities", velocity @ level)
    _save(pose / "frame_orientations", np.array([_quaternion(level.T @ _axes(one, 0.03)) for one in heading]))
    log = folder / "processed_log" / "CAN"
    often = np.arange(0.0, known.times_s[-1] + 0.05, 0.0113)
    fast = truth(often)
    _logged(log / "speed", boot_s + often, fast.speed_mps[:, None])
    road = np.arctan(2.65 * fast.yaw_rate_radps / fast.speed_mps)
    _logged(log / "steering_angle", boot_s + often, -np.degrees(road) * 16.88)  # + is left
    radar = np.array([[30.0, -0.5, 1.0, np.nan, np.nan, 528.0, 0.0], [12.0, 3.5, 1.0, np.nan, np.nan, 529.0, 0.0]])
    _logged(log / "radar", boot_s + np.repeat(known.times_s, 2), np.tile(radar, (FRAMES, 1)))
    return folder


def _logged(folder: Path, times_s: Floats, values: Floats) -> None:
    _save(folder / "t", times_s)
    _save(folder / "value", values)


def _save(file: Path, values: Floats) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("wb") as stream_:
        np.save(stream_, values)


def _east_north_up() -> tuple[Floats, Floats]:
    """(3, 3) rows east, north, up in ECEF and (3,) m the place."""
    latitude, longitude = np.radians([LATITUDE_DEG, LONGITUDE_DEG])
    up = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    squared = 0.00669437999
    normal = EARTH_RADIUS_M / np.sqrt(1.0 - squared * np.sin(latitude) ** 2)
    return np.stack([east, np.cross(up, east), up]), normal * up * [1.0, 1.0, 1.0 - squared]


def _axes(heading_rad: float, pitch_rad: float) -> Floats:
    """(3, 3) from [forward, right, down] of a camera to east, north, up."""
    forward = np.array([np.sin(heading_rad), np.cos(heading_rad), 0.0])
    right = np.array([np.cos(heading_rad), -np.sin(heading_rad), 0.0])
    below = np.array([0.0, 0.0, -1.0])
    axis = np.cos(pitch_rad) * forward + np.sin(pitch_rad) * below
    return np.stack([axis, right, np.cross(axis, right)], axis=1)


def _quaternion(matrix: Floats) -> Floats:
    """(4,) Hamilton, w first."""
    turn, _ = cv2.Rodrigues(matrix)
    angle = float(np.linalg.norm(turn))
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * turn.ravel() / angle)])


def radiate(folder: Path, clock_off_s: float = 0.0) -> Path:
    """A sequence; places and velocities north, east, down, turn about down; each record of the unit comes twice."""
    known = truth()
    pictures(folder / "zed_left", [f"{k + 1:06d}.png" for k in range(FRAMES)], 672, 376)
    lines = [f"Frame: {k + 1:06d} Time: {CLOCK_S + time:.9f}\n" for k, time in enumerate(known.times_s)]
    (folder / "zed_left.txt").write_text("".join(lines))
    (folder / "meta.json").write_text(json.dumps({"name": "fog_6_0", "type": "fog", "set": "test"}))
    times = np.repeat(np.arange(0.0, known.times_s[-1] + 0.06, 0.05), 2)
    unit = truth(times)
    latitude, longitude = places(unit.poses)
    heading = COURSE_RAD + unit.poses[:, 2]
    (folder / "GPS_IMU_Twist").mkdir()
    stamps = []
    for k, time in enumerate(times):
        rows = [f"{latitude[k]:.15f},{longitude[k]:.15f},209.2", *["0.0,0.0,0.0"] * 3, "0.0,0.0,-0.98,-0.16"]
        rows += ["0.0,0.0,0.0"] * 11
        rows.append(f"{unit.speed_mps[k] * np.cos(heading[k]):.6f},{unit.speed_mps[k] * np.sin(heading[k]):.6f},0.0")
        rows.append(f"0.0,0.0,{unit.yaw_rate_radps[k]:.6f}")
        (folder / "GPS_IMU_Twist" / f"{k + 1:06d}.txt").write_text(" \n".join(rows) + " \n")
        stamps.append(f"Frame: {k + 1:06d} Time: {CLOCK_S + clock_off_s + time:.9f}\n")
    (folder / "GPS_IMU_Twist.txt").write_text("".join(stamps))
    return folder


def radar_labels(folder: Path, ahead_m: float, right_m: float, frames: int) -> None:
    """One labelled car whose box, 2 m by 4 m, is seen by the radar's last `frames` pictures of ten."""
    centre = (576.0 + right_m / 0.17361, 576.0 - (ahead_m + 2.0) / 0.17361)
    box = {"position": [centre[0] - 5.76, centre[1] - 11.52, 11.52, 23.04], "rotation": 0.0}
    body = {"id": 1, "class_name": "car", "bboxes": [[]] * (10 - frames) + [box] * frames}
    (folder / "annotations").mkdir()
    (folder / "annotations" / "annotations.json").write_text(json.dumps([body]))
    lines = [f"Frame: {k + 1:06d} Time: {CLOCK_S + 0.25 * k:.9f}\n" for k in range(10)]
    (folder / "Navtech_Cartesian.txt").write_text("".join(lines))


def udacity(folder: Path) -> Path:
    """interpolated.csv with rows of three cameras; the wheel's angle + left."""
    known = truth()
    latitude, longitude = places(known.poses)
    wheel = -np.arctan(2.85 * known.yaw_rate_radps / known.speed_mps) * 14.8
    rows = ["index,timestamp,width,height,frame_id,filename,angle,torque,speed,lat,long,alt"]
    for k, time in enumerate(known.times_s):
        stamp = int(CLOCK_S) * 10**9 + round(time * 1e9)
        for side in ("left", "center", "right"):
            name = f"{side}/{stamp}.png"
            rest = f"{wheel[k]:.9f},0.1,{known.speed_mps[k]:.9f},{latitude[k]:.12f},{longitude[k]:.12f},8.1"
            rows.append(f"{stamp},{stamp},640,480,{side}_camera,{name},{rest}")
    names = [f"{int(CLOCK_S) * 10**9 + round(time * 1e9)}.png" for time in known.times_s]
    pictures(folder / "center", names)
    (folder / "interpolated.csv").write_text("\n".join(rows) + "\n")
    return folder


DRIVE_TOML = """schema = 1
name = "my drive"
weather = "light rain"
[camera]
fx_px = 80.0
height_m = 1.3
pitch_deg = 2.0
yaw_deg = 0.0
[vehicle]
wheelbase_m = 2.6
steering_ratio = 15.0
[signals]
left_is_positive = ["steering"]
[signals.columns]
speed_kmh = "v"
"""


def general(folder: Path) -> Path:
    """A video, drive.toml and a table of another rate: speed in km/h, the steering wheel in degrees, + left."""
    known = truth(np.arange(0.0, FRAMES / RATE_HZ, 0.04))
    folder.mkdir(parents=True)
    video(folder / "drive.mp4", [picture(k) for k in range(FRAMES)])
    wheel = -np.degrees(np.arctan(2.6 * known.yaw_rate_radps / known.speed_mps)) * 15.0
    rows = ["time_s,v,steering_wheel_deg,yaw_rate_degps,note"]
    for k, time in enumerate(known.times_s):
        turn = np.degrees(known.yaw_rate_radps[k])
        rows.append(f"{time:.6f},{3.6 * known.speed_mps[k]:.9f},{wheel[k]:.9f},{turn:.9f},x")
    (folder / "signals.csv").write_text("\n".join(rows) + "\n")
    (folder / "drive.toml").write_text(DRIVE_TOML)
    return folder


def kitti_odometry(dataset: Path) -> Path:
    """sequences/03 and poses/03.txt as the benchmark has them."""
    known = truth()
    folder = dataset / "sequences" / "03"
    pictures(folder / "image_2", [f"{k:06d}.png" for k in range(FRAMES)])
    row = "80 0 48.5 {} 0 80 31.5 0 0 0 1 0"
    calibration = [f"P{k}: {row.format(value)}" for k, value in enumerate((0, -43, 4, -40))]
    (folder / "calib.txt").write_text("\n".join([*calibration, "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0"]) + "\n")
    (folder / "times.txt").write_text("".join(f"{time:.6e}\n" for time in known.times_s))
    (dataset / "poses").mkdir()
    (dataset / "poses" / "03.txt").write_text("".join(_pose_row(pose) for pose in known.poses))
    return folder


def _pose_row(pose: Floats) -> str:
    turn, _ = cv2.Rodrigues(np.array([0.0, pose[2], 0.0]))
    matrix = np.column_stack([turn, [pose[1], 0.0, pose[0]]])
    return " ".join(f"{value:.12e}" for value in matrix.ravel()) + "\n"
