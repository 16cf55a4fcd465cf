"""A run folder is used from any working folder, after its scenario and weather files changed, and after a copy."""

import json
import os
import shutil
from pathlib import Path

import pytest
from one_process import one_process
from short_scenario import SHORT, write_short
from stored import record, store

import vpf_sim
from vpf_sim import cli, scenarios
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import make_plan
from vpf_sim.evaluation.sweeps.run_folder import located
from vpf_sim.reporting.run_data import open_run

pytestmark = pytest.mark.usefixtures("in_one_process")
NAME = "short.toml"
DRIVERS = {"neutral", "vpf@mine.toml"}


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of files that are named from their own folder."""
    root = tmp_path_factory.mktemp("project")
    write_short(root, goal_m=6.0)
    (root / "wet.toml").write_text('base = "ClearNoon"\nwetness = 40.0\n')
    (root / "mine.toml").write_text('base = "robust"\n')
    with pytest.MonkeyPatch.context() as patch, one_process():
        patch.chdir(root)
        vpf_sim.sweep(NAME, weather="wet.toml", driver=sorted(DRIVERS), seeds="0:1", out="run", progress=False)
    return root


@pytest.fixture
def elsewhere(driven: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The run from another working folder; another file has the scenario's name there."""
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / NAME).write_text(SHORT.replace("length_m = 80", "length_m = 60"))
    monkeypatch.chdir(tmp_path / "other")
    return Path(shutil.copytree(driven / "run", tmp_path / "copy"))


def test_a_video_is_that_of_the_run(elsewhere: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = list(open_run(elsewhere).records)
    assert {one.driver for one in open_run(elsewhere).records.values()} == DRIVERS
    for name in names:
        assert cli.run(["video", str(elsewhere), "--id", name]) == 0
        said = capsys.readouterr().err
        assert "vpf-sim:" not in said, "frames and commands are those of the run"


def test_scores_are_computed_on_the_road_of_the_run(elsewhere: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["score", str(elsewhere), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["changed"] == []


def test_a_report_draws_the_paths_and_claims_no_change(elsewhere: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["report", str(elsewhere), "--clips", "0"]) == 0
    html = (elsewhere / "report.html").read_text("utf-8")
    assert "Not drawn" not in html
    assert "changed since the run" not in html
    assert "cannot" not in capsys.readouterr().err


def test_what_drivers_perceive_is_measured_on_the_frames_of_the_run(
    elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["perception", str(elsewhere)]) == 0
    assert "2/2 short" in capsys.readouterr().err


def test_a_resumed_run_needs_its_files_and_says_where_they_were(
    driven: Path, elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(NAME).unlink()
    assert cli.run(["sweep", "--resume", "--out", str(elsewhere)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"--resume: expected the file {NAME}, got none of that name; the run was made in {driven}" in said


@pytest.mark.parametrize(
    ("name", "named"), [("vpf@mine.toml", "mine.toml"), ("student:Mine", "student:Mine"), ("onnx:net.onnx", "net.toml")]
)
def test_a_resumed_run_needs_its_drivers_and_says_where_they_were(
    name: str, named: str, driven: Path, elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (Path.cwd() / "wet.toml").write_bytes((driven / "wet.toml").read_bytes())
    file = elsewhere / "manifest.json"
    file.write_text(file.read_text("utf-8").replace('"neutral"', f'"{name}"'))
    assert cli.run(["sweep", "--resume", "--out", str(elsewhere)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert named in said
    assert said.endswith(f"; the run was made in {driven}\n")


def test_a_plan_whose_files_have_other_folders_says_where_the_run_was_made(
    driven: Path, elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = ["--scenario", str(driven / NAME), "--weather", str(driven / "wet.toml"), "--driver", "neutral"]
    assert cli.run(["sweep", *files, "--seeds", "0:1", "--out", str(elsewhere), "--resume"]) == 2
    said = capsys.readouterr().err
    assert "--resume: plan changed: " in said
    assert f"; the run was made in {driven}; start a new run" in said


def test_a_class_that_is_not_found_here_says_where_the_run_was_made(
    driven: Path, elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (elsewhere / "episodes.jsonl").read_text("utf-8")
    manifest = (elsewhere / "manifest.json").read_text("utf-8")
    (elsewhere / "manifest.json").write_text(manifest.replace('"neutral"', '"student:Mine"'))
    old = next(name for name in open_run(elsewhere).records if "neutral" in name)
    new = Job(NAME, "wet.toml", "student:Mine", 0).id
    text = lines.replace(f'"{old}"', f'"{new}"').replace('"neutral"', '"student:Mine"')
    (elsewhere / "episodes.jsonl").write_text(text)
    (elsewhere / "steps" / f"{old}.parquet").rename(elsewhere / "steps" / f"{new}.parquet")
    assert cli.run(["video", str(elsewhere), "--id", new]) == 0
    said = capsys.readouterr().err
    assert "without the driver's view: driver 'student:Mine': cannot import 'student'" in said
    assert f"; the run was made in {driven}" in said


@pytest.mark.parametrize("text", ["torn", "[]", '{"scenarios": {"short.toml": 7}}'])
def test_kept_inputs_that_are_broken_are_one_line(
    text: str, elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (elsewhere / "inputs.json").write_text(text)
    assert cli.run(["score", str(elsewhere)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "inputs.json: " in said


@pytest.mark.parametrize("name", scenarios.names())
def test_a_scenario_is_kept_whole(name: str) -> None:
    scenario = scenarios.load(name)
    kept = json.loads(json.dumps(scenarios.as_table(scenario)))
    assert repr(scenarios.of_table(kept, "kept")) == repr(scenario)


def begun(path: Path, began: str | None, written_s: int) -> None:
    """A run that says when it began, in a manifest of another time."""
    store(
        path, make_plan({"scenario": ["town04"], "weather": ["clear"], "driver": ["pid"], "seeds": "0:1"}, "test"), []
    )
    manifest = json.loads((path / "manifest.json").read_text("utf-8"))
    (path / "manifest.json").write_text(json.dumps({**manifest, **({} if began is None else {"begun": began})}))
    os.utime(path / "manifest.json", (written_s, written_s))


def test_the_latest_run_is_the_one_that_began_last_whatever_was_copied_when(tmp_path: Path) -> None:
    begun(tmp_path / "a", "2026-03-07T10:00:00.5+01:00", 100)
    begun(tmp_path / "restored", "2026-03-07T09:00:00.25+00:00", 900)
    begun(tmp_path / "yesterday", "2026-03-06", 950)
    begun(tmp_path / "unknown", None, 990)
    assert located(tmp_path / "latest") == tmp_path / "a"


def test_a_new_run_says_when_it_began_to_the_moment(driven: Path, tmp_path: Path) -> None:
    shutil.copytree(driven / "run", tmp_path / "older")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(driven)
        vpf_sim.drive(NAME, driver="neutral", out=tmp_path / "newer")
    os.utime(tmp_path / "newer" / "manifest.json", (0, 0))
    assert located(tmp_path / "latest") == tmp_path / "newer"


def test_a_run_without_its_steps_says_so(elsewhere: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As docs/gate.md advises for baselines."""
    name = next(iter(open_run(elsewhere).records))
    shutil.rmtree(elsewhere / "steps")
    for command in (["video", str(elsewhere), "--id", name], ["export", str(elsewhere), "--format", "minari"]):
        assert cli.run(command) == 2
        said = capsys.readouterr().err.splitlines()[-1]
        assert f"lost its steps: {elsewhere / 'steps'}{os.sep}" in said
        assert said.endswith(".parquet is gone")
    with pytest.raises(vpf_sim.InputError, match="lost its steps"):
        vpf_sim.Run(elsewhere).steps(name)
    assert cli.run(["report", str(elsewhere)]) == 0
    assert "lost its steps" in capsys.readouterr().err
    html = (elsewhere / "report.html").read_text("utf-8")
    assert f"2 driven episodes have no steps in {elsewhere / 'steps'} any more" in html
    assert "never began" not in html
    assert "As a video" not in html


def test_of_an_episode_that_never_began_the_steps_are_not_missed(tmp_path: Path) -> None:
    job = Job("town04", "clear", "pid", 0)
    plan = make_plan({"scenario": ["town04"], "weather": ["clear"], "driver": ["pid"], "seeds": "0:1"}, "test")
    run = open_run(store(tmp_path / "run", plan, [record(job, status="error", steps=0)]))
    assert run.why_no_steps(job.id) == "never began (error)"
