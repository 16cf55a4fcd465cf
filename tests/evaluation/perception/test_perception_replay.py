"""Open-loop replay of a stored drive: equal to the run bit by bit; and the command that scores it."""

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from driven_run import drive_run
from short_scenario import SHORT, write_short

from vpf_sim import cli, drivers
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.episode.pose_playback import PosePlayback
from vpf_sim.evaluation.perception import scores, store, stored_drives
from vpf_sim.evaluation.perception.scorer import SCORED_COLUMNS, DriveEvaluation
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.types import Perception
from vpf_sim.types import Plan as DrivingPlan

WORLD = SHORT.replace(
    "[goal]", "[ego.sensors]\nposition_noise_m = 0.01\nyaw_rate_noise_radps = 0.01\npitch_deg = 0.2\n[goal]"
)
WORLD += (
    '[[bodies]]\nkind = "car"\ns_m = 22.0\nlane = 3\nspeed_mps = 4.0\n[[bodies]]\nkind = "cone"\ns_m = 25.0\nlane = 4\n'
)


@pytest.fixture(scope="module")
def plans() -> list[DrivingPlan]:
    """What the driver made of each frame of the run."""
    return []


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory, plans: list[DrivingPlan]) -> Path:
    """The folder of a drive in the rain behind a moving car, with sensors that err."""
    root = tmp_path_factory.mktemp("perception")
    (root / "short.toml").write_text(WORLD)
    plan = Plan((str(root / "short.toml"),), ("rain",), ("vpf",), "3:4")
    return drive_run(root / "run", plan, watch=lambda _, plan: plans.append(plan) if plan else None)


@pytest.fixture(scope="module")
def drive(run: Path) -> stored_drives.StoredDrive:
    (drive,) = store.stored_drives([run])
    return drive


@pytest.fixture(scope="module")
def evaluation(drive: stored_drives.StoredDrive) -> DriveEvaluation:
    (evaluation,) = stored_drives.evaluate(("vpf",), drive)
    return evaluation


def same(first: Any, second: Any) -> bool:
    """Whether two records are equal, arrays and all, to the last bit."""
    if isinstance(first, np.ndarray):
        return np.array_equal(first, second, equal_nan=first.dtype.kind == "f")
    if hasattr(type(first), "__dataclass_fields__"):
        return all(same(getattr(first, name), getattr(second, name)) for name in type(first).__dataclass_fields__)
    return callable(first) or bool(first == second)


def test_the_runs_own_driver_perceives_the_same_again(
    drive: stored_drives.StoredDrive, plans: list[DrivingPlan]
) -> None:
    table, again = drive.steps(), list[Perception]()
    with closing(PosePlayback(drive.record.scenario, "rain", table, truth=("foe",))) as world:
        stored_drives.perceive_drive(
            world, table, 3, {"vpf": drivers.create("vpf")}, lambda _, seen, __: again.extend(seen)
        )
    assert len(again) == len(plans) == len(table) > 50
    assert all(same(seen, plan.perception) for seen, plan in zip(again, plans, strict=True))
    assert world.largest_correction_m == 0.0


def test_it_is_scored_as_in_the_run(drive: stored_drives.StoredDrive, evaluation: DriveEvaluation) -> None:
    for name in SCORED_COLUMNS:
        assert np.array_equal(
            getattr(evaluation.table, name)[:-1], getattr(drive.steps(), name)[:-1], equal_nan=True
        ), name
    assert evaluation.remarks == ()


class EachFourth:
    """Perceives at every frame what it is shown, and looks at each fourth."""

    privileged = "none"
    shown: list[bool] = []  # noqa: RUF012 (of all instances: the harness makes one)

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        self.shown.clear()

    def act(self, observation: Observation) -> Command:
        raise AssertionError(f"nobody steers, not at {observation.time_s} s")

    def perceive(self, observation: Observation) -> Perception:
        self.shown.append(observation.image.size > 0)
        return self.seen

    @property
    def needs_next_frame(self) -> bool:
        return len(self.shown) % 4 == 0

    seen: Perception


def test_only_frames_that_perception_uses_are_rendered(
    drive: stored_drives.StoredDrive, plans: list[DrivingPlan]
) -> None:
    EachFourth.seen = plans[0].perception
    (found,) = stored_drives.evaluate((f"{__name__}:EachFourth",), drive)
    assert EachFourth.shown == [row % 4 == 0 for row in range(len(drive.steps()))]
    assert found.driver.endswith("EachFourth")


class Acts:
    """A driver without `perceive`, whose plan is what it perceived."""

    privileged = "none"
    plan: DrivingPlan

    def reset(self, setup: DriverSetup) -> None: ...

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        return Command(0.0, 0.0)

    def trace(self) -> DrivingPlan:
        return self.plan


class Fails(Acts):
    def act(self, observation: Observation) -> Command:
        raise ZeroDivisionError(f"no more at {observation.time_s:.0f} s")


class Silent(Acts):
    trace = None  # type: ignore[assignment]


def short(drive: stored_drives.StoredDrive, folder: Path, rows: int = 4) -> stored_drives.StoredDrive:
    """The first rows of a drive, as an episode of another folder."""
    steps.write(StepTable(drive.steps().rows[:rows]), folder / "steps" / f"{drive.record.id}.parquet")
    return drive._replace(folder=folder)


def test_a_driver_without_perceive_is_scored_by_its_plan(
    drive: stored_drives.StoredDrive, plans: list[DrivingPlan], tmp_path: Path
) -> None:
    Acts.plan = plans[-1]
    (found,) = stored_drives.evaluate((f"{__name__}:Acts",), short(drive, tmp_path))
    assert np.isfinite(found.table.seen_left_m[:-1]).all()


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("Fails", "fails on frame 0: ZeroDivisionError: no more at 0 s"),
        ("Silent", "expected one that shows what it perceives, by `perceive` or `trace`"),
    ],
)
def test_a_driver_without_perception_is_refused_in_one_line(
    name: str, sentence: str, drive: stored_drives.StoredDrive, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as told:
        stored_drives.evaluate((f"{__name__}:{name}",), short(drive, tmp_path))
    assert str(told.value) == f"driver '{__name__}:{name}': {sentence}"


def test_a_deviating_car_is_moved_to_the_stored_pose(drive: stored_drives.StoredDrive, tmp_path: Path) -> None:
    rows = drive.steps().rows[:5].copy()
    rows[2:, Step._fields.index("y_m")] += 0.5
    steps.write(StepTable(rows), tmp_path / "steps" / f"{drive.record.id}.parquet")
    (found,) = stored_drives.evaluate(("vpf",), drive._replace(folder=tmp_path))
    assert found.remarks == ("the car would now deviate by up to 0.50 m; its stored poses are used",)


def test_the_command_scores_stores_and_compares(
    run: Path,
    drive: stored_drives.StoredDrive,
    evaluation: DriveEvaluation,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    before, out = tmp_path / "before.json", tmp_path / "new" / "table.json"
    store.write(before, scores.table([evaluation]))
    command = ["perception", str(run), "--workers", "1", "--against", str(before), "--out", str(out), "--json"]
    assert cli.run(command) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert said.err == f"1/1 {drive.record.id}\n"
    (record,) = told["records"]
    objects = drive.record.as_json()["perception"]["objects"]
    assert (record["drive"], record["driver"], record["states_sha256"]) == (
        drive.record.id,
        "vpf",
        drive.record.states_sha256,
    )
    assert record["precision"] == objects["precision"]
    assert record["false_positives_per_minute"] == objects["wrong_per_minute"]
    assert record["edge_error_m"]["median"] == drive.record.scores["perception.edge_error_10m_m.median"]
    (difference,) = told["differences"]
    assert difference["lane_error_m"]["difference"] == 0.0
    assert store.read(out).rows == store.read(run).rows
    assert cli.run(["check", str(run), "--rules", str(_rules(tmp_path))]) == 0


def _rules(folder: Path) -> Path:
    path = folder / "rules.toml"
    path.write_text("[[rules]]\nperception.edge_error_m_at_most = 0.5\nperception.foe_error_px_p95_at_most = 300\n")
    return path


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["gone"], "gone: expected a run folder, got nothing of that name"),
        (["RUN", "--driver", "pid"], "driver 'pid': expected one that perceives, got one that uses no frames"),
        (["RUN", "--driver", "vfp"], "unknown driver 'vfp': did you mean 'vpf'?"),
        (
            ["RUN", "--against", "gone.json"],
            "gone.json: expected a table of perception, got: No such file or directory",
        ),
        (["RUN", "--id", "other"], "unknown drive 'other'"),
    ],
)
def test_wrong_use_is_one_line(
    arguments: list[str], sentence: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["perception", *(str(run) if word == "RUN" else word for word in arguments)]) == 2
    said = capsys.readouterr()
    assert said.err.startswith(f"vpf-sim: {sentence}")
    assert (said.err.count("\n"), said.out) == (1, "")


@pytest.mark.usefixtures("in_one_process")
def test_the_fixed_set_is_driven_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = Plan((str(write_short(tmp_path)),), ("clear",), ("pid",), "3:4")
    monkeypatch.setattr(store, "fixed_set", lambda: plan)
    monkeypatch.chdir(tmp_path)
    lines = []
    for _ in range(2):
        assert cli.run(["perception", "--id", "other"]) == 2
        lines.append(capsys.readouterr().err.splitlines())
    (folder,) = (tmp_path / "runs").iterdir()
    assert lines[0][0] == f"driving the 1 drives of the fixed set once: runs/{folder.name}"
    assert lines[1] == lines[0][-1:], "the second time nothing is driven"
    assert [drive.record.status for drive in store.stored_drives([folder])] == ["success"]


def test_a_run_without_steps_or_with_changed_scenarios_is_refused(run: Path, tmp_path: Path) -> None:
    text = (run / "manifest.json").read_text()
    (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(InputError, match="expected at least one episode with steps, got none"):
        store.stored_drives([tmp_path])
    (tmp_path / "episodes.jsonl").write_bytes((run / "episodes.jsonl").read_bytes())
    stored = json.loads(text)
    stored["weathers"]["rain"] = "other"
    (tmp_path / "manifest.json").write_text(json.dumps(stored))
    with pytest.raises(InputError, match=r"manifest\.json: weathers changed since the run: rain: was \"other\", is"):
        store.stored_drives([tmp_path])


def test_the_fixed_set_is_of_development_seeds_in_clear_and_rain() -> None:
    jobs = store.fixed_set().jobs()
    assert {job.driver for job in jobs} == {"vpf"}
    assert {job.weather for job in jobs} == {"clear", "rain"}
    assert all(job.seed < 1000 for job in jobs)
    assert len(jobs) == len({job.id for job in jobs}) == 20
