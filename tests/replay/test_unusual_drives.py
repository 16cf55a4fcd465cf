"""Unusual drives (standing, cut, slow, short, portrait, dark, partly known) do not stop a replay."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import recorded_layouts as layouts
import rendered_drive as rendered

from vpf_sim import cli
from vpf_sim.replay import frame_table, readers
from vpf_sim.types import Floats, Image

CAMERA = "[camera]\nfx_px = 320.0\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\nahead_of_rear_axle_m = 0.0\n"
STANDS = 6  # frames
SECONDS = 20.0  # of a recording


class Drive(NamedTuple):
    """What a camera and a speedometer recorded."""

    images: list[Image]
    speed_mps: Floats  # nan: not known
    rate_hz: float
    camera: str = CAMERA  # of drive.toml


def rendered_drive(count: int = 12, first: int = 0) -> Drive:
    images, _ = rendered.shots(np.inf, 2, 0.0, None, rendered.FRAMES)
    return Drive(list(images[first : first + count]), np.full(count, rendered.SPEED_MPS), rendered.RATE_HZ)


def recorded_drive(name: str) -> Drive:
    """The first seconds of a recorded drive, less the frames without an image."""
    found = readers.read(Path(os.environ["VPF_SIM_SHARED"]) / "drives" / name)
    frames = [frame for frame in found.frames() if frame.image is not None and found.times_s[frame.index] < SECONDS]
    images = [frame.image[: frame.image.shape[0] // 2 * 2, : frame.image.shape[1] // 2 * 2] for frame in frames]
    speed_mps = found.speed_mps[[frame.index for frame in frames]]
    focal = f"[camera]\nfx_px = {found.camera.fx_px}\nheight_m = {found.camera.height_m}\n"
    return Drive(images, speed_mps, found.rate_hz, focal)


def as_recorded(drive: Drive) -> Drive:
    return drive


def standing_start(drive: Drive) -> Drive:
    speed_mps = np.append(np.zeros(STANDS), drive.speed_mps)
    return drive._replace(images=[drive.images[0]] * STANDS + drive.images, speed_mps=speed_mps)


def standing_end(drive: Drive) -> Drive:
    speed_mps = np.append(drive.speed_mps, np.zeros(STANDS))
    return drive._replace(images=drive.images + [drive.images[-1]] * STANDS, speed_mps=speed_mps)


def cut(drive: Drive) -> Drive:
    """Its second half comes first."""
    half = len(drive.images) // 2
    speed_mps = np.append(drive.speed_mps[half:], drive.speed_mps[:half])
    return drive._replace(images=drive.images[half:] + drive.images[:half], speed_mps=speed_mps)


def ten_a_second(drive: Drive) -> Drive:
    every = max(1, round(drive.rate_hz / 10.0))
    return drive._replace(images=drive.images[::every], speed_mps=drive.speed_mps[::every], rate_hz=10.0)


def short(drive: Drive) -> Drive:
    count = 3 if len(drive.images) < 20 else round(4.0 * drive.rate_hz)
    return drive._replace(images=drive.images[:count], speed_mps=drive.speed_mps[:count])


def portrait(drive: Drive) -> Drive:
    height, width = drive.images[0].shape[:2]
    left = (width - height // 4 * 2) // 2
    return drive._replace(images=[np.ascontiguousarray(image[:, left : width - left]) for image in drive.images])


def black_part(drive: Drive) -> Drive:
    black = [np.zeros_like(drive.images[0])] * 4
    return drive._replace(images=[*drive.images[:5], *black, *drive.images[9:]])


def speed_in_part(drive: Drive) -> Drive:
    speed_mps = drive.speed_mps.copy()
    speed_mps[len(speed_mps) // 3 : 2 * len(speed_mps) // 3] = np.nan
    return drive._replace(speed_mps=speed_mps)


# By default one that starts at standstill; dark frames and partly known speed have their own tests.
OTHERS = (standing_end, cut, ten_a_second, short, portrait, black_part)
UNUSUAL = [standing_start, *(pytest.param(change, marks=pytest.mark.slow) for change in OTHERS)]
RECORDED = ("carnd_highway", "kitti_vo_seq1", "kitti_raw_leadcar", "radiate_fog")


def replayed(drive: Drive, folder: Path, capsys: pytest.CaptureFixture[str]) -> Any:
    """Record and frames of a drive that is written as a film and a table of its known speeds."""
    folder.mkdir()
    layouts.video(folder / "drive.mp4", drive.images, drive.rate_hz)
    (folder / "drive.toml").write_text(f"schema = 1\n{drive.camera}")
    known = [(k, value) for k, value in enumerate(drive.speed_mps) if np.isfinite(value)]
    rows = "".join(f"{k / drive.rate_hz:.4f},{value}\n" for k, value in known)
    (folder / "signals.csv").write_text(f"time_s,speed_mps\n{rows}")
    out = folder.with_name("run")
    code = cli.run(["replay", str(folder), "--no-video", "--out", str(out), "--json"])
    said = capsys.readouterr()
    assert (code, said.err) == (0, "")
    (record,) = json.loads(said.out)["drives"]
    return record, frame_table.read(out / "frames" / f"{record['name']}.parquet")


def frames_with_commands(record: Any, table: frame_table.FrameTable) -> int:
    """The number of frames with a finite command within its limits, of a drive that did not fail."""
    assert record["error"] is None
    commands = np.stack([table.throttle, table.steering])
    return int(np.count_nonzero(np.all(np.abs(commands) <= 1.0, axis=0)))


@pytest.mark.parametrize("change", UNUSUAL)
def test_every_frame_has_a_command(
    change: Callable[[Drive], Drive], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = change(rendered_drive())
    record, table = replayed(drive, tmp_path / "drive", capsys)
    assert len(table) == frames_with_commands(record, table) == len(drive.images)


@pytest.mark.slow
@pytest.mark.skipif("VPF_SIM_SHARED" not in os.environ, reason="needs the recorded drives; set VPF_SIM_SHARED")
@pytest.mark.parametrize("change", [as_recorded, standing_start, *OTHERS, speed_in_part])
@pytest.mark.parametrize("name", RECORDED)
def test_every_frame_of_a_recording_has_a_command_and_doubts_are_stated(
    name: str, change: Callable[[Drive], Drive], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = change(recorded_drive(name))
    record, table = replayed(drive, tmp_path / "drive", capsys)
    assert len(table) == frames_with_commands(record, table) == len(drive.images)
    doubts = dict(record["warnings"])
    if record["perception"]["road_found_share"] < 0.9:
        assert "lane" in doubts
    for angle in ("pitch", "yaw"):
        found = (record["mounting"] or {}).get(angle)
        assert found is None or found["used"] or "mounting" in doubts


def test_dark_frames_are_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record, table = replayed(black_part(rendered_drive()), tmp_path / "drive", capsys)
    assert record["accuracy"]["unseen"]["whole"] >= 4
    assert (record["held"] + record["gaps"]) >= 4
    assert np.ptp(table.steering[4:9]) == 0.0
    assert any("scored frames are unseen" in note for note in record["notes"])


@pytest.mark.parametrize("known", [slice(0, 3), pytest.param(slice(-3, None), marks=pytest.mark.slow)])
def test_partly_known_speed_is_bridged_with_a_note(
    known: slice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = rendered_drive(24)
    speed_mps = np.full(24, np.nan)
    speed_mps[known] = drive.speed_mps[known]
    record, table = replayed(drive._replace(speed_mps=speed_mps), tmp_path / "drive", capsys)
    assert table.speed_mps == pytest.approx(drive.speed_mps)
    missing = 24 - 3 - round(0.5 * rendered.RATE_HZ - 0.5)  # values hold half a second past a sample
    assert f"speed: {missing} of 24 values missing, interpolated" in record["notes"]
    assert any(note.startswith("throttle: scored in ") for note in record["notes"])
