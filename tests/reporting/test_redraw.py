"""A re-rendered episode: frames and plans equal to the run, and a video at true speed."""

import re
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from driven_run import drive_run
from short_scenario import SHORT

from vpf_sim import cli
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.network import RoadLines
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting import episode_view, redraw, top_view
from vpf_sim.reporting.episode_view import Strips, signals_of
from vpf_sim.reporting.redraw import Redrawing, redrawing
from vpf_sim.reporting.run_data import open_run
from vpf_sim.reporting.top_view import Rectangle, Scene
from vpf_sim.types import Plan as DrivingPlan

WEATHER = "rain"
MOVING = SHORT.replace("s_m = 11.0", "s_m = 9.0") + '[[bodies]]\nkind = "car"\ns_m = 22.0\nlane = 3\nspeed_mps = 4.0\n'


@pytest.fixture(scope="module")
def seen() -> list[DrivingPlan | None]:
    """The plans of the run, frame by frame."""
    return []


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory, seen: list[DrivingPlan | None]) -> Path:
    """A drive in the rain behind a moving car."""
    root = tmp_path_factory.mktemp("redraw")
    (root / "moving.toml").write_text(MOVING)
    plan = Plan((str(root / "moving.toml"),), (WEATHER,), ("vpf",), "3:4")
    return drive_run(root / "run", plan, watch=lambda _, plan: seen.append(plan))


@pytest.fixture(scope="module")
def name(driven: Path) -> str:
    (name,) = open_run(driven).records
    return name


@pytest.fixture
def run(driven: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(driven, tmp_path / "run"))


def change(run: Path, name: str, row: int, **values: float) -> None:
    """Another step table, whose rows from this one on differ by so much."""
    path = run / "steps" / f"{name}.parquet"
    rows = steps.read(path).rows.copy()
    for column, value in values.items():
        rows[row:, Step._fields.index(column)] += value
    steps.write(StepTable(rows), path)


def test_the_frames_and_plans_are_those_of_the_run(driven: Path, name: str, seen: list[DrivingPlan | None]) -> None:
    drawn = redrawing(open_run(driven), name, replan=True)
    moments = list(drawn.moments())
    assert drawn.remarks == [], "the hash of the frames is the record's, and the driver decides the same"
    assert (drawn.rate_hz, len(moments)) == (60.0, len(drawn.table) + 1)
    assert len(seen) == len(drawn.table)
    for moment, plan in zip(moments, seen, strict=False):
        assert moment.plan is not None
        assert plan is not None
        assert np.array_equal(moment.plan.perception.flow.points_px, plan.perception.flow.points_px)
        assert moment.plan.reference == plan.reference
    assert moments[-1].plan is None, "no command was given in the last state"
    ahead_m = [moment.objects[0].x_m for moment in moments]
    assert np.diff(ahead_m) == pytest.approx(4.0 / 60.0, abs=0.01), "the car ahead drives"


def test_the_car_is_drawn_at_the_stored_poses(run: Path, name: str) -> None:
    change(run, name, 20, y_m=0.5)
    drawn = redrawing(open_run(run), name, replan=False)
    assert len(list(drawn.moments())) == len(drawn.table) + 1
    frames, moved = drawn.remarks
    assert frames.startswith("the frames differ from the run's")
    assert moved == "the car would now deviate by up to 0.50 m; its stored poses are drawn"


def test_the_first_frame_with_another_command_is_reported(run: Path, name: str) -> None:
    change(run, name, 30, throttle=-0.01)
    drawn = redrawing(open_run(run), name, replan=True)
    assert list(drawn.moments())
    assert "from frame 30 on the driver's commands differ from the run" in drawn.remarks


def test_an_episode_is_drawn_without_a_driver_that_is_gone(run: Path, name: str) -> None:
    """As one of a notebook, or of a module that has moved."""
    stored = open_run(run)
    table = stored.steps(name)
    assert table is not None
    drawn = Redrawing(stored.record(name).model_copy(update={"driver": "no_such_module:Mine"}), table, replan=True)
    assert all(moment.plan is None for moment in drawn.moments())
    (remark,) = drawn.remarks
    assert remark.startswith("without the driver's view: driver 'no_such_module:Mine': cannot import")


class Crashing:
    """A driver that breaks down after a while."""

    privileged = "none"

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        self.count = 0

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        self.count += 1
        if self.count > 5:
            raise ZeroDivisionError("no more")
        return Command(0.0, 0.0)


class FailsAtReset(Crashing):
    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        raise ZeroDivisionError("not again")


class FailsAtTrace(Crashing):
    def trace(self) -> None:
        raise ZeroDivisionError("no plan")


@pytest.mark.parametrize(
    ("driver", "remark"),
    [
        (FailsAtReset, "without the driver's view: its reset fails: ZeroDivisionError: not again"),
        (FailsAtTrace, "the driver fails on frame 0: ZeroDivisionError: no plan"),
    ],
)
def test_a_driver_that_fails_only_now_is_one_remark(
    driver: type, remark: str, monkeypatch: pytest.MonkeyPatch, driven: Path, name: str
) -> None:
    stored = open_run(driven)
    table = stored.steps(name)
    assert table is not None
    create = redraw.drivers.create
    monkeypatch.setattr(redraw.drivers, "create", lambda name: driver() if name == "failing" else create(name))
    drawn = Redrawing(stored.record(name).model_copy(update={"driver": "failing"}), table, replan=True)
    assert all(moment.plan is None for moment in drawn.moments())
    assert drawn.remarks == [remark]


def test_a_failed_drivers_episode_is_drawn_to_its_end(monkeypatch: pytest.MonkeyPatch, driven: Path, name: str) -> None:
    scenario = open_run(driven).record(name).scenario
    create = redraw.drivers.create
    monkeypatch.setattr(redraw.drivers, "create", lambda name: Crashing() if name == "crashing" else create(name))
    result = episode.run(scenario, "clear", "crashing", 3)
    assert result.record.status == "error"
    drawn = Redrawing(result.record, result.steps, replan=True)
    assert [moment.index for moment in drawn.moments()] == list(range(6))
    assert drawn.remarks == [], "the frame on which it broke down was taken, too"


def test_an_episode_becomes_a_video_at_true_speed(driven: Path, name: str, tmp_path: Path, capsys: Any) -> None:
    out = tmp_path / "mine.mp4"
    assert cli.run(["video", str(driven), "--id", name, "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    table = open_run(driven).steps(name)
    assert table is not None
    with av.open(str(out)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert (stream.average_rate, stream.frames) == (60, len(table) + 1)
        assert (stream.width, stream.height) == (960, 720)
    content = out.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")


def test_without_overlay_the_frame_is_unchanged(driven: Path, name: str) -> None:
    plain, drawn = (redrawing(open_run(driven), name, replan) for replan in (False, True))
    wanted = 12
    pictures = [next(episode_view.frames(each, lambda row: row == wanted))[1] for each in (plain, drawn)]
    raw = next(moment.image for moment in plain.moments() if moment.index == wanted)
    top = episode_view.TITLE_PX
    left = [picture[top : top + 480, :640] for picture in pictures]
    assert np.array_equal(left[0], raw)
    assert not np.array_equal(left[1], raw)


def test_the_default_file_is_in_the_run_folder(driven: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def few(drawn: Redrawing) -> Iterator[tuple[int, Any]]:
        return ((0, np.zeros((720, 960, 3), np.uint8)) for _ in range(1) if drawn)

    monkeypatch.setattr(episode_view, "frames", few)
    assert cli.run(["video", str(driven), "--id", name, "--no-overlay"]) == 0
    assert (driven / "videos" / f"{name}.mp4").exists()


def test_an_incomplete_video_is_removed(
    driven: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(drawn: Redrawing) -> Iterator[tuple[int, Any]]:
        yield 0, np.zeros((720, 960, 3), np.uint8)
        assert list(tmp_path.iterdir()) != [], "a draft"
        raise KeyboardInterrupt(drawn)

    monkeypatch.setattr(episode_view, "frames", broken)
    assert cli.run(["video", str(driven), "--id", name, "--no-overlay", "--out", str(tmp_path / "mine.mp4")]) == 130
    assert list(tmp_path.iterdir()) == []


def test_wrong_use_is_one_line(run: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    (run / "steps" / f"{name}.parquet").rename(run / "steps" / "other.parquet")
    cases = (
        (["video", str(run / "gone"), "--id", name], r"gone: expected a run folder, got nothing of that name"),
        (["video", str(run), "--id", name[:-1] + "4"], rf"unknown episode of .*: did you mean '{re.escape(name)}'\?"),
        (["video", str(run), "--id", name], rf"got one that lost its steps: .*{re.escape(name)}\.parquet is gone"),
        (["video", str(run)], r"Missing option '--id'"),
    )
    for arguments, said in cases:
        assert cli.run(arguments) == 2
        error = capsys.readouterr().err
        assert re.search(said, error), error
        assert error.count("\n") == 1
    (run / "steps" / f"{name}.parquet").write_text("torn")
    assert cli.run(["video", str(run), "--id", name]) == 2
    assert "expected a step table of this version" in capsys.readouterr().err


def test_top_view_has_the_road_ahead_up_and_right_to_the_right() -> None:
    """A road along the world's Y axis, driven along it: what lies at larger y is ahead, what at smaller x is right."""
    along = np.arange(-50.0, 150.0, 2.0)
    left, right = (np.column_stack([np.full_like(along, -right), along]) for right in (-7.0, 7.0))
    scene = Scene(RoadLines(((left, right),), (left, right), ()), left, (0.0, 500.0))
    objects = (Rectangle(-4.0, 30.0, np.pi / 2.0, 5.0, 2.0, "car"),)
    pose = np.array([0.0, 0.0, np.pi / 2.0])
    image = top_view.draw(scene, objects, np.zeros((1, 2)), pose, None, 320, 480)
    scale = 480.0 / (top_view.AHEAD_M + top_view.BEHIND_M)
    row, column = (top_view.AHEAD_M - 30.0) * scale, 160.0 + 4.0 * scale
    assert tuple(image[round(row), round(column)]) == top_view.OBJECT
    assert tuple(image[round(top_view.AHEAD_M * scale), 160]) == top_view.EGO
    assert tuple(image[round(row), round(160.0 - 4.0 * scale)]) == top_view.ASPHALT
    assert tuple(image[round(row), round(160.0 + 9.0 * scale)]) == top_view.MEADOW


def test_the_scene_equals_the_environments(driven: Path, name: str) -> None:
    record = open_run(driven).record(name)
    with closing(FourLane(record.scenario)) as world:
        world.reset(seed=3)
        scene = redraw.scene_of(world)
        centre, lines = world.road.network.centre, scene.lines
        (strip,) = lines.strips_m
        sides = [[centre.local_at(*line[40])[1] for line in found] for found in (strip, lines.solid_m, lines.dashed_m)]
    assert np.concatenate(sides) == pytest.approx([-7.0, 7.0, -7.0, 7.0, -3.5, 0.0, 3.5])
    assert scene.goal_m == world.goal_m


def test_the_strips_cursor_goes_from_one_end_to_the_other(driven: Path, name: str) -> None:
    table = open_run(driven).steps(name)
    assert table is not None
    assert [signal.name for signal in signals_of(table)][:3] == ["throttle", "steering", "speed"]
    strips = Strips(table, 400, 200)
    first, last = strips.at(0), strips.at(len(table))
    assert min(*first[60, 12], *last[60, 188]) > 200 > max(*first[60, 188], *last[60, 12])
    assert not np.array_equal(first, last)
