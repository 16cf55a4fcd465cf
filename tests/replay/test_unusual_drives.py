"""Unusual drives (standing, cut, slow, short, portrait, dark, partly known) do not stop a replay."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import recorded_layouts as layouts
import rendered_drive as rendered

from vpf_sim import cli
from vpf_sim.replay import frame_table
from vpf_sim.types import Floats, Image

CAMERA = "[camera]\nfx_px = 320.0\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\nahead_of_rear_axle_m = 0.0\n"
STANDS, DRIVES = 6, 12  # frames
Drive = tuple[list[Image], Floats, float]  # images, speed m/s, frames a second


def driven(count: int = DRIVES, first: int = 0) -> list[Image]:
    images, _ = rendered.shots(np.inf, 2, 0.0, None, rendered.FRAMES)
    return list(images[first : first + count])


def speeds(count: int) -> Floats:
    return np.full(count, rendered.SPEED_MPS)


def standing_start() -> Drive:
    images = driven()
    return [images[0]] * STANDS + images, np.append(np.zeros(STANDS), speeds(DRIVES)), rendered.RATE_HZ


def standing_end() -> Drive:
    images = driven()
    return images + [images[-1]] * STANDS, np.append(speeds(DRIVES), np.zeros(STANDS)), rendered.RATE_HZ


def cut() -> Drive:
    return driven(6) + driven(6, 30), speeds(12), rendered.RATE_HZ


def ten_a_second() -> Drive:
    return driven(), speeds(DRIVES), 10.0


def short() -> Drive:
    return driven(3), speeds(3), rendered.RATE_HZ


def portrait() -> Drive:
    return [np.ascontiguousarray(image[:, 200:440]) for image in driven()], speeds(DRIVES), rendered.RATE_HZ


def black_part() -> Drive:
    images = driven()
    return [*images[:5], *[np.zeros_like(images[0])] * 4, *images[9:]], speeds(DRIVES), rendered.RATE_HZ


# By default one that starts at standstill; dark frames and partly known speed have their own tests.
OTHERS = (standing_end, cut, ten_a_second, short, portrait, black_part)
UNUSUAL = [standing_start, *(pytest.param(drive, marks=pytest.mark.slow) for drive in OTHERS)]


def replayed(drive: Drive, folder: Path, capsys: pytest.CaptureFixture[str], known: slice = slice(None)) -> Any:
    """Record and frames of a drive with a speed at some of its frames."""
    images, speed, rate_hz = drive
    folder.mkdir()
    layouts.video(folder / "drive.mp4", images, rate_hz)
    (folder / "drive.toml").write_text(f"schema = 1\n{CAMERA}")
    rows_known = list(enumerate(speed))[known]
    rows = "".join(f"{k / rate_hz:.4f},{value}\n" for k, value in rows_known)
    (folder / "signals.csv").write_text(f"time_s,speed_mps\n{rows}")
    out = folder.with_name("run")
    code = cli.run(["replay", str(folder), "--no-video", "--out", str(out), "--json"])
    said = capsys.readouterr()
    assert (code, said.err) == (0, "")
    (record,) = json.loads(said.out)["drives"]
    return record, frame_table.read(out / "frames" / f"{record['name']}.parquet")


@pytest.mark.parametrize("drive", UNUSUAL)
def test_every_frame_has_a_command(
    drive: Callable[[], Drive], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record, table = replayed(drive(), tmp_path / "drive", capsys)
    assert record["error"] is None
    assert len(table) == len(drive()[0])
    commands = np.stack([table.throttle, table.steering])
    assert np.isfinite(commands).all()
    assert np.abs(commands).max() <= 1.0


def test_dark_frames_are_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record, table = replayed(black_part(), tmp_path / "drive", capsys)
    assert record["accuracy"]["unseen"]["whole"] >= 4
    assert (record["held"] + record["gaps"]) >= 4
    assert np.ptp(table.steering[4:9]) == 0.0
    assert any("scored frames are unseen" in note for note in record["notes"])


@pytest.mark.parametrize("known", [slice(0, 3), pytest.param(slice(-3, None), marks=pytest.mark.slow)])
def test_partly_known_speed_is_bridged_with_a_note(
    known: slice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = driven(24), speeds(24), rendered.RATE_HZ
    record, table = replayed(drive, tmp_path / "drive", capsys, known)
    assert table.speed_mps == pytest.approx(speeds(24))
    missing = 24 - 3 - round(0.5 * rendered.RATE_HZ - 0.5)  # values hold half a second past a sample
    assert f"speed: {missing} of 24 values missing, interpolated" in record["notes"]
    assert any(note.startswith("throttle: scored in ") for note in record["notes"])
