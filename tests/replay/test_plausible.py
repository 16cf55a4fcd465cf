"""Impossible values are removed with a note, or refused with file, row, column, expected and actual."""

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.errors import InputError
from vpf_sim.replay import consistency, image_files, plausible, readers
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Floats

FRAMES, RATE_HZ, SPEED_MPS, TURN_RADPS = 40, 20.0, 8.0, 0.1
DRIVE = f"schema = 1\nrate_hz = {RATE_HZ}\n[camera]\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\n"
Columns = dict[str, Floats]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive of images; each test writes its own table."""
    path = tmp_path_factory.mktemp("drive")
    layouts.pictures(path / "frames", [f"{k:03d}.png" for k in range(FRAMES)])
    (path / "drive.toml").write_text(DRIVE)
    return path


def driven() -> Columns:
    """A consistent table of a right bend at constant speed, with all signals at 10 Hz."""
    time = np.arange(0.0, FRAMES / RATE_HZ, 0.1)
    yaw, steady = TURN_RADPS * time, np.ones(len(time))
    north, east = SPEED_MPS / TURN_RADPS * np.sin(yaw), SPEED_MPS / TURN_RADPS * (1.0 - np.cos(yaw))
    return {
        "time_s": time,
        "speed_mps": SPEED_MPS * steady,
        "yaw_rate_radps": TURN_RADPS * steady,
        "steering_rad": np.arctan(2.7 * TURN_RADPS / SPEED_MPS) * steady,
        "acceleration_mps2": 0.0 * steady,
        "x_m": north,
        "y_m": east,
        "yaw_rad": yaw,
        "lead_gap_m": 30.0 * steady,
    }


def with_positions(columns: Columns) -> Columns:
    """The same by latitude and longitude."""
    kept = {name: values for name, values in columns.items() if name not in ("x_m", "y_m", "yaw_rad")}
    degree_m = 6378137.0 * np.pi / 180.0
    latitude = 48.0 + columns["x_m"] / degree_m
    return kept | {"latitude_deg": latitude, "longitude_deg": 11.0 + columns["y_m"] / degree_m / np.cos(np.radians(48))}


def read(folder: Path, columns: Columns) -> Recording:
    rows = [",".join(columns), *(",".join(f"{v:.12g}" for v in row) for row in zip(*columns.values(), strict=True))]
    (folder / "signals.csv").write_text("\n".join(rows) + "\n")
    return readers.read(folder)


def test_consistent_drive_has_no_notes(folder: Path) -> None:
    assert read(folder, driven()).notes == ()
    assert read(folder, with_positions(driven())).notes == ()


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("speed_mps", 6553.5, "-20 to 100"),
        ("speed_mps", np.inf, "-20 to 100"),
        ("yaw_rate_radps", -40.0, "-3 to 3"),
        ("steering_rad", 9.0, "-1.4 to 1.4"),
        ("acceleration_mps2", 327.67, "-20 to 20"),
        ("yaw_rad", 1e9, "-130 to 130"),
        ("lead_gap_m", 4095.0, "-5 to 1000"),
    ],
)
def test_few_impossible_values_become_gaps_with_a_note(folder: Path, column: str, value: float, expected: str) -> None:
    columns = driven()
    columns[column][[5, 6]] = value
    recording = read(folder, columns)
    assert (
        f"signals.csv: {column}: 2 of 20 values removed: expected {expected}, got {value:.6g} in line 7"
        in recording.notes
    )
    assert recording.speed_mps == pytest.approx(np.full(FRAMES, SPEED_MPS))
    assert recording.yaw_rate_radps == pytest.approx(np.full(FRAMES, TURN_RADPS))


@pytest.mark.parametrize("column", ["speed_mps", "yaw_rate_radps", "steering_rad", "acceleration_mps2", "yaw_rad"])
def test_column_of_impossible_values_is_refused(folder: Path, column: str) -> None:
    columns = driven()
    columns[column] = columns[column] + 500.0
    with pytest.raises(InputError, match=rf"signals\.csv: line 2: {column}: expected .* to .*, got 50.*, and 20 of 20"):
        read(folder, columns)


@pytest.mark.parametrize(("latitude", "longitude"), [(0.0, 0.0), (48.5, 11.0), (np.nan, np.nan)])
def test_positions_before_the_first_fix_are_removed(folder: Path, latitude: float, longitude: float) -> None:
    """Positions before the fix are empty, 0 or old; there the motion gives the path."""
    columns = with_positions(driven())
    del columns["speed_mps"]
    columns["latitude_deg"][:6], columns["longitude_deg"][:6] = latitude, longitude
    recording = read(folder, columns)
    assert recording.speed_mps == pytest.approx(np.full(FRAMES, SPEED_MPS), rel=0.01)
    assert recording.poses[-1, 0] == pytest.approx(SPEED_MPS * recording.times_s[-1], rel=0.05)
    assert any("removed" in note or note.startswith("pose: ") for note in recording.notes)


def test_unreachable_position_is_removed_and_half_of_them_refused(folder: Path) -> None:
    columns = driven()
    columns["x_m"][7] += 4e4
    recording = read(folder, columns)
    assert any(
        "x_m: 1 of 20 positions removed, the first in line 9: 40 km from line 8 within 0.1 s" in note
        for note in recording.notes
    )
    assert np.abs(np.diff(recording.poses[:, 0])).max() < 1.0
    columns = driven()
    columns["x_m"] += 1e4 * np.arange(20)
    with pytest.raises(InputError, match="expected a position that a car can reach"):
        read(folder, columns)


def in_kmh(columns: Columns) -> Columns:
    return columns | {"speed_mps": 3.6 * columns["speed_mps"]}


def swapped(columns: Columns) -> Columns:
    """Swapped latitude and longitude mirror the path."""
    place = with_positions(columns)
    return place | {"latitude_deg": place["longitude_deg"], "longitude_deg": place["latitude_deg"]}


def in_degrees(name: str) -> Callable[[Columns], Columns]:
    return lambda columns: columns | {name: np.degrees(columns[name])}


def mirrored(name: str) -> Callable[[Columns], Columns]:
    return lambda columns: columns | {name: -columns[name]}


@pytest.mark.parametrize(
    ("change", "note"),
    [
        (in_kmh, "speed and positions disagree: .*: km/h"),
        (lambda columns: in_kmh(with_positions(columns)), "speed and positions disagree: .*: km/h"),
        (swapped, "turn opposite ways .* latitude and longitude"),
        (in_degrees("yaw_rad"), "the heading is .* deg off the course|speed and yaw rate ask|a wrong unit"),
        (mirrored("yaw_rate_radps"), "the yaw rate and the steering turn opposite ways"),
        (mirrored("steering_rad"), "the yaw rate and the steering turn opposite ways"),
        (mirrored("yaw_rad"), "the yaw rate and the heading turn opposite ways"),
        (lambda columns: columns | {"yaw_rad": columns["yaw_rad"] + 1.5}, "the heading is 86 deg off the course"),
        (lambda columns: columns | {"yaw_rate_radps": columns["yaw_rate_radps"] * 25}, "need up to 20 m/s2"),
    ],
)
def test_contradicting_signals_have_a_note(folder: Path, change: Callable[[Columns], Columns], note: str) -> None:
    recording = read(folder, change(driven()))
    assert re.search(note, "\n".join(recording.notes)), recording.notes


@pytest.mark.parametrize(("scale", "clock"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_image_times_in_another_unit_are_refused(scale: float, clock: str, tmp_path: Path) -> None:
    names = [f"{k}.png" for k in range(5)]
    layouts.pictures(tmp_path / "frames", names)
    (tmp_path / "drive.toml").write_text("schema = 1\n[camera]\npitch_deg = 0\nyaw_deg = 0\n")
    rows = [f"{name},{0.05 * scale * k:.0f},8.0,0.1" for k, name in enumerate(names)]
    (tmp_path / "signals.csv").write_text("\n".join(["file,time_s,speed_mps,yaw_rate_radps", *rows]))
    with pytest.raises(InputError, match=rf"expected one every 0\.001 to 5 s, got .* s: {clock}\?"):
        readers.read(tmp_path)


def test_missing_image_numbers_are_gaps_at_their_times(tmp_path: Path) -> None:
    names = [f"frame_{k:06d}.jpg" for k in range(100, 160, 2) if not 120 <= k < 130]
    layouts.pictures(tmp_path / "frames", names)
    (tmp_path / "drive.toml").write_text(DRIVE + "[signals]\n")
    (tmp_path / "signals.csv").write_text("time_s,speed_mps,yaw_rate_radps\n0,8,0\n2,8,0\n")
    recording = readers.read(tmp_path)
    assert recording.times_s == pytest.approx(np.arange(30) / RATE_HZ)
    assert [frame.index for frame in recording.frames() if frame.image is None] == [10, 11, 12, 13, 14]
    between = "frame_000118.jpg and frame_000130.jpg"
    expected = f"frames/: 5 of 30 images are missing by their numbers, the first between {between}"
    assert expected in recording.notes


@pytest.mark.parametrize(
    ("names", "steps"),
    [
        (["a1.png", "a2.png", "a4.png"], [0, 1, 3]),
        (["a005.png", "a010.png", "a015.png", "a025.png"], [0, 1, 2, 4]),
        (["a1.png", "b7.png", "c9.png"], [0, 1, 2]),  # several numbers vary
        (["1.png", "2.png", "900000.png"], [0, 1, 2]),  # not counting
        (["1574859772100.png", "1574859772151.png", "1574859772199.png"], [0, 1, 2]),  # times
    ],
)
def test_image_numbers_give_steps_where_they_count(names: list[str], steps: list[int]) -> None:
    assert image_files.steps([Path(name) for name in names]).tolist() == steps


def test_duplicate_image_number_is_refused() -> None:
    with pytest.raises(InputError, match=r"f01\.png: expected one image of this number, found also f1\.jpg"):
        image_files.steps([Path("f1.jpg"), Path("f01.png"), Path("f2.jpg")])


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_images_of_16_bits_are_scaled_by_used_bits(bits: int, channels: int, tmp_path: Path) -> None:
    """12 bits of a camera in a 16-bit file would be black without scaling."""
    picture = layouts.picture(1)
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    shown = np.stack([grey] * 3, axis=2)
    deep = (shown.astype(np.uint16) << (bits - 8))[..., :1] if channels == 1 else shown.astype(np.uint16) << (bits - 8)
    if channels == 4:
        deep = np.dstack([deep, np.full(grey.shape, (1 << 16) - 1, np.uint16)])
    for name in ("1.png", "2.png"):
        cv2.imwrite(str(tmp_path / name), deep)
    files = image_files.listed(tmp_path)
    assert image_files.used_bits(files) == bits
    for frame in image_files.frames(files, (96, 64)):
        assert frame.image is not None
        assert np.array_equal(frame.image, shown)


@pytest.mark.parametrize(("level", "note"), [(3, "nearly black"), (250, "nearly white")])
def test_black_or_white_images_are_noted_and_blank_ones_are_gaps(level: int, note: str, tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    for k in range(4):
        image = np.full((64, 96, 3), level, np.uint8)
        if k:
            image[::8, :40] += 6 - level // 50  # faint content
        cv2.imwrite(str(tmp_path / "frames" / f"{k}.png"), image)
    (tmp_path / "drive.toml").write_text(DRIVE)
    (tmp_path / "signals.csv").write_text("time_s,speed_mps,yaw_rate_radps\n0,0,0\n2,0,0\n")
    recording = readers.read(tmp_path)
    assert any(note in expected for expected in recording.notes)
    frames = list(recording.frames())
    assert frames[0].fault == "frame 0: blank image"


def test_recordings_page_states_each_signal_limit() -> None:
    page = (Path(__file__).parents[2] / "docs" / "recordings.md").read_text()
    for name in ("speed_mps", "yaw_rate_radps", "steering_rad", "acceleration_mps2"):
        limit = plausible.LIMITS[name]
        assert f"{limit.lowest:g} to {limit.highest:g}" in page, name
    assert f"{consistency.MOST_ACCELERATION_MPS2:g} m/s2" in page
