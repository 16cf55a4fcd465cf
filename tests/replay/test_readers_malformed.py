"""Valid recordings with one defect each: one clear line, or a gap with a note."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim import cli
from vpf_sim.errors import InputError
from vpf_sim.replay import image_files, readers

Change = Callable[[Path], object]
WRITERS = {
    "kitti_raw": layouts.kitti_raw,
    "comma2k19": lambda folder: layouts.comma2k19(folder, with_video=False),
    "radiate": layouts.radiate,
    "udacity": layouts.udacity,
    "general": layouts.general,
    "kitti_odometry": layouts.kitti_odometry,
}


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive in each layout."""
    root = tmp_path_factory.mktemp("valid")
    for name, write in WRITERS.items():
        write(root / name)
    return root


def copied(valid: Path, name: str, tmp_path: Path) -> Path:
    """The drive's folder in a copy that may be changed."""
    shutil.copytree(valid / name, tmp_path / name)
    inside = {"kitti_raw": "2011_09_26_drive_0001_sync", "kitti_odometry": "sequences/03"}
    return tmp_path / name / inside.get(name, ".")


def write(name: str, text: str) -> Change:
    return lambda folder: (folder / name).write_text(text)


def drop(name: str) -> Change:
    return lambda folder: (folder / name).unlink()


def emptied(name: str) -> Change:
    return lambda folder: [file.unlink() for file in (folder / name).iterdir()]


def swap(name: str, old: str, new: str) -> Change:
    def change(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return change


def row(name: str, number: int, text: str) -> Change:
    def change(folder: Path) -> None:
        lines = (folder / name).read_text().splitlines()
        lines[number] = text
        (folder / name).write_text("\n".join(lines) + "\n")

    return change


def empty_column(name: str, number: int) -> Change:
    def change(folder: Path) -> None:
        header, *rows = (line.split(",") for line in (folder / name).read_text().splitlines())
        emptied = [[*cells[:number], "", *cells[number + 1 :]] for cells in rows]
        (folder / name).write_text("".join(",".join(cells) + "\n" for cells in [header, *emptied]))

    return change


def in_milliseconds(name: str) -> Change:
    """The times of a clock that counts them."""

    def change(folder: Path) -> None:
        header, *rows = (line.split(",") for line in (folder / name).read_text().splitlines())
        changed = [[f"{1e3 * float(time):.3f}", *cells] for time, *cells in rows]
        (folder / name).write_text("".join(",".join(cells) + "\n" for cells in [header, *changed]))

    return change


def shorter(name: str) -> Change:
    """The file without its second half."""

    def change(folder: Path) -> None:
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(content[: len(content) // 2])

    return change


def larger(name: str) -> Change:
    return lambda folder: layouts.pictures((folder / name).parent, [Path(name).name], 128, 80)


UDACITY_ROW = "1574859772100000000,1574859772100000000,640,480,center_camera,center/1574859772100000000.png"
CELLS = ",0.1,0,8,49,8,8"
POSES = "../../poses/03.txt"

FAULTS: dict[str, list[tuple[Change, str]]] = {
    "kitti_raw": [
        (drop("../calib_cam_to_cam.txt"), "expected calib_cam_to_cam.txt in it or one folder up, found none"),
        (swap("../calib_cam_to_cam.txt", "P_rect_02", "P_rect_09"), "expected P_rect_02, found no such row"),
        (row("image_02/timestamps.txt", 3, "noon"), "line 4: expected a time like 2011-09-26 13:02:25"),
        (
            row("image_02/timestamps.txt", 3, "2001-01-01 00:00:00.0"),
            "timestamps.txt: line 4: time: expected a time after that of line 3, got -",
        ),
        (shorter("image_02/timestamps.txt"), "timestamps.txt: expected 24 rows for 24 files, got 1"),
        (write("oxts/data/0000000003.txt", "1 2 3"), "0000000003.txt: expected 30 numbers, got 3"),
        (write("oxts/data/0000000003.txt", ""), "0000000003.txt: expected a line of 30 numbers"),
        (emptied("image_02/data"), "image_02/data: expected two"),
        (write("tracklet_labels.xml", "<a><b>"), "expected KITTI's tracklets, cannot be read: no element"),
        (larger("image_02/data/0000000005.png"), "expected an image of 96 x 64 px like the first, got 128 x 80"),
        (write("image_02/data/0000000005.png", "x"), "expected an image, got 1 bytes that do not decode"),
    ],
    "comma2k19": [
        (drop("global_pose/frame_times"), "frame_times: expected the frame_times of comma2k19, found no file"),
        (shorter("global_pose/frame_positions"), "frame_positions of comma2k19 as a .npy array, cannot be"),
        (shorter("processed_log/CAN/speed/t"), "expected the times of speed as a .npy array, cannot be read"),
    ],
    "radiate": [
        (row("zed_left.txt", 4, "5 0.4"), "zed_left.txt: line 5: expected 'Frame: 000001 Time: 15748"),
        (write("zed_left.txt", ""), "zed_left.txt: expected a line for each frame, found none"),
        (write("calib.yaml", "left_cam_calib:\n  fx: 1\n"), "left_cam_calib: expected numbers fy, cx, cy"),
        (write("meta.json", "{"), "meta.json: expected JSON, got: Expecting property name"),
        (write("GPS_IMU_Twist/000007.txt", "1,2,3\na,b\n"), "000007.txt: expected lines of three numbers"),
        (larger("zed_left/000009.png"), "000009.png: expected an image of 672 x 376 px like the first"),
    ],
    "udacity": [
        (swap("interpolated.csv", ",speed,", ",pace,"), "interpolated.csv: expected a column speed or speed_mps"),
        (row("interpolated.csv", 5, f"{UDACITY_ROW},0,0"), "interpolated.csv: line 6: expected 12 cells, got 8"),
        (row("interpolated.csv", 5, f"{UDACITY_ROW},left,0,8,49,8,8"), "angle: expected a number, got 'left'"),
        (
            row("interpolated.csv", 5, UDACITY_ROW.replace("2100000000,", "2.1,") + CELLS),
            "expected times in whole nanoseconds, got '1574859772.1'",
        ),
        (
            row("interpolated.csv", 5, UDACITY_ROW.replace("2100000000,", "1100000000,") + CELLS),
            "expected a time after",
        ),
    ],
    "general": [
        (write("drive.toml", "schema = "), "drive.toml: expected TOML, got: Invalid value"),
        (write("drive.toml", "frames = 'drive.mp4'"), "drive.toml: schema: expected a value, got none"),
        (swap("drive.toml", "height_m", "hieght_m"), "camera.hieght_m: unknown key, did you mean 'height_m'?"),
        (swap("drive.toml", "fx_px = 80.0", 'fx_px = "far"'), "camera.fx_px: expected a number, got 'far'"),
        (swap("drive.toml", "fx_px = 80.0", "fx_px = -1"), "camera.fx_px: expected 10 to 100000, got -1"),
        (swap("drive.toml", "[camera]", "[camera]\nfield_of_view_deg = 60"), "expected one of them, got both"),
        (
            swap("drive.toml", "[camera]", "[camera]\ncx_px = 640"),
            "expected the camera's axis within its image of 96 x 64",
        ),
        (swap("drive.toml", "pitch_deg = 2.0", "pitch_deg = -40"), "that sees the road, got the horizon at row 99 of"),
        (swap("drive.toml", "yaw_deg = 0.0", ""), "pitch_deg, yaw_deg: expected both or neither"),
        (swap("drive.toml", "[camera]", "[camera]\ndistortion = [1.0, 2.0, 3.0]"), "2, 4, 5 or 8 numbers, got 3"),
        (swap("drive.toml", "steering_ratio = 15.0", ""), "steering_wheel_deg: expected steering_ratio in drive"),
        (swap("drive.toml", 'speed_kmh = "v"', 'pace = "v"'), "signals.columns: unknown signal 'pace'; known: s"),
        (swap("drive.toml", 'speed_kmh = "v"', 'speed_kmh = "w"'), "expected a column 'w' for speed_kmh, found"),
        (swap("drive.toml", "schema = 1", 'schema = 1\nframes = "b.mp4"'), "frames: expected a video or a folder"),
        (swap("drive.toml", "schema = 1", "schema = 1\nrate_hz = 0"), "rate_hz: expected 0.2 to 1000, got 0"),
        (drop("signals.csv"), "signals.csv: expected signals, found no file"),
        (drop("drive.mp4"), "frames is not set: expected one video or folder of images, found none"),
        (shorter("drive.mp4"), "drive.mp4: expected a video, cannot be opened: Invalid data"),
        (swap("signals.csv", "time_s,", "clock,"), "signals.csv: expected a column 'time_s', found clock"),
        (
            row("signals.csv", 9, "0.1,1,2,3,x"),
            "signals.csv: line 10: time_s: expected a time after that of line 9, got -0.18",
        ),
        (row("signals.csv", 9, "0.32,fast,2,3,x"), "line 10: speed_kmh: expected a number, got 'fast'"),
        (swap("drive.toml", "[signals]", "[signals]\noffset_s = 1000.0"), "expected rows at the frames' times, 0 to"),
        (swap("signals.csv", ",note", ",speed_mps"), "expected one of the columns speed_mps, speed_kmh, sp"),
    ],
    "kitti_odometry": [
        (drop(POSES), "poses.txt: expected a pose of 12 numbers for each image"),
        (emptied("image_2"), "expected .png or .jpg images in one of image/, image_0/"),
        (drop("calib.txt"), "calib.txt: expected projections of 12 numbers, P0: first, found no file"),
        (write("calib.txt", "P0: 1 2 3"), "calib.txt: expected a row of 12 numbers (P0: of KITTI), found none"),
        (write("calib.txt", "P0: " + "0 " * 12), "calib.txt: expected focal lengths > 0, got 0 and 0"),
        (write("calib.txt", "P0: 1 x"), "calib.txt: line 1: expected numbers, got 'P0: 1 x'"),
        (row(POSES, 1, "1 2 3"), "03.txt: row 2: expected 12 numbers, got 3"),
        (row(POSES, 23, "nan " * 12), "03.txt: line 24: expected finite numbers"),
        (shorter(POSES), "03.txt: expected 24 rows for 24 images (or 23), got 1"),
        (write("times.txt", "0.0\n0.1"), "times.txt: expected 24 rows for 24 images, got 2"),
        (row("times.txt", 7, "0.3"), "times.txt: line 8: time: expected a time after that of line 7, got -0.3 s"),
    ],
}


@pytest.mark.parametrize(
    ("name", "change", "sentence"), [(name, *fault) for name, faults in FAULTS.items() for fault in faults]
)
def test_malformed_input_is_one_clear_line(
    name: str, change: Change, sentence: str, valid: Path, tmp_path: Path
) -> None:
    folder = copied(valid, name, tmp_path)
    change(folder)
    with pytest.raises(InputError) as caught:
        readers.read(folder)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "change", "note"),
    [
        ("radiate", drop("zed_left/000009.png"), "zed_left/: 1 of 24 images are missing"),
        ("comma2k19", lambda folder: shutil.rmtree(folder / "processed_log" / "CAN" / "radar"), "no radar to identify"),
        ("general", swap("signals.csv", "yaw_rate_degps", "yaw_rate_rpm"), "signals.csv: not used: yaw_rate_rpm, note"),
        ("general", empty_column("signals.csv", 3), "without a value: yaw_rate_degps"),
        ("general", in_milliseconds("signals.csv"), "signals.csv: a row every 40 s, interpolated: milliseconds?"),
        ("general", row("signals.csv", 30, "1.16,nan,nan,nan,x"), ""),  # a short gap is interpolated
    ],
)
def test_gap_has_a_note_and_the_rest_is_read(name: str, change: Change, note: str, valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, name, tmp_path)
    change(folder)
    recording = readers.read(folder)
    assert not note or any(note in one for one in recording.notes)
    assert np.isfinite(recording.speed_mps).all()
    assert np.isfinite(recording.poses).all()


def test_truncated_image_is_a_gap(valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, "kitti_raw", tmp_path)
    shorter("image_02/data/0000000005.png")(folder)
    frames = list(readers.read(folder).frames())
    assert [frame.index for frame in frames if frame.image is None] == [5]
    assert frames[5].fault == "0000000005.png: the file is truncated"


def test_images_that_are_all_truncated_are_refused(valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, "kitti_raw", tmp_path)
    for file in (folder / "image_02" / "data").iterdir():
        shorter(f"image_02/data/{file.name}")(folder)
    with pytest.raises(InputError, match="expected images that can be read, found none among"):
        readers.read(folder)


def test_jpeg_with_trailing_bytes_is_complete(tmp_path: Path) -> None:
    layouts.pictures(tmp_path, ["shot 2.JPG", "shot 10.JPG", "shot 1.JPG"])
    files = image_files.listed(tmp_path)
    assert [file.name for file in files] == ["shot 1.JPG", "shot 2.JPG", "shot 10.JPG"]
    (tmp_path / "._shot 3.JPG").write_bytes(b"of another system")
    files[0].write_bytes(files[0].read_bytes() + 500 * b"trailer ")
    files[1].write_bytes(files[1].read_bytes()[:-600])
    assert image_files.size(image_files.listed(tmp_path), tmp_path) == (96, 64)
    frames = list(image_files.frames(files, (96, 64)))
    assert [frame.fault for frame in frames] == ["", "shot 2.JPG: the file is truncated", ""]


def test_repeated_image_of_a_moving_car_is_a_gap(valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, "kitti_raw", tmp_path)
    pictures = folder / "image_02" / "data"
    shutil.copy(pictures / "0000000006.png", pictures / "0000000007.png")
    frames = list(readers.read(folder).frames())
    assert [frame.index for frame in frames if frame.image is None] == [7]
    assert frames[7].fault == "repeats the image before"
    for file in (folder / "oxts" / "data").iterdir():  # at standstill equal images are normal
        values = file.read_text().split()
        values[8] = "0.0"
        file.write_text(" ".join(values))
    assert all(frame.image is not None for frame in readers.read(folder).frames())


def test_blank_images_give_no_speed(valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, "general", tmp_path)
    layouts.video(folder / "drive.mp4", [np.full((64, 96, 3), 90 + k, np.uint8) for k in range(24)])
    (folder / "drive.toml").write_text(
        "schema = 1\nframes = 'drive.mp4'\n[signals]\nfile = 'empty.csv'\n[camera]\nheight_m = 1.4\n"
    )
    (folder / "empty.csv").write_text("time_s,speed_mps\n0,nan\n1,nan\n")
    with pytest.raises(InputError, match="general: expected a speed, or poses or images of a road to derive it from"):
        readers.read(folder)
    (folder / "empty.csv").write_text("time_s,speed_mps\n0,8\n3,8\n")
    recording = readers.read(folder)
    assert not recording.yaw_rate_radps.any()
    assert str(recording.origins["yaw_rate_radps"]) == "assumed: none: no signal yields it"


def test_missing_udacity_image_leaves_the_signals(valid: Path, tmp_path: Path) -> None:
    folder = copied(valid, "udacity", tmp_path)
    sorted((folder / "center").iterdir())[3].unlink()
    recording = readers.read(folder)
    assert "1 of 24 images are missing, the first is center/15748597723" in recording.no_images
    assert np.isfinite(recording.steering_rad).all()


def test_unknown_layout_lists_found_and_expected_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="found nothing; expected one of video or images with drive"):
        readers.read(tmp_path)
    (tmp_path / "note.txt").write_text("mine")
    with pytest.raises(InputError, match=r"found note\.txt; expected one of .*comma2k19 segment: video\.hevc"):
        readers.read(tmp_path)


def test_command_prints_malformed_input_in_one_line(
    valid: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(valid, "general", tmp_path)
    (folder / "signals.csv").unlink()
    assert cli.run(["replay", str(folder), "--driver", "neutral", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "signals.csv: expected signals, found no file" in said.err
    assert not list(tmp_path.glob("out/*/*")), "no partial table or video is left behind"
