"""`vpf-sim replay --faults`: a scenario's sensor faults in a recording."""

import json
from pathlib import Path

import numpy as np
import pytest
import rendered_drive as rendered

from vpf_sim import cli
from vpf_sim.errors import InputError
from vpf_sim.replay.added import with_faults
from vpf_sim.replay.recording import Frame, Recording
from vpf_sim.scenarios.parts import SensorFaults

BEND_M = 100.0


def known() -> Recording:
    return rendered.recording(BEND_M)


def frames_with(faults: SensorFaults) -> list[Frame]:
    return list(with_faults(known(), faults).frames())


def is_image_of(frame: Frame, k: int) -> bool:
    original = list(known().frames())[k].image
    return frame.image is not None and original is not None and bool((frame.image == original).all())


def test_late_frames_keep_their_exposure_time() -> None:
    late = round(0.2 * rendered.RATE_HZ)
    found = frames_with(SensorFaults(latency_ms=200.0))
    assert [frame.index for frame in found] == list(range(rendered.FRAMES))
    for k in (late, late + 1, rendered.FRAMES - 1):
        assert is_image_of(found[k], k - late)
        assert found[k].time_s == pytest.approx(known().times_s[k - late])


def test_dropped_frames_repeat_the_last_image() -> None:
    found = frames_with(SensorFaults(drop_share=0.5))
    shown = [int(np.searchsorted(known().times_s, frame.time_s)) for frame in found if frame.time_s is not None]
    assert all(is_image_of(frame, k) for frame, k in zip(found, shown, strict=True))
    assert 0.25 < np.mean(np.diff(shown) == 0) < 0.75


def test_stuck_speedometer_is_marked_in_the_origins() -> None:
    speeds = np.linspace(3.0, 9.0, rendered.FRAMES)
    failing = with_faults(rendered.recording(BEND_M, speed_mps=speeds), SensorFaults(speed_stuck_after_s=1.0))
    late = known().times_s >= 1.0
    assert failing.speed_mps[~late] == pytest.approx(speeds[~late])
    assert np.ptp(failing.speed_mps[late]) == 0.0
    assert failing.origins["speed_mps"].kind == "derived"
    assert failing.origins["yaw_rate_radps"] == known().origins["yaw_rate_radps"]


def test_scenario_without_faults_is_refused() -> None:
    with pytest.raises(InputError, match="expected a scenario with a fault in"):
        with_faults(known(), SensorFaults())


def test_run_folder_and_resume_name_the_faults(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rendered.write(tmp_path / "bend", BEND_M)
    scenario = tmp_path / "late.toml"
    scenario.write_text('base = "straight"\n[ego.sensor_faults]\nlatency_ms = 100\n')
    command = ["replay", str(tmp_path / "bend"), "--driver", "neutral", "--no-video", "--out", str(tmp_path / "run")]
    assert cli.run([*command, "--faults", str(scenario), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert {row["added"] for row in result["rows"] if row["frames"]} == {"simulated sensor faults"}
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["plan"]["faults"]["latency_ms"] == 100.0
    assert cli.run([*command, "--resume"]) == 2
    assert "plan changed: faults:" in capsys.readouterr().err
    scenario.write_text('base = "straight"\n[ego.sensor_faults]\nlatency_ms = 150\n')
    assert cli.run([*command, "--faults", str(scenario), "--resume"]) == 2
    assert "plan changed: faults" in capsys.readouterr().err
