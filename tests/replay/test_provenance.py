"""The origin of a signal decides whether it is scored: what follows from an assumption is not."""

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
from vpf_sim.replay.recording import IMAGES, Origin
from vpf_sim.replay.records import Counts
from vpf_sim.types import Image

ORIGIN_SIGNALS = "[camera]\nfield_of_view_deg = 90.0\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0\n"


def replay(
    folder: Path, frames: list[Image], toml: str, signals: str, capsys: pytest.CaptureFixture[str], driver: str = "vpf"
) -> dict[str, Any]:
    """The output of `vpf-sim replay --json` on a video of that name, without an error."""
    folder.mkdir()
    layouts.video(folder / "drive.mp4", frames, rendered.RATE_HZ)
    (folder / "drive.toml").write_text(f"schema = 1\nweather = 'rain'\n{toml}")
    if signals:
        (folder / "signals.csv").write_text(signals)
    out = folder.with_name(f"{folder.name} run")
    code = cli.run(["replay", str(folder), "--driver", driver, "--no-video", "--out", str(out), "--json"])
    said = capsys.readouterr()
    assert (code, said.err) == (0, "")
    result: dict[str, Any] = json.loads(said.out)
    return result


def straight(count: int = 14) -> list[Image]:
    images, _ = rendered.shots(np.inf, 2, 0.0, None, rendered.FRAMES)
    return list(images[:count])


def table(**columns: float) -> FrameTable:
    """Ten frames of a driver with a lane and the human's commands."""
    row = FrameRow(
        0, 0.0, 0, 1.0, 10.0, 0.0, 0.1, 0.1, np.nan, np.nan, 0.1, 0.1, 1.0, 1.0, 0.0, 0.0, 320.0, 240.0, 1.0, 0.0
    )
    return FrameTable.of([row._replace(frame=k, time_s=0.1 * k, **columns) for k in range(10)])


def test_origin_is_that_of_the_weakest_input() -> None:
    speed, rate = Origin("assumed", "held"), Origin.derived_from("from the flow", {IMAGES: Origin("recorded")})
    steering = Origin.derived_from("the bicycle", {"speed_mps": speed, "yaw_rate_radps": rate})
    assert (steering.kind, steering.how) == ("assumed", "the bicycle; speed_mps is assumed")
    assert steering.inputs == {"speed_mps", "yaw_rate_radps", IMAGES}
    assert Origin.derived_from("on", {"steering_rad": steering}).kind == "assumed"
    assert (rate.kind, rate.is_known, steering.is_known) == ("derived", True, False)


@pytest.mark.parametrize(("kind", "is_scored"), [("recorded", True), ("derived", True), ("assumed", False)])
def test_assumed_signal_is_not_scored(kind: Any, is_scored: bool) -> None:
    drive = recording(1.0)
    found = scores.accuracies(table(), recording(1.0, origins={**drive.origins, "throttle": Origin(kind)}))
    assert found is not None
    assert (found.throttle is not None, found.idle.throttle is not None) == (is_scored, is_scored)
    assert found.steering is not None


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
def test_scored_frames_without_image_are_counted_as_unseen(columns: dict[str, float], count: int) -> None:
    found = scores.accuracies(table(**columns), recording(1.0))
    assert found is not None
    assert found.unseen == Counts(whole=count, clear_of_obstacles=count, with_obstacles=0)


def test_yaw_rate_derived_from_steering_does_not_check_it() -> None:
    drive = recording(10.0)
    angle = 0.01 * np.sin(np.arange(100) / 10.0)
    rate = drive.speed_mps * np.tan(angle) / 2.7
    apart = recording(10.0, steering_rad=angle, yaw_rate_radps=rate)
    assert scores.signal_checks(apart).yaw_rate.gain == pytest.approx(1.0)
    inputs = {name: Origin("recorded") for name in ("speed_mps", "steering_rad")}
    for origin in (Origin.derived_from("the bicycle", inputs), Origin("assumed")):
        same = recording(
            10.0, steering_rad=angle, yaw_rate_radps=rate, origins={**drive.origins, "yaw_rate_radps": origin}
        )
        assert scores.signal_checks(same).yaw_rate is None


def test_constant_speed_gives_no_scored_throttle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Else it would be 100.0 in the paper's row for rain."""
    result = replay(tmp_path / "held", straight(), f"speed_mps = 8.0\n{ORIGIN_SIGNALS}", "", capsys, "neutral")
    (record,) = result["drives"]
    for name in ("throttle", "steering_rad", "poses"):
        assert record["origins"][name]["kind"] == "assumed"
        assert "speed_mps is assumed" in record["origins"][name]["how"]
    assert (record["accuracy"]["throttle"], record["accuracy"]["steering"]) == (None, None)
    assert "throttle: not scored, the human's is assumed" in record["notes"]
    assert "100 m ahead" in record["goal"], "its destination is unknown"
    (row,) = [row for row in result["rows"] if row["frames"]]
    assert row["signals"] == {"throttle": "assumed", "steering": "assumed"}
    assert row["accuracy"] == row["idle"] == {"throttle": None, "steering": None}


def test_covered_lens_has_no_scores(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    black = [np.zeros((480, 640, 3), np.uint8)] * 8
    (record,) = replay(tmp_path / "cap", black, "speed_mps = 7.5\n[camera]\nheight_m = 1.4\n", "", capsys)["drives"]
    assert (record["accuracy"]["throttle"], record["accuracy"]["steering"]) == (None, None)
    assert record["accuracy"]["unseen"]["whole"] == 8
    assert "8 of 8 scored frames are unseen: no image, or the last command held" in record["notes"]


def test_bridged_speed_is_not_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The speed is known in the first half second only; a later throttle would rest on no data."""
    rows = "".join(f"{k / 20.0},8.0,0\n" for k in range(11))
    folder, header = tmp_path / "part", "time_s,speed_mps,yaw_rate_degps\n"
    (record,) = replay(folder, straight(30), ORIGIN_SIGNALS, header + rows, capsys, "neutral")["drives"]
    assert "steering: scored in 16 of 30 frames; elsewhere the human's is unknown" in record["notes"]
    assert any(note.startswith("speed: 14 of 30 values missing") for note in record["notes"]), record["notes"]
    assert record["accuracy"]["throttle"]["mae"] == 0.0
    # Values hold for half a second after the last row; a slope needs a quarter of a second more.
    assert "throttle: scored in 13 of 30 frames; elsewhere the human's is unknown" in record["notes"]
