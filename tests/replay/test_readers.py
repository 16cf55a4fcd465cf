"""The same drive in each layout is read to our axes and units."""

import dataclasses
import os
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.errors import InputError
from vpf_sim.geometry import unwrapped
from vpf_sim.replay import readers
from vpf_sim.replay.drive_file import CameraKeys, DriveFile, SignalKeys, VehicleKeys
from vpf_sim.replay.readers import general_signals
from vpf_sim.replay.recording import Recording

LAYOUTS: dict[str, Callable[[Path], Path]] = {
    "KITTI odometry": layouts.kitti_odometry,
    "KITTI raw": layouts.kitti_raw,
    "comma2k19 segment": layouts.comma2k19,
    "RADIATE": layouts.radiate,
    "Udacity challenge 2": layouts.udacity,
    "video or images with drive.toml": layouts.general,
}
# Wheelbase for the bicycle model in each layout, and its recorded signals.
WHEELBASES_M = {"KITTI odometry": 2.71, "KITTI raw": 2.71, "comma2k19 segment": 2.65, "RADIATE": 2.7}
WHEELBASES_M |= {"Udacity challenge 2": 2.85, "video or images with drive.toml": 2.6}
RECORDED = {
    "KITTI odometry": {"poses", "times_s", "camera"},
    "KITTI raw": {"poses", "times_s", "speed_mps", "yaw_rate_radps", "camera"},
    "comma2k19 segment": {"poses", "times_s", "speed_mps", "steering_rad"},
    "RADIATE": {"poses", "times_s", "speed_mps", "yaw_rate_radps", "camera"},
    "Udacity challenge 2": {"poses", "times_s", "speed_mps", "steering_rad"},
    "video or images with drive.toml": {"times_s", "speed_mps", "yaw_rate_radps", "steering_rad", "camera"},
}


@pytest.fixture(scope="module", params=list(LAYOUTS))
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    result = readers.read(LAYOUTS[request.param](tmp_path_factory.mktemp("drives") / "drive"))
    assert result.layout == request.param
    return result


def test_times_speed_and_yaw_rate_match_the_drive(recording: Recording) -> None:
    known = layouts.truth()
    inside = slice(3, -3)  # frames with a complete window for slopes
    assert len(recording) == layouts.FRAMES
    assert recording.times_s == pytest.approx(known.times_s, abs=1e-6)
    assert recording.speed_mps[inside] == pytest.approx(known.speed_mps[inside], rel=2e-3)
    if recording.layout == "Udacity challenge 2":  # the flow of blank images has no truth
        return
    assert recording.yaw_rate_radps[inside] == pytest.approx(known.yaw_rate_radps[inside], rel=0.02)  # + is right


def test_path_bends_to_the_right(recording: Recording) -> None:
    known = layouts.truth()
    if recording.origins["poses"].kind == "recorded":
        assert recording.poses[:, :2] == pytest.approx(known.poses[:, :2], abs=0.1)
    assert recording.poses[-1, 0] == pytest.approx(known.poses[-1, 0], abs=0.8)
    assert recording.poses[-1, 1] == pytest.approx(known.poses[-1, 1], abs=0.8)
    turned = recording.poses[:, 2] - recording.poses[0, 2]
    assert turned[5:-5] == pytest.approx(known.poses[5:-5, 2], abs=0.06)


def test_commands_follow_from_motion_by_physics(recording: Recording) -> None:
    """tan(steering) = wheelbase x yaw rate / speed, recorded or derived; 0.9 m/s2 is 30 % of full throttle."""
    known = layouts.truth()
    angle = np.arctan(WHEELBASES_M[recording.layout] * known.yaw_rate_radps / known.speed_mps)
    assert recording.steering_rad[3:-3] == pytest.approx(angle[3:-3], rel=0.03)
    assert recording.throttle[3:-3] == pytest.approx(np.full(layouts.FRAMES - 6, 0.3), abs=0.01)


def test_every_signal_has_an_origin(recording: Recording) -> None:
    recorded = {name for name, origin in recording.origins.items() if origin.kind == "recorded"}
    assert recorded - {"lead_gap_m"} == RECORDED[recording.layout]
    for name in ("speed_mps", "yaw_rate_radps", "steering_rad", "throttle", "poses", "camera"):
        assert recording.origins[name].how, name
    assert "throttle" in recording.derived


def test_frames_match_the_camera(recording: Recording) -> None:
    frames = list(recording.frames())
    assert [frame.index for frame in frames] == list(range(layouts.FRAMES))
    assert not [frame.fault for frame in frames if frame.image is None]
    shapes = {frame.image.shape for frame in frames if frame.image is not None}
    assert shapes == {(recording.camera.height_px, recording.camera.width_px, 3)}


def test_kitti_raw_has_mounting_and_labels(tmp_path: Path) -> None:
    folder = layouts.kitti_raw(tmp_path / "day")
    layouts.tracklets(folder, ahead_m=20.0, left_m=1.0, first_frame=4, count=6)
    recording = readers.read(folder)
    assert recording.camera.pitch_rad == pytest.approx(0.02, abs=1e-6)
    assert recording.camera.fx_px == 80.0
    horizon = recording.camera.cy_px - 80.0 * np.tan(0.02)  # true focus of expansion by positions and angles
    assert recording.foe_px[1:] == pytest.approx(np.tile([48.5, horizon], (layouts.FRAMES - 1, 1)), abs=0.1)
    assert np.flatnonzero(recording.obstacle).tolist() == [4, 5, 6, 7, 8, 9]
    assert recording.lead_gap_m[4:10] == pytest.approx(np.full(6, 18.0))
    layouts.tracklets(folder, ahead_m=20.0, left_m=3.0, first_frame=4, count=6)  # in the next lane
    assert not readers.read(folder).obstacle.any()


def test_kitti_raw_undistorts_images_that_are_not_rectified(tmp_path: Path) -> None:
    folder = layouts.kitti_raw(tmp_path / "day")
    names = [f"{k:010d}.png" for k in range(layouts.FRAMES)]
    layouts.pictures(folder / "image_02" / "data", names, 100, 70)
    recording = readers.read(folder)
    assert (recording.camera.k1, recording.camera.k2, recording.camera.fx_px) == (0.0, 0.0, 90.0)
    layouts.pictures(folder / "image_02" / "data", names, 104, 72)
    with pytest.raises(InputError, match="expected images of 96 x 64 or 100 x 70 px by calib_cam_to_cam"):
        readers.read(folder)


def test_comma2k19_has_lead_gap_and_camera_path(tmp_path: Path) -> None:
    folder = layouts.comma2k19(tmp_path / "40", with_video=False)
    recording = readers.read(tmp_path)  # the route's folder with a single segment
    assert recording.name == "40"
    assert recording.lead_gap_m == pytest.approx(np.full(layouts.FRAMES, 30.0))  # not the one 3.5 m to the left
    assert recording.camera.pitch_rad == pytest.approx(0.03, abs=1e-3)
    straight = recording.camera.cy_px - 910.0 * np.tan(0.03)
    assert recording.foe_px[1:, 1] == pytest.approx(np.full(layouts.FRAMES - 1, straight), abs=1.0)
    assert "video.hevc is missing" in recording.no_images
    with pytest.raises(InputError, match="get it from the data set"):
        list(recording.frames())
    steering = recording.steering_rad.copy()
    values = np.load(folder / "processed_log" / "CAN" / "radar" / "value")
    values[:, 5] = 0x430  # a Honda's radar: another steering ratio
    with (folder / "processed_log" / "CAN" / "radar" / "value").open("wb") as stream:
        np.save(stream, values)
    assert readers.read(folder).steering_rad == pytest.approx(steering * 16.88 / 15.38)


def test_radiate_notes_an_inertial_unit_with_another_clock(tmp_path: Path) -> None:
    """With too few images for a speed, the drive is refused with the reason."""
    with pytest.raises(InputError, match=r"its clock is 64\.0 s off the camera's: not used"):
        readers.read(layouts.radiate(tmp_path / "fog_6_0", clock_off_s=64.0))


def test_radiate_removes_backward_times_and_reads_labels(tmp_path: Path) -> None:
    folder = layouts.radiate(tmp_path / "rain_4_0")
    lines = (folder / "zed_left.txt").read_text().splitlines()
    lines[10] = f"Frame: 000011 Time: {layouts.CLOCK_S + 0.1:.9f}"
    (folder / "zed_left.txt").write_text("\n".join(lines))
    layouts.radar_labels(folder, ahead_m=15.0, right_m=0.5, frames=6)
    recording = readers.read(folder)
    assert "zed_left.txt: 1 frames are removed, since their times run backward" in recording.notes
    assert len(recording) == layouts.FRAMES - 1
    assert recording.obstacle.tolist() == [float(time > 0.875) for time in recording.times_s]
    assert np.nanmedian(recording.lead_gap_m) == pytest.approx(15.0, abs=0.1)


def test_udacity_final_test_is_read_by_frame_id(tmp_path: Path) -> None:
    folder = layouts.udacity(tmp_path / "test")
    rows = [line.split(",") for line in (folder / "interpolated.csv").read_text().splitlines() if "center_" in line]
    (folder / "interpolated.csv").unlink()
    table = ["frame_id,steering_angle", *(f"{row[1]},{row[6]}" for row in rows)]
    (folder / "CH2_final_evaluation.csv").write_text("\n".join(table))
    recording = readers.read(folder)
    assert recording.steering_rad == pytest.approx(-np.array([float(row[6]) for row in rows]) / 14.8)
    assert recording.times_s == pytest.approx(layouts.truth().times_s)
    assert recording.origins["speed_mps"].how.startswith("from the road's flow")


def test_images_and_their_table_match_by_name(tmp_path: Path) -> None:
    """Rows and images are matched by name although their orders differ."""
    known = layouts.truth()
    names = [f"shot_{k}.jpg" for k in range(layouts.FRAMES)]
    layouts.pictures(tmp_path / "images", names)
    latitude, longitude = layouts.places(known.poses)
    rows = ["file,time_s,speed_mps,latitude_deg,longitude_deg,throttle_percent,brake_percent,yaw_rate_radps,obstacle"]
    for k in reversed(range(layouts.FRAMES)):
        place = f"{known.speed_mps[k]},{latitude[k]:.12f},{longitude[k]:.12f}"
        rows.append(f"{names[k]},{100.0 + known.times_s[k]},{place},40,15,{-known.yaw_rate_radps[k]},{int(k > 9)}")
    (tmp_path / "log.csv").write_text("\n".join(rows))
    signals = '[signals]\nfile = "log.csv"\nleft_is_positive = ["yaw_rate"]\n'
    (tmp_path / "drive.toml").write_text(f"schema = 1\n{signals}[camera]\npitch_deg = 0\nyaw_deg = 0\n")
    recording = readers.read(tmp_path)
    assert recording.times_s == pytest.approx(known.times_s)
    assert recording.yaw_rate_radps == pytest.approx(known.yaw_rate_radps)
    assert recording.poses[:, :2] == pytest.approx(known.poses[:, :2], abs=0.1)
    assert recording.throttle == pytest.approx(np.full(layouts.FRAMES, 0.25))
    assert np.flatnonzero(recording.obstacle)[0] == 10
    assert "60 deg across and 1.4 m above the road assumed" in recording.origins["camera"].how


def test_signal_gap_is_bridged_with_a_note_and_labels_stay_unknown(tmp_path: Path) -> None:
    folder = layouts.general(tmp_path / "drive")
    rows = (folder / "signals.csv").read_text().splitlines()
    for k in range(20, 50):  # 1.2 s
        time, _, _, turn, note = rows[k].split(",")
        rows[k] = f"{time},nan,,{turn},{note}"
    (folder / "signals.csv").write_text("\n".join(rows))
    recording = readers.read(folder)
    assert any(note.startswith("speed: ") and "values missing, interpolated" in note for note in recording.notes)
    assert recording.speed_mps == pytest.approx(layouts.truth().speed_mps, rel=1e-3)
    assert np.isnan(recording.steering_rad[10:16]).all()
    assert np.isfinite(recording.steering_rad[[0, -1]]).all()


def test_radiate_camera_file_is_read(tmp_path: Path) -> None:
    folder = layouts.radiate(tmp_path / "fog_6_0")
    values = {"fx": 300.5, "fy": 3.01e2, "cx": 330.0, "cy": 190.0, "k1": -0.1, "k2": 0.02, "k3": 0, "p1": 0, "p2": 0}
    rows = [
        "left_cam_calib:",
        *(f"    {key}: {value}" for key, value in values.items()),
        "right_cam_calib:",
        "    fx: 1",
    ]
    (folder / "calib.yaml").write_text("\n".join(rows))
    assert readers.read(folder).camera.fx_px == 300.5


SHARED = os.environ.get("VPF_SIM_SHARED")
needs_drives = pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")
DRIVES = Path(SHARED or "") / "drives"


@needs_drives
@pytest.mark.parametrize(
    ("name", "layout", "frames"),
    [
        ("kitti_vo_seq1", "KITTI odometry", 51),
        ("kitti_raw_leadcar", "KITTI raw with lidar odometry", 50),
        ("radiate_fog", "RADIATE", 25),
    ],
)
def test_shared_drives_are_read(name: str, layout: str, frames: int) -> None:
    recording = readers.read(DRIVES / name)
    assert (recording.layout, len(recording)) == (layout, frames)
    assert np.isfinite(recording.speed_mps).all()
    assert np.isfinite(recording.yaw_rate_radps).all()


@needs_drives
def test_lead_gap_matches_lidar_and_camera_matches_calibration() -> None:
    recording = readers.read(DRIVES / "kitti_raw_leadcar")
    assert recording.lead_gap_m[0] == pytest.approx(8.085 - 0.272, abs=1e-3)
    assert recording.obstacle.all()
    assert recording.camera.pitch_rad == pytest.approx(-0.01045, abs=1e-4)


def understeer(recording: Recording) -> tuple[float, float]:
    """Wheelbase, m, by speed x steering / yaw rate with a free steering offset, and the correlation."""
    around = np.ones(41) / 41.0
    turn = np.convolve(recording.yaw_rate_radps, around, "same")[60:-60]
    bent = np.convolve(recording.speed_mps * recording.steering_rad, around, "same")[60:-60]
    rows = np.stack([bent, recording.speed_mps[60:-60]], axis=1)
    slope = np.linalg.lstsq(rows, turn, rcond=None)[0]
    return float(1.0 / slope[0]), float(np.corrcoef(rows @ slope, turn)[0, 1])


@needs_drives
@pytest.mark.parametrize(("name", "wheelbase_m"), [("comma2k19_example", 2.65), ("udacity_hmb1", 2.85)])
def test_signals_agree_with_physics(name: str, wheelbase_m: float) -> None:
    """Signs agree, and the wheelbase is the car's plus its understeer."""
    recording = readers.read(DRIVES / name)
    seen_m, correlation = understeer(recording)
    assert correlation > 0.85
    # A car understeers: L + K v^2 with K = 0.002 to 0.005 s2/m, plus road bank and steering play.
    assert wheelbase_m < seen_m < wheelbase_m + 0.008 * float(np.mean(recording.speed_mps**2))
    along = np.hypot(*np.diff(recording.poses[::20, :2], axis=0).T).sum()
    assert along == pytest.approx(np.trapezoid(recording.speed_mps, recording.times_s), rel=0.02)
    assert np.ptp(recording.poses[:, 2] - unwrapped(_course(recording))) < 0.3
    assert recording.no_images


def _course(recording: Recording) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    north, east = (np.gradient(np.convolve(part, np.ones(21) / 21, "same")) for part in recording.poses[:, :2].T)
    course = np.arctan2(east, north)
    course[:25], course[-25:] = course[25], course[-26]
    return course


@needs_drives
@pytest.mark.slow
def test_bare_video_is_calibrated() -> None:
    recording = readers.read(DRIVES / "carnd_highway")
    horizon = recording.camera.cy_px - recording.camera.fy_px * np.tan(recording.camera.pitch_rad)
    assert horizon == pytest.approx(306.0, abs=8.0)  # where the lane's lines meet
    assert np.median(recording.speed_mps) == pytest.approx(
        25.3 * recording.camera.height_m / 1.18, rel=0.2
    )  # by its lane markings
    assert recording.origins["camera"].kind == "assumed"
    assert "field of view 60 deg across" in recording.origins["camera"].how


def test_recordings_page_names_every_key_and_column(tmp_path: Path) -> None:
    """The page's drive.toml is valid and has every key."""
    page = (Path(__file__).parents[2] / "docs" / "recordings.md").read_text()
    example = page.split("```toml")[1].split("```")[0]
    table = tomllib.loads(example)
    for section, config in (("", DriveFile), ("camera", CameraKeys), ("vehicle", VehicleKeys), ("signals", SignalKeys)):
        keys = set(table[section] if section else table)
        missing = {item.name for item in dataclasses.fields(config)} - keys - {"field_of_view_deg"}
        assert not missing, section
    assert "field_of_view_deg" in example
    layouts.video(tmp_path / "drive.mp4", [layouts.picture(k, 1280, 720) for k in range(6)])
    (tmp_path / "drive.toml").write_text(example)
    (tmp_path / "signals.csv").write_text("time_s,OBD speed\n0,36\n1,36\n")
    recording = readers.read(tmp_path)
    assert recording.speed_mps == pytest.approx(np.full(6, 10.0))
    assert recording.rate_hz == pytest.approx(30.0)
    for column in general_signals.KNOWN:
        assert f"`{column}`" in page, column
    for reader in readers.READERS:
        assert reader.LAYOUT in page or reader.LAYOUT == "video or images with drive.toml"
