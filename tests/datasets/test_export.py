"""Which episodes are exported, the data sheet, and what is refused: nothing half is left."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from driven_short import STOPS_AT, Driven

import vpf_sim
from vpf_sim import cli
from vpf_sim.datasets import export, formats, lerobot, minari_format
from vpf_sim.datasets.datasheet import spans
from vpf_sim.datasets.played_episode import Contents
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.reporting.run_data import RunData, open_run

pytestmark = pytest.mark.usefixtures("in_one_process")
SMALL = ["--format", "minari", "--size", "32x24", "--grey"]


@pytest.fixture
def run(driven: Driven, tmp_path: Path) -> Path:
    """A copy of the run."""
    return Path(shutil.copytree(driven.path, tmp_path / "run"))


def test_the_data_sheet_says_what_is_in_the_set(driven: Driven, lerobot_set: Path, minari_set: Path) -> None:
    sheets = [(folder / "README.md").read_text("utf-8") for folder in (lerobot_set, minari_set)]
    assert sheets[0].startswith("---\ntags:\n- LeRobot\n")
    assert sheets[1].startswith("# run: drives of vpf_sim as a minari data set\n")
    for sheet in sheets:
        assert f"2 episodes, {len(driven.table) + STOPS_AT} frames with an action, 60 frames" in sheet
        assert f"| short | rain | weaves | 3 | 1 | {len(driven.table)} | 1 success |" in sheet
        assert f"| short | rain | breaks | 3 | 1 | {STOPS_AT} | 1 error |" in sheet
        assert f"Left out: 1.\n- {driven.ids['never']}: never began (error)" in sheet
        assert "In 1 of 2 episodes the pictures have the hash" in sheet
        assert "In 1 the driver used no frames" in sheet
        assert f"vpf_sim {vpf_sim.__version__}, commit " in sheet
        for word in ("MIT licence", "m/s", "yaw clockwise", "drawn, not photographed"):
            assert word in sheet


def test_the_command_says_where_the_set_is_and_what_was_left_out(
    run: Path, driven: Driven, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["export", str(run), *SMALL, "--status", "success", "--workers", "1", "--json"]) == 0
    said = capsys.readouterr()
    answer = json.loads(said.out)
    assert answer == {
        "out": str(run / "minari"),
        "format": "minari",
        "episodes": 1,
        "frames": len(driven.table),
        "left_out": {driven.ids["never"]: "never began (error)", driven.ids["breaks"]: "ended in error"},
        "remarks": [],
    }
    assert f"vpf-sim: left out: {driven.ids['never']}: never began (error)\n" in said.err
    assert f"1/1 {driven.ids['weaves']}\n" in said.err
    assert cli.run(["export", str(run), *SMALL]) == 2
    assert capsys.readouterr().err == f"vpf-sim: {run}/minari: expected the name of a new folder: got one that exists\n"


def test_pictures_that_differ_from_the_run_are_remarked(
    run: Path, driven: Driven, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [json.loads(line) for line in (run / "episodes.jsonl").read_text().splitlines()]
    for line in lines:
        line["frames_sha256"] = line["frames_sha256"] and "0" * 64
    (run / "episodes.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert cli.run(["export", str(run), *SMALL, "--workers", "1", "--json"]) == 0
    said = capsys.readouterr()
    (remark,) = json.loads(said.out)["remarks"]
    assert remark.startswith(f"{driven.ids['weaves']}: the frames differ from the run's")
    assert f"vpf-sim: {remark}\n" in said.err
    sheet = (run / "minari" / "README.md").read_text("utf-8")
    assert "In 0 of 2 episodes the pictures have the hash" in sheet
    assert remark in sheet


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["gone"], "gone: expected a run folder, got nothing of that name"),
        (["run", "--format", "hdf5"], "unknown format 'hdf5': known: lerobot, minari"),
        (["run", "--format", "lerobo"], "unknown format 'lerobo': did you mean 'lerobot'?"),
        (["run", "--size", "84"], "--size: expected WIDTHxHEIGHT in pixels, such as 84x84, got '84'"),
        (["run", "--size", "85x84"], "--size: expected even sides, which its videos need, got 85x84"),
        (
            ["run", "--truth", "depth"],
            "--truth: expected none, since this format holds no arrays; --format minari holds",
        ),
        (["run", "--status", "sucess"], "unknown status of the episodes of run 'sucess': did you mean 'success'?"),
        (["run", "--out", "no/set"], "--out: no/set: expected a folder that exists, found no no"),
    ],
)
def test_wrong_use_is_one_line_and_leaves_nothing(
    arguments: list[str], said: str, run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(run.parent)
    before = sorted(run.parent.rglob("*"))
    assert cli.run(["export", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"vpf-sim: {said}"), error
    assert error.count("\n") == 1
    assert sorted(run.parent.rglob("*")) == before


def test_a_run_without_a_driven_episode_is_refused(run: Path) -> None:
    lines = [json.loads(line) for line in (run / "episodes.jsonl").read_text().splitlines()]
    (run / "episodes.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines if not line["steps"]))
    with pytest.raises(InputError, match="expected at least one driven episode to export, got none"):
        vpf_sim.export(run)


def test_an_unfinished_run_is_remarked(run: Path, driven: Driven) -> None:
    lines = (run / "episodes.jsonl").read_text().splitlines()
    (run / "episodes.jsonl").write_text("".join(line + "\n" for line in lines if driven.ids["weaves"] in line))
    found = vpf_sim.export(run, "minari", size=(32, 24), workers=1)
    assert found.remarks == ["the run is not complete: 1 of 3 episodes are driven"]


def test_steps_that_are_not_those_of_the_record_are_refused(run: Path, driven: Driven) -> None:
    shutil.copy(run / "steps" / f"{driven.ids['breaks']}.parquet", run / "steps" / f"{driven.ids['weaves']}.parquet")
    with pytest.raises(InputError, match=f"expected the {len(driven.table)} steps of its record, got {STOPS_AT}"):
        vpf_sim.export(run, "minari", size=(32, 24), workers=1)
    assert not list(run.glob("minari*"))


@pytest.mark.parametrize("fault", [KeyboardInterrupt, OSError])
def test_an_interrupted_export_leaves_nothing(fault: type[BaseException], run: Path) -> None:
    def interrupt(line: str) -> None:
        assert (run / "set.draft").is_dir()
        raise fault(line)

    data, contents = RunData.of(open_run(run)), Contents.of((32, 24), True, ())
    with pytest.raises(fault):
        export.export(data, "minari", minari_format.Minari(), run / "set", contents, (), 1, interrupt)
    assert not list(run.glob("set*"))


def test_a_draft_of_another_process_is_not_touched(run: Path) -> None:
    (run / "minari.draft").mkdir()
    with pytest.raises(
        InputError, match=r"minari\.draft: expected the name of a new folder: another process writes it"
    ):
        vpf_sim.export(run, "minari", size=(32, 24))
    assert [path.name for path in run.glob("minari*")] == ["minari.draft"]


@pytest.mark.parametrize(
    ("form", "library"), [(lerobot.LeRobot(), "pyarrow"), (minari_format.Minari(), "h5py")], ids=["lerobot", "minari"]
)
def test_a_missing_library_is_named_with_its_remedy(
    form: formats.Format, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError) as caught:
        form.check(Contents())
    assert str(caught.value) == f"export: expected {library}, which is not installed: pip install 'vpf_sim[export]'"


def test_no_driver_is_needed(run: Path, driven: Driven) -> None:
    """Of a driver that is gone there are records and steps."""
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["plan"]["driver"] = ["gone", "breaks", "never"]
    manifest["privileged"]["gone"] = "none"
    lines = [json.loads(line) for line in (run / "episodes.jsonl").read_text().splitlines()]
    for line in lines:
        if line["id"] == driven.ids["weaves"]:
            line["driver"], line["id"] = "gone", line["id"].replace("weaves", "gone")
            (run / "steps" / f"{driven.ids['weaves']}.parquet").rename(run / "steps" / f"{line['id']}.parquet")
    write_json(run / "manifest.json", manifest)
    (run / "episodes.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    found = vpf_sim.export(run, "minari", size=(32, 24), status=["success"], workers=1)
    assert (found.episodes, found.remarks) == (1, [])


def test_numbers_are_written_as_spans() -> None:
    assert spans([3, 0, 1, 2, 7, 9, 8]) == "0 to 3, 7 to 9"
    assert spans([5]) == "5"
