"""`vpf-sim replay` on your own recordings: folder, table, page, and messages about missing data."""

import html
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rendered_drive as rendered

from vpf_sim import cli
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.replay import added, frame_table

BEND_M = 100.0


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bend to the right, in the general layout."""
    folder = tmp_path_factory.mktemp("drives") / "bend"
    rendered.write(folder, BEND_M)
    return folder


@pytest.fixture(scope="module")
def run(drive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its replay."""
    out = tmp_path_factory.mktemp("runs") / "run"
    assert cli.run(["replay", str(drive), "--out", str(out)]) == 0
    return out


def summary(run: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((run / "summary.json").read_text())
    return found


def test_recorded_commands_match_the_signal_table(run: Path) -> None:
    table = frame_table.read(run / "frames" / "bend.parquet")
    known = rendered.recording(BEND_M)
    assert table.recorded_steering == pytest.approx(known.steering_rad / 0.6981317, abs=1e-6)
    assert table.recorded_throttle == pytest.approx([0.1] * rendered.FRAMES)  # 0.3 of 3 m/s2
    assert table.steering[-1] == pytest.approx(0.039, abs=0.01)


def test_paper_cells_stand_beside_their_weather_only(run: Path) -> None:
    rows = {(row["weather"], row["part"]): row for row in summary(run)["rows"]}
    ours = rows["light rain", "clear_of_obstacles"]
    assert ours["drives"] == ["bend"]
    assert ours["frames"] == rendered.FRAMES
    assert ours["signals"] == {"throttle": "recorded", "steering": "recorded"}
    assert ours["paper"] == {"throttle": 0.5827, "steering": 0.5587}
    assert ours["accuracy"]["steering"]["range"] > 0.98
    for cell in (("cloudy", "clear_of_obstacles"), ("rain", "with_obstacles"), ("light rain", "with_obstacles")):
        assert rows[cell]["frames"] == 0
        assert rows[cell]["accuracy"] == {"throttle": None, "steering": None}
        assert rows[cell]["paper"] is not None
    assert len(rows) == 6


def test_folder_has_records_timing_video_and_page(run: Path) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    assert manifest["command"] == "replay"
    assert manifest["plan"]["driver"] == "vpf"
    record = json.loads((run / "replays.jsonl").read_text())
    assert (record["name"], record["frames"], record["gaps"]) == ("bend", rendered.FRAMES, 0)
    assert json.loads((run / "timing.jsonl").read_text())["real_time"] > 0.0
    assert (run / "videos" / "bend.mp4").stat().st_size > 10_000
    page = (run / "report.html").read_text()
    assert "no recording" in page
    assert page.count("<figcaption>") == 6  # the video, throttle, steering, focus of expansion in x and y, speed
    assert "data:video/mp4;base64," in page


def test_page_begins_with_the_users_drive_and_ends_with_cells_of_the_paper_without_a_recording(run: Path) -> None:
    page = html.unescape((run / "report.html").read_text())
    assert "<h1>What vpf commands on bend</h1>" in page
    (poster,) = re.findall(r'<video [^>]*poster="(data:image/jpeg;base64,[^"]+)" src="data:video', page)
    assert len(poster) > 1000
    drive, *tables = page[page.index('<section class="drive">') :].split('<details id="table')
    assert "steering agrees with the human's to 99." in drive
    assert drive.count("<video") == 1
    assert all("open" not in table[:20] for table in tables if "<h2>Warnings</h2>" not in table)
    assert "<h2>Throttle and steering beside the human's</h2>" in tables[-1]
    body = tables[-1][tables[-1].index("<tbody>") :]
    rows = re.findall(r"<tr( class=\"faint\")?>(.*)</tr>", body)
    assert [bool(small) for small, _ in rows] == [False, *(5 * [True])]
    assert ["no recording" in row for _, row in rows] == [False, *(5 * [True])]


def test_resume_skips_finished_drives(drive: Path, run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["replay", str(drive), "--out", str(run)]) == 2
    assert "choose another, or --resume what is there" in capsys.readouterr().err
    assert cli.run(["replay", str(drive), "--driver", "neutral", "--out", str(run), "--resume"]) == 2
    assert 'plan changed: driver: was "vpf", is "neutral"' in capsys.readouterr().err
    before = (run / "replays.jsonl").read_bytes()
    assert cli.run(["replay", str(drive), "--out", str(run), "--resume", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in result["drives"]] == ["bend"]
    assert result["drives"][0]["accuracy"]["steering"]["mae"] < 0.03
    assert (run / "replays.jsonl").read_bytes() == before


def test_two_runs_have_equal_records(drive: Path, run: Path, tmp_path: Path) -> None:
    assert cli.run(["replay", str(drive), "--out", str(tmp_path / "again"), "--no-video"]) == 0
    assert (tmp_path / "again" / "replays.jsonl").read_bytes() == (run / "replays.jsonl").read_bytes()
    assert not (tmp_path / "again" / "videos").exists()


def test_unreadable_drive_does_not_stop_the_others(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    out = tmp_path / "out"
    code = cli.run(["replay", str(tmp_path / "empty"), str(drive), "--driver", "neutral", "--out", str(out), "--json"])
    said = capsys.readouterr()
    assert code == 2
    assert said.err.count("\n") == 1
    assert "empty: found nothing" in said.err
    assert [entry["name"] for entry in json.loads(said.out)["drives"]] == ["bend"]


def test_simulated_water_has_its_own_row(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    command = ["replay", str(drive), "--driver", "neutral", "--no-video", "--out", str(out), "--json"]
    assert cli.run([*command, "--water", "HardRainNoon"]) == 0
    result = json.loads(capsys.readouterr().out)
    filled = [row for row in result["rows"] if row["frames"]]
    assert [(row["weather"], row["added"]) for row in filled] == [("light rain", "simulated water of HardRainNoon")]
    assert filled[0]["paper"] is None
    empty = [row for row in result["rows"] if row["weather"] == "light rain" and row["paper"]]
    assert [row["drives"] for row in empty] == [[], []]
    assert cli.run([*command, "--water", "clear"]) == 2
    assert "--water: expected a weather with droplets > 0, got 'ClearNoon' with 0" in capsys.readouterr().err


def test_simulated_water_changes_the_images() -> None:
    dry = rendered.recording(BEND_M)
    wet = added.with_water(dry, weathers.load("HardRainNoon"))
    pairs = [(a.image, b.image) for a, b in zip(dry.frames(), wet.frames(), strict=True)][:10]
    changed = [np.mean(np.any(a != b, axis=2)) for a, b in pairs if a is not None and b is not None]
    assert 0.01 < np.median(changed) < 0.5


class Weary:
    """A driver that is interrupted on its second drive."""

    privileged = "none"
    drives = 0

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        Weary.drives += 1

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        if Weary.drives == 2:
            raise KeyboardInterrupt
        return Command(0.0, 0.0)


def test_interruption_prints_the_resume_command(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    driver, out = f"{__name__}:Weary", tmp_path / "out"
    assert cli.run(["replay", str(drive), str(drive), "--driver", driver, "--no-video", "--out", str(out)]) == 130
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "stopped with 1 of 2 drives stored",
        f"go on with: vpf-sim replay {drive} {drive} --driver {driver} --no-video --out {out} --resume",
    ]
    assert cli.run(said[1].split("vpf-sim ", 1)[1].split(" ")) == 0
    assert "bend-2" in capsys.readouterr().out
