"""Recorded drives: a generated street of known motion, the shared recording, and broken drives."""

import json
import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import recorded_street as street

from vpf_sim import cli
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.errors import InputError
from vpf_sim.replay import frame_table, open_loop, paths, readers
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Camera, Floats

SPEED_MPS, YAW_RATE = 8.0, 0.25
FRAMES = 14


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bend, by a camera with pitch and pitching; one pose fewer than images."""
    folder = tmp_path_factory.mktemp("drives") / "bend"
    street.write(folder, street.poses(FRAMES - 1, SPEED_MPS, YAW_RATE, 0.03, 0.002), FRAMES)
    return folder


def replayed(recording: Recording, driver: str, out: Path) -> dict[str, Any]:
    """The record as it is stored."""
    record, _ = open_loop.run(recording, driver, out)
    return record.as_json()


def test_recording_has_the_driven_motion(drive: Path) -> None:
    recording = readers.read(drive)
    assert (recording.name, len(recording), recording.rate_hz) == ("bend", FRAMES, pytest.approx(10.0))
    assert recording.speed_mps == pytest.approx(np.full(FRAMES, SPEED_MPS), rel=1e-3)
    assert recording.yaw_rate_radps == pytest.approx(np.full(FRAMES, YAW_RATE), rel=1e-3)
    turned = YAW_RATE * (FRAMES - 1) / 10.0  # along an arc to the right, in our axes
    radius = SPEED_MPS / YAW_RATE
    assert recording.poses[-1] == pytest.approx(
        [radius * np.sin(turned), radius * (1.0 - np.cos(turned)), turned], abs=0.01
    )
    assert recording.camera.pitch_rad == pytest.approx(0.03, abs=1e-3)
    assert recording.camera.fx_px == 300.0
    assert sum(1 for _ in recording.frames()) == FRAMES


def test_true_foe_is_the_direction_of_motion(drive: Path) -> None:
    recording = readers.read(drive)
    # Steady turning: at each frame the camera moves along its own vertical plane, up by the mounting pitch.
    assert np.nanmax(np.abs(recording.foe_px[:, 0] - street.CENTRE[0])) < 0.1
    assert np.nanmedian(recording.foe_px[:, 1]) == pytest.approx(street.CENTRE[1] - 300.0 * np.tan(0.03), abs=0.3)
    assert np.isnan(recording.foe_px[[0, -1]]).all()  # nothing before the first, no pose at the last
    assert np.isfinite(recording.foe_px[1:-1]).all()


def test_replay_writes_error_table_and_video(drive: Path, tmp_path: Path) -> None:
    entry = replayed(readers.read(drive), "vpf", tmp_path)
    assert entry["frames"] == FRAMES
    assert set(entry["accuracy"]) >= {"throttle", "steering"}  # against those derived from the poses
    assert {"throttle", "steering_rad"} <= set(entry["derived"])
    assert "speed_mps" in entry["derived"]
    for axis in ("x", "y"):
        # Half the rotation of an interval would be 3.7 px, all of it 7.5 px.
        assert entry["foe_median_error_px"][axis] < 2.5
        assert entry["foe_median_error_own_derotation_px"][axis] < 5.0
    table = frame_table.read(tmp_path / "frames" / "bend.parquet")
    assert len(table) == FRAMES
    assert np.abs(table.steering).max() <= 1.0
    with av.open(str(tmp_path / "videos" / "bend.mp4")) as video:
        assert sum(1 for _ in video.decode(video=0)) == FRAMES


def test_route_baseline_follows_the_driven_path(drive: Path, tmp_path: Path) -> None:
    entry = replayed(readers.read(drive), "pid", tmp_path)
    assert entry["foe_median_error_px"] is None  # it uses no images
    assert np.median(frame_table.read(tmp_path / "frames" / "bend.parquet").steering) > 0.0  # the bend goes right


def test_command_prints_one_json_object(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = cli.run(["replay", str(drive), str(drive), "--driver", "neutral", "--out", str(tmp_path / "out"), "--json"])
    assert code == 0
    result = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in result["drives"]] == ["bend", "bend-2"]
    for folder, suffix in (("frames", "parquet"), ("videos", "mp4")):
        written = sorted(path.name for path in (tmp_path / "out" / folder).iterdir())
        assert written == [f"bend-2.{suffix}", f"bend.{suffix}"]


class Clumsy:
    """A driver that raises on its third frame."""

    privileged = "none"

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        self.frames = 0

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        self.frames += 1
        if self.frames == 3:
            raise RuntimeError("no idea")
        return Command(0.0, 0.0)


def test_failing_driver_keeps_earlier_frames_and_other_drives(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    driver, out = f"{__name__}:Clumsy", tmp_path / "out"
    command = ["replay", str(drive), str(drive), "--driver", driver, "--out", str(out), "--json"]
    assert cli.run(command) == 1
    said = capsys.readouterr()
    line = next(k for k, text in enumerate(Path(__file__).read_text().splitlines(), 1) if 'RuntimeError("no' in text)
    where = f"{__name__}:{line} in act"
    of_both = [
        f"vpf-sim: {name}: error: frame 2 of {FRAMES}, at {where}: RuntimeError: no idea; "
        "the frames before it are stored"
        for name in ("bend", "bend-2")
    ]
    assert said.err.splitlines() == of_both
    result = json.loads(said.out)
    for record in result["drives"]:
        assert record["error"] == {"frame": 2, "place": where, "what": "RuntimeError: no idea"}
        assert record["frames"] == 2
        table = frame_table.read(out / "frames" / f"{record['name']}.parquet")
        assert table.steering.tolist() == [0.0, 0.0]
        with av.open(str(out / "videos" / f"{record['name']}.mp4")) as video:
            assert sum(1 for _ in video.decode(video=0)) == 2
    assert all(row["drives"] == [] for row in result["rows"]), "an incomplete drive is not scored"
    assert f"the driver failed at frame 2, at {where}" in " ".join((out / "report.html").read_text().split())
    assert cli.run([*command, "--resume"]) == 1


class Hopeless(Clumsy):
    """A driver that raises at once."""

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        raise SystemExit(0)


def test_driver_that_fails_at_once_leaves_an_empty_drive(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    driver = f"{__name__}:Hopeless"
    assert cli.run(["replay", str(drive), "--driver", driver, "--out", str(tmp_path / "out"), "--json"]) == 1
    said = capsys.readouterr()
    assert "SystemExit" in said.err
    (record,) = json.loads(said.out)["drives"]
    assert (record["frames"], record["error"]["what"], record["accuracy"]) == (0, "SystemExit: 0", None)


def test_path_continues_past_a_missing_last_pose() -> None:
    known = street.poses(5, SPEED_MPS, YAW_RATE, 0.0, 0.0)
    longer = paths.extended(known, 6)
    assert longer[5] == pytest.approx(street.poses(6, SPEED_MPS, YAW_RATE, 0.0, 0.0)[5], abs=1e-9)


def test_standing_camera_has_no_foe() -> None:
    standing: Floats = np.array([[0.0, 0.0, 0.001], [0.0, 0.0, -1.0], [0.1, 0.0, 1.0]])
    foe = paths.expansion(Camera(), standing)
    assert np.isnan(foe[:2]).all()
    assert foe[2] == pytest.approx([319.5 + 32.0, 239.5])


def test_missing_and_full_folders_are_refused(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match="nowhere: expected the folder of a drive, found nothing"):
        readers.read(tmp_path / "nowhere")
    (tmp_path / "note.txt").write_text("mine")
    assert cli.run(["replay", str(drive), "--out", str(tmp_path)]) == 2
    assert "expected an empty or new folder for --out" in capsys.readouterr().err


@pytest.mark.skipif("VPF_SIM_SHARED" not in os.environ, reason="needs the recorded drives; set VPF_SIM_SHARED")
def test_shared_drive_agrees_with_its_labels() -> None:
    folder = Path(os.environ["VPF_SIM_SHARED"]) / "drives" / "kitti_vo_seq1"
    shared_drive = readers.read(folder)
    labels = np.genfromtxt(folder / "labels.csv", delimiter=",", names=True)
    poses = np.loadtxt(folder / "poses.txt").reshape(-1, 3, 4)
    assert len(shared_drive) == len(poses) == 51
    moved = np.array([a[:, :3].T @ (b[:, 3] - a[:, 3]) for a, b in pairwise(poses)])
    label = np.stack([labels["foe_x_px"], labels["foe_y_px"]], axis=1)[: len(moved)]
    assert np.abs(paths.expansion(shared_drive.camera, moved) - label).max() < 1e-3
    # Row k of the labels is in the axes of frame k; ours is at k + 1 in the axes halfway between.
    half_turn_px = 707.0912 * 0.5 * np.diff(shared_drive.poses[:, 2])
    assert np.abs(shared_drive.foe_px[1:, 0] - (label[:, 0] - half_turn_px)).max() < 0.2
    assert shared_drive.speed_mps[:50] == pytest.approx(labels["speed_mps"], abs=0.15)
