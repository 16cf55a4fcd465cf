"""Where a signal comes from decides what is held against it: what follows from something assumed has no score."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import recorded_layouts as layouts
import rendered_drive as rendered
from test_replay_parts import recording

from vpf_sim import cli
from vpf_sim.replay import scores
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.recording import PICTURES, Origin
from vpf_sim.types import Image

TOLD = "[camera]\nfield_of_view_deg = 90.0\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\n"


def replay(
    folder: Path, frames: list[Image], toml: str, signals: str, capsys: pytest.CaptureFixture[str], driver: str = "vpf"
) -> dict[str, Any]:
    """The answer of `vpf-sim replay --json` on a film of that name; no error is told."""
    folder.mkdir()
    layouts.video(folder / "drive.mp4", frames, rendered.RATE_HZ)
    (folder / "drive.toml").write_text(f"schema = 1\nweather = 'rain'\n{toml}")
    if signals:
        (folder / "signals.csv").write_text(signals)
    out = folder.with_name(f"{folder.name} run")
    code = cli.run(["replay", str(folder), "--driver", driver, "--no-video", "--out", str(out), "--json"])
    said = capsys.readouterr()
    assert (code, said.err) == (0, "")
    answer: dict[str, Any] = json.loads(said.out)
    return answer


def straight(count: int = 14) -> list[Image]:
    images, _ = rendered.shots(np.inf, 2, 0.0, None, rendered.FRAMES)
    return list(images[:count])


def table(**columns: float) -> FrameTable:
    """Ten frames of a driver that saw its road and does as the human did."""
    row = FrameRow(
        0, 0.0, 0, 1.0, 10.0, 0.0, 0.1, 0.1, np.nan, np.nan, 0.1, 0.1, 1.0, 1.0, 0.0, 0.0, 320.0, 240.0, 1.0, 0.0
    )
    return FrameTable.of([row._replace(frame=k, time_s=0.1 * k, **columns) for k in range(10)])


def test_the_weakest_input_decides() -> None:
    speed, rate = Origin("assumed", "held"), Origin.following("from the flow", {PICTURES: Origin("recorded")})
    steering = Origin.following("the bicycle", {"speed_mps": speed, "yaw_rate_radps": rate})
    assert (steering.kind, steering.how) == ("assumed", "the bicycle; speed_mps is assumed")
    assert steering.inputs == {"speed_mps", "yaw_rate_radps", PICTURES}
    assert Origin.following("on", {"steering_rad": steering}).kind == "assumed"
    assert (rate.kind, rate.is_known, steering.is_known) == ("derived", True, False)


@pytest.mark.parametrize(("kind", "is_scored"), [("recorded", True), ("derived", True), ("assumed", False)])
def test_what_is_assumed_is_not_scored(kind: Any, is_scored: bool) -> None:
    drive = recording(1.0)
    found = scores.accuracies(table(), recording(1.0, origins={**drive.origins, "throttle": Origin(kind)}))
    assert found is not None
    assert (found["throttle"] is not None, found["idle"]["throttle"] is not None) == (is_scored, is_scored)
    assert found["steering"] is not None


@pytest.mark.parametrize(
    ("columns", "count"),
    [
        ({}, 0),
        ({"image": 0.0}, 10),
        ({"held": 1.0}, 10),
        ({"road_found": 0.0, "held": 1.0}, 0),
        ({"foe_x_px": np.nan}, 0),
    ],
)
def test_scored_frames_that_were_not_seen_are_counted_beside_the_score(columns: dict[str, float], count: int) -> None:
    found = scores.accuracies(table(**columns), recording(1.0))
    assert found is not None
    assert found["unseen"] == {"whole": count, "clear_of_obstacles": count, "with_obstacles": 0}


def test_a_yaw_rate_that_follows_from_the_steering_does_not_check_it() -> None:
    drive = recording(10.0)
    angle = 0.01 * np.sin(np.arange(100) / 10.0)
    rate = drive.speed_mps * np.tan(angle) / 2.7
    apart = recording(10.0, steering_rad=angle, yaw_rate_radps=rate)
    assert scores.signal_checks(apart)["yaw_rate"]["gain"] == pytest.approx(1.0)
    inputs = {name: Origin("recorded") for name in ("speed_mps", "steering_rad")}
    for origin in (Origin.following("the bicycle", inputs), Origin("assumed")):
        same = recording(
            10.0, steering_rad=angle, yaw_rate_radps=rate, origins={**drive.origins, "yaw_rate_radps": origin}
        )
        assert scores.signal_checks(same)["yaw_rate"] is None


def test_a_speed_that_is_held_gives_no_throttle_to_be_scored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It stood as 100.0 in the paper's row of rain."""
    answer = replay(tmp_path / "held", straight(), f"speed_mps = 8.0\n{TOLD}", "", capsys, "neutral")
    (record,) = answer["drives"]
    for name in ("throttle", "steering_rad", "poses"):
        assert record["origins"][name]["kind"] == "assumed"
        assert "speed_mps is assumed" in record["origins"][name]["how"]
    assert (record["accuracy"]["throttle"], record["accuracy"]["steering"]) == (None, None)
    assert "throttle: not scored, the human's is assumed" in record["notes"]
    assert "100 m ahead" in record["goal"], "nobody knows where it went"
    (row,) = [row for row in answer["rows"] if row["frames"]]
    assert row["signals"] == {"throttle": "assumed", "steering": "assumed"}
    assert row["accuracy"] == row["idle"] == {"throttle": None, "steering": None}


def test_a_lens_cap_has_no_marks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    black = [np.zeros((480, 640, 3), np.uint8)] * 8
    (record,) = replay(tmp_path / "cap", black, "speed_mps = 7.5\n", "", capsys)["drives"]
    assert (record["accuracy"]["throttle"], record["accuracy"]["steering"]) == (None, None)
    assert record["accuracy"]["unseen"]["whole"] == 8
    assert "8 of 8 frames are scored unseen: there was no picture, or the last command held" in record["notes"]


def test_where_a_speed_is_bridged_nothing_is_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Known for the first half second only: after that the throttle would be that of a speed that nobody told."""
    rows = "".join(f"{k / 20.0},8.0,0\n" for k in range(11))
    folder, header = tmp_path / "part", "time_s,speed_mps,yaw_rate_degps\n"
    (record,) = replay(folder, straight(30), TOLD, header + rows, capsys, "neutral")["drives"]
    assert "steering: scored in 16 of 30 frames, elsewhere the human's is not known" in record["notes"]
    assert any(note.startswith("speed: 14 of 30 values missing") for note in record["notes"]), record["notes"]
    assert record["accuracy"]["throttle"]["mae"] == 0.0
    # Half a second after the last row is near enough; a slope asks for a quarter of a second more.
    assert "throttle: scored in 13 of 30 frames, elsewhere the human's is not known" in record["notes"]
