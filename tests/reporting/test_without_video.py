"""Without the extra `video`: sweep, table and report work, and what needs PyAV is refused in one line."""

import json
from pathlib import Path

import pytest
from short_scenario import write_short

from vpf_sim import cli
from vpf_sim.replay import video_file
from vpf_sim.reporting import video

INSTALL = "expected PyAV, which is not installed: pip install 'vpf_sim[video]'"


pytestmark = pytest.mark.usefixtures("in_one_process")


@pytest.fixture(autouse=True)
def without_pyav(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(video, "av", None)
    monkeypatch.setattr(video_file, "av", None)
    write_short(tmp_path)
    monkeypatch.chdir(tmp_path)


def test_a_sweep_is_driven_and_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = ["sweep", "--scenario", "short.toml", "--driver", "neutral", "--seeds", "0:1", "--workers", "1", "--json"]
    assert cli.run([*sweep, "--out", "run"]) in (0, 1)
    (record,) = [json.loads(line) for line in (tmp_path / "run" / "episodes.jsonl").read_text("utf-8").splitlines()]
    spoilt = json.dumps({**record, "status": "off_road"})
    (tmp_path / "run" / "episodes.jsonl").write_text(f"{spoilt}\n", "utf-8")
    capsys.readouterr()
    assert cli.run(["report", "run"]) == 0
    assert f"no videos: PyAV is not installed: {video.INSTALL}" in capsys.readouterr().err
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert "<video" not in page
    assert "vpf_sim[video]" in page


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["drive", "short.toml", "--driver", "pid", "--out", "run", "--video", "a.mp4"], "video 'a.mp4'"),
        (["video", "run", "--id", "a"], "video"),
        (["weathers", "gallery", "--out", "gallery"], "gallery"),
        (["replay", "drive"], "replay without --no-video"),
        (["replay", "drive.mp4", "--no-video"], "drive.mp4"),
    ],
)
def test_a_video_is_refused_in_one_line(
    arguments: list[str], what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "drive.mp4").write_bytes(b"")
    assert cli.run(arguments) == 2
    assert capsys.readouterr().err == f"vpf-sim: {what}: {INSTALL}\n"
    assert not (tmp_path / "run").exists()
