"""Records: keys, values, and the run folder."""

import json
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiny_world import Constant, TinyWorld

from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.episode.episode import roll_out
from vpf_sim.evaluation.episode.paired import PidRun, matched
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Timing, record_of, unscored
from vpf_sim.evaluation.score_keys import finite
from vpf_sim.evaluation.steps import Outcome, StepTable
from vpf_sim.evaluation.sweeps.manifest import Manifest
from vpf_sim.evaluation.sweeps.run_folder import JsonLines, RunFolder, new_path, read_lines
from vpf_sim.types import Floats

JOB = Job("town04", "clear", "vpf", 7)
KEYS = {
    *("id", "scenario", "weather", "driver", "seed", "status", "route_completion", "path_mse_m2", "max_lane_offset_m"),
    *("accuracy", "collisions", "collided_with", "min_clearance_m", "driving_score_2_0", "driving_score_2_1"),
    *("invalid_frame", "comfort", "perception", "steps", "states_sha256", "frames_sha256", "chattering"),
    *("collision_type", "failure", "at_fault_collisions", "path_mse_parts_m2", "uncertainty"),
}
PID_RUN = PidRun(np.arange(11.0), np.full(11, 0.5), np.zeros(11))
REQUESTED: dict[str, Any] = {
    "schema": 1,
    "command": "sweep",
    "plan": {"scenario": ["town04"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:5"},
    "fingerprint": {"python": "3.11.9", "numpy": "2.4.0"},
    "scenarios": {"town04": "abc"},
    "weathers": {"clear": "def"},
}


def outcome(driver: Constant, **changes: Any) -> Outcome:
    world = TinyWorld(**changes)
    driven = roll_out(world, driver, Constant(0.25, 0.1), seed=7)
    return replace(driven, steps=matched(driven.steps, PID_RUN)) if len(driven.steps) else driven


def scored(driven: Outcome, route: Floats, route_length_m: float) -> Any:
    return record_of(JOB, driven, route, route_length_m).as_json()


def failed() -> Any:
    return unscored(JOB).as_json()


def requested(**changes: Any) -> Manifest:
    return Manifest.model_validate({**REQUESTED, **changes})


def score(driver: Constant, **changes: Any) -> dict[str, Any]:
    world = TinyWorld()
    return scored(outcome(driver, **changes), world.route, world.route_length_m)


def test_a_record_of_a_drive_that_is_known_in_closed_form() -> None:
    record = score(Constant(1.0, 0.1))
    assert record.keys() == KEYS
    assert (record["id"], record["status"], record["steps"]) == ("town04.clear.vpf.7", "success", 10)
    offsets = 0.1 * np.arange(11.0)
    assert record["path_mse_m2"] == pytest.approx(np.mean(offsets**2))
    assert record["max_lane_offset_m"] == pytest.approx(1.0)
    assert record["accuracy"]["shadow"]["throttle"]["mae"] == pytest.approx(0.75)
    assert record["accuracy"]["shadow"]["steering"]["mae"] == pytest.approx(0.0)
    assert record["accuracy"]["paired"]["throttle"]["mae"] == pytest.approx(0.5)
    assert record["accuracy"]["paired"]["steering"]["mae"] == pytest.approx(0.1)
    assert (record["route_completion"], record["driving_score_2_1"]) == (1.0, 1.0)
    assert (record["collisions"], record["min_clearance_m"], record["invalid_frame"]) == (0, None, None)


def test_the_path_is_scored_by_part() -> None:
    driven = outcome(Constant(1.0, 0.1))
    table = driven.steps.replaced({"passing": np.arange(11) >= 6})
    record = scored(replace(driven, steps=table), TinyWorld().route, 10.0)
    offsets = 0.1 * np.arange(11.0)
    parts = {"clear_of_obstacles": np.mean(offsets[:6] ** 2), "passing": np.mean(offsets[6:] ** 2)}
    assert record["path_mse_parts_m2"] == pytest.approx(parts)
    assert record["path_mse_m2"] == pytest.approx((6 * parts["clear_of_obstacles"] + 5 * parts["passing"]) / 11)


def test_a_record_holds_no_nan_and_survives_json() -> None:
    for record in (score(Constant()), score(Constant(), invalid_after=1), failed()):
        assert json.loads(json.dumps(record, allow_nan=False)) == record


def test_the_record_of_a_failure_has_the_same_keys() -> None:
    assert failed().keys() == KEYS
    nothing = Outcome("error", StepTable.of([]), None, sha256().hexdigest(), "why")
    assert scored(nothing, np.zeros((2, 2)), 1.0) == failed()


def test_a_collision_costs_its_factor() -> None:
    hit = outcome(Constant(0.5))
    near = {"near_speed_mps": np.zeros(11), "near_bearing_rad": np.zeros(11), "near_bumper_m": np.zeros(11)}
    table = StepTable(hit.steps.rows[:11]).replaced(near)
    hit = Outcome("collision", table, "car", hit.frames_sha256, None)
    record = scored(hit, TinyWorld().route, 10.0)
    assert (record["collisions"], record["collided_with"], record["route_completion"]) == (1, "car", 0.5)
    assert record["driving_score_2_0"] == pytest.approx(0.5 * 0.60)
    assert record["driving_score_2_1"] == pytest.approx(0.5 / 1.70)
    assert (record["collision_type"], record["at_fault_collisions"]) == ("stopped_track", 1)


@pytest.mark.parametrize("steps_before", [0, 3])
def test_a_record_has_the_invalid_frame(steps_before: int) -> None:
    record = score(Constant(), invalid_after=steps_before)
    assert (record["status"], record["steps"]) == ("invalid_frame", steps_before)
    assert record["invalid_frame"] == {"frame": steps_before, "time_s": steps_before / 10.0, "fault": "stale"}


def test_finite_leaves_no_numpy_and_no_nan() -> None:
    value = {"a": np.float64("nan"), "b": [np.int64(3), float("inf")], "c": np.bool_(True), "d": "x"}
    assert repr(finite(value)) == "{'a': None, 'b': [3, None], 'c': True, 'd': 'x'}"


def test_ids_are_readable_for_names_and_unique_for_files() -> None:
    assert JOB.id == "town04.clear.vpf.7"
    ids = {Job(path, "clear", "my.module:Mine", 7).id for path in ("a/x.toml", "b/x.toml", "x.toml", "x")}
    assert len(ids) == 4
    assert all("/" not in found and ":" not in found for found in ids)


def test_steps_are_read_as_they_were_written(tmp_path: Path) -> None:
    table = outcome(Constant()).steps
    steps.write(table, tmp_path / "steps" / "a.parquet")
    assert [path.name for path in (tmp_path / "steps").iterdir()] == ["a.parquet"]
    assert np.array_equal(steps.read(tmp_path / "steps" / "a.parquet").rows, table.rows, equal_nan=True)


def test_an_incomplete_last_line_is_dropped_and_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "episodes.jsonl"
    path.write_text('{"id": "a"}\n{"id": "b", "sta')
    assert read_lines(path) == [{"id": "a"}]
    lines = JsonLines(path)
    lines.append({"id": "c"})
    lines.close()
    assert path.read_text() == '{"id": "a"}\n{"id": "c"}\n'


def test_any_other_invalid_line_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "episodes.jsonl"
    path.write_text('{"id": "a"}\n[1]\n{"id": "b"}\n')
    with pytest.raises(InputError, match=r"episodes.jsonl: line 2: expected a JSON object, got b'\[1\]'"):
        read_lines(path)


def test_a_line_without_a_record_is_reported(tmp_path: Path) -> None:
    RunFolder(tmp_path, requested()).close()
    (tmp_path / "episodes.jsonl").write_text('{"seed": 3}\n')
    with pytest.raises(InputError, match=r"episodes.jsonl: expected a record with an id on each line"):
        RunFolder(tmp_path, requested(), resume=True)


def test_a_folder_with_records_needs_resume(tmp_path: Path) -> None:
    RunFolder(tmp_path / "run", requested()).close()
    with pytest.raises(InputError, match="expected an empty or new run folder, choose another out, or resume"):
        RunFolder(tmp_path / "run", requested())
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    with pytest.raises(InputError, match="got other files"):
        RunFolder(tmp_path / "mine", requested())
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="expected a folder, got a file"):
        RunFolder(tmp_path / "file", requested())


def test_a_run_killed_before_its_manifest_leaves_its_folder_usable(tmp_path: Path) -> None:
    for name in ("episodes.jsonl", "timing.jsonl", "manifest.json.draft"):
        (tmp_path / name).write_text("")
    RunFolder(tmp_path, requested()).close()
    assert json.loads((tmp_path / "manifest.json").read_text()) == REQUESTED
    (tmp_path / "manifest.json").unlink()
    (tmp_path / "episodes.jsonl").write_text('{"id": "somebody else\'s"}\n')
    with pytest.raises(InputError, match="got other files"):
        RunFolder(tmp_path, requested())


def test_a_resumed_folder_has_its_finished_episodes(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, requested())
    folder.add(unscored(JOB), Timing(id=JOB.id))
    folder.close()
    again = RunFolder(tmp_path, requested(), resume=True)
    assert (again.done, again.mark) == ({JOB.id}, None)
    again.close()


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("command", "benchmark", 'command changed: was "sweep", is "benchmark"'),
        ("plan", {**REQUESTED["plan"], "seeds": "0:6"}, 'plan changed: seeds: was "0:5", is "0:6"'),
        ("drivers", {"mine:Own": "new"}, 'drivers changed: mine:Own: was null, is "new"'),
        ("scenarios", {"town04": "xyz"}, 'scenarios changed: town04: was "abc", is "xyz"'),
        (
            "fingerprint",
            {"python": "3.12.1", "numpy": "2.4.0"},
            'fingerprint changed: python: was "3.11.9", is "3.12.1"',
        ),
    ],
)
def test_resume_refuses_a_change_and_says_what_changed(tmp_path: Path, key: str, value: Any, sentence: str) -> None:
    RunFolder(tmp_path, requested()).close()
    with pytest.raises(InputError) as caught:
        RunFolder(tmp_path, requested(**{key: value}), resume=True)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_mixed_accepts_another_fingerprint_and_nothing_else(tmp_path: Path) -> None:
    RunFolder(tmp_path, requested()).close()
    fingerprint = {"python": "3.12.1", "numpy": "2.4.0"}
    folder = RunFolder(tmp_path, requested(fingerprint=fingerprint), resume=True, mixed=True)
    assert folder.mark is not None
    folder.close()
    with pytest.raises(InputError, match="plan changed"):
        RunFolder(tmp_path, requested(fingerprint=fingerprint, plan={}), resume=True, mixed=True)


def test_a_run_folder_has_one_run_at_a_time(tmp_path: Path) -> None:
    first = RunFolder(tmp_path / "run", requested())
    first.add(unscored(JOB), Timing(id=JOB.id))
    with (tmp_path / "run" / "episodes.jsonl").open("a") as file:
        file.write('{"id": "half')  # what the other is just writing must not be cut off
    stored = (tmp_path / "run" / "episodes.jsonl").read_text()
    with pytest.raises(InputError) as caught:
        RunFolder(tmp_path / "run", requested(), resume=True)
    assert str(caught.value) == f"{tmp_path / 'run'}: in use by another run"
    assert (tmp_path / "run" / "episodes.jsonl").read_text() == stored
    first.close()
    RunFolder(tmp_path / "run", requested(), resume=True).close()


HOLD = """
import sys, time
from pathlib import Path
from vpf_sim.evaluation.sweeps.run_folder import locked
lock = locked(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(600)
"""


def test_a_killed_run_leaves_no_lock(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline().strip() == b"held"
        with pytest.raises(InputError, match="in use by another run"):
            RunFolder(tmp_path, requested())
        other.kill()
    RunFolder(tmp_path, requested()).close()


def test_a_file_system_without_locks_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise NotImplementedError

    monkeypatch.setattr("filelock.FileLock.acquire", refuse)
    with pytest.raises(InputError, match="expected a file system with locks"):
        RunFolder(tmp_path, requested())


def test_an_unusable_folder_is_not_locked(tmp_path: Path) -> None:
    RunFolder(tmp_path, requested()).close()
    (tmp_path / "episodes.jsonl").write_text('{"seed": 3}\n')
    for _ in range(2):
        with pytest.raises(InputError, match="expected a record with an id"):
            RunFolder(tmp_path, requested(), resume=True)


def test_a_discarded_folder_keeps_other_files(tmp_path: Path) -> None:
    RunFolder(tmp_path / "run", requested()).discard()
    assert not (tmp_path / "run").exists()
    folder = RunFolder(tmp_path / "run", requested())
    (tmp_path / "run" / "note.txt").write_text("mine")
    folder.discard()
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["note.txt"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"plan": 1', '{"command": "sweep", "plan": 3, "fingerprint": {}}'])
def test_an_invalid_manifest_is_reported(tmp_path: Path, text: str) -> None:
    (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(InputError, match=r"manifest.json: expected"):
        RunFolder(tmp_path, requested(), resume=True)


def test_new_folders_are_distinct(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len({new_path("sweep") for _ in range(5)}) == 5
