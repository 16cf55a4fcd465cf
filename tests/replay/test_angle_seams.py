"""Angles across their seam (north, 180 degrees of longitude, half a turn) in every layout."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.geometry import unwrapped
from vpf_sim.replay import paths, readers, series
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Floats

DRIVE = "schema = 1\nrate_hz = 20.0\n[camera]\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\n"


def recorded(folder: Path, columns: dict[str, Floats], drive: str = DRIVE, frames: int = 100) -> Recording:
    """A drive of images at 20 Hz with a signal table."""
    layouts.pictures(folder / "frames", [f"{k:03d}.png" for k in range(frames)])
    rows = [
        ",".join(columns),
        *(",".join(f"{value:.12g}" for value in row) for row in zip(*columns.values(), strict=True)),
    ]
    (folder / "signals.csv").write_text("\n".join(rows) + "\n")
    (folder / "drive.toml").write_text(drive)
    return readers.read(folder)


def turning_right(seam_deg: float, lowest_deg: float) -> tuple[Floats, dict[str, Floats]]:
    """A 5 Hz table with a heading that grows by 2 deg/s and crosses the seam at 2.5 s, from `lowest_deg`."""
    time = np.arange(0.0, 5.1, 0.2)
    heading = np.radians(seam_deg - 5.0 + 2.0 * time)
    steps = 0.2 * 8.0 * np.stack([np.cos(heading), np.sin(heading)])
    x, y = np.cumsum(steps, axis=1)
    recorded_deg = (np.degrees(heading) - lowest_deg) % 360.0 + lowest_deg
    return heading, {"time_s": time, "speed_mps": np.full(len(time), 8.0), "x_m": x, "y_m": y, "yaw_deg": recorded_deg}


@pytest.mark.parametrize(("seam_deg", "lowest_deg"), [(360.0, 0.0), (180.0, -180.0), (0.0, -360.0), (90.0, -270.0)])
@pytest.mark.parametrize("left", [False, True])
def test_yaw_is_interpolated_across_its_seam(seam_deg: float, lowest_deg: float, left: bool, tmp_path: Path) -> None:
    _, columns = turning_right(seam_deg, lowest_deg)
    drive = DRIVE
    if left:
        columns |= {"y_m": -columns["y_m"], "yaw_deg": -columns["yaw_deg"]}
        drive += '[signals]\nleft_is_positive = ["yaw", "y"]\n'
    recording = recorded(tmp_path, columns, drive)
    assert np.degrees(recording.poses[:, 2]) == pytest.approx(2.0 * recording.times_s, abs=1e-6)
    assert np.degrees(recording.yaw_rate_radps) == pytest.approx(np.full(100, 2.0), abs=1e-6)


def test_heading_gap_is_interpolated_the_shorter_way(tmp_path: Path) -> None:
    _, columns = turning_right(360.0, 0.0)
    columns["yaw_deg"][8:18] = np.nan  # 2 s about north
    recording = recorded(tmp_path, columns)
    assert np.degrees(recording.poses[:, 2]) == pytest.approx(2.0 * recording.times_s, abs=1e-6)
    assert any(note.startswith("pose: ") for note in recording.notes)


def test_drive_across_180_degrees_longitude_is_continuous(tmp_path: Path) -> None:
    time = np.arange(0.0, 5.1, 0.2)
    degrees = 8.0 * (time - 2.5) / (paths.EARTH_RADIUS_M * np.pi / 180.0)  # east along the equator's parallel
    longitude = (180.0 + degrees + 180.0) % 360.0 - 180.0
    recording = recorded(
        tmp_path, {"time_s": time, "latitude_deg": np.full(len(time), 1e-4), "longitude_deg": longitude}
    )
    assert recording.speed_mps == pytest.approx(np.full(100, 8.0), abs=1e-3)
    assert recording.poses[-1, :2] == pytest.approx([8.0 * recording.times_s[-1], 0.0], abs=1e-3)


SEAMS = [(-1.0, 8.4), (179.0, 8.4), (89.0, 8.4), (80.0, 179.99995)]  # course and longitude at the start, deg
CASES = [(layout, *seam) for layout in ("kitti_raw", "comma2k19") for seam in SEAMS]
CASES += [(layout, *SEAMS[-1]) for layout in ("radiate", "udacity")]


@pytest.mark.parametrize(("layout", "course_deg", "longitude_deg"), CASES)
def test_every_layout_is_independent_of_the_initial_heading(
    layout: str, course_deg: float, longitude_deg: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same path, started shortly before a seam of the heading or the 180th meridian."""
    monkeypatch.setattr(layouts, "COURSE_RAD", np.radians(course_deg))
    monkeypatch.setattr(layouts, "LONGITUDE_DEG", longitude_deg)
    write = {"comma2k19": lambda folder: layouts.comma2k19(folder, with_video=False)}
    folder = write.get(layout, getattr(layouts, layout))(tmp_path / "drive")
    if layout == "udacity":
        shutil.rmtree(folder / "center")  # the signals are enough
    recording, known = readers.read(folder), layouts.truth()
    assert recording.poses[:, :2] == pytest.approx(known.poses[:, :2], abs=0.15)
    turned = recording.poses[:, 2] - recording.poses[0, 2]
    assert turned[5:-5] == pytest.approx(known.poses[5:-5, 2], abs=0.06)


def test_angle_is_interpolated_and_filled_the_shorter_way() -> None:
    times, angles = np.array([0.0, 1.0, 2.0]), np.array([350.0, np.nan, 20.0])
    assert series.at(np.array([0.5, 1.5]), times[[0, 2]], angles[[0, 2]], 360.0) == pytest.approx([357.5, 372.5])
    assert series.filled(times, angles, 360.0)[0] == pytest.approx([350.0, 365.0, 380.0])


def test_unknown_angles_do_not_hide_later_turns() -> None:
    found = unwrapped([3.0, np.nan, -3.0, 3.1])
    assert np.isnan(found[1])
    assert np.abs(np.diff(found[[0, 2, 3]])).max() < np.pi
    assert np.cos(found[[0, 2, 3]]) == pytest.approx(np.cos([3.0, -3.0, 3.1]))
