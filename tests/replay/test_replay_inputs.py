"""A replay resumes only with equal inputs; drives may have any name."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import recorded_layouts as layouts

from vpf_sim import cli
from vpf_sim.evaluation import parquet
from vpf_sim.replay import readers, replay_folder
from vpf_sim.replay.frame_table import FrameRow
from vpf_sim.replay.records import ReplayPlan

ODD_NAMES = ["../outside", 'commute\\08:30 "hi"?*', "con", "/tmp/vpf_sim_outside"]
LAYOUTS: dict[str, Callable[[Path], Path]] = {
    "general": lambda folder: layouts.general(folder / "drive"),
    "kitti odometry": layouts.kitti_odometry,
    "kitti raw": layouts.kitti_raw,
    "comma2k19": lambda folder: layouts.comma2k19(folder / "segment"),
    "radiate": lambda folder: layouts.radiate(folder / "drive"),
    "udacity": lambda folder: layouts.udacity(folder / "drive"),
}


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a drive and the driver's variant, and a replay of it."""
    folder = tmp_path_factory.mktemp("stored")
    layouts.general(folder / "cam")
    (folder / "own.toml").write_text("[road_edges]\nlanes = 3\n")
    assert replay(folder, "neutral", "--out", str(folder / "run")) == 0
    return folder


def replay(folder: Path, driver: str, *more: str) -> int:
    return cli.run(["replay", str(folder / "cam"), "--driver", driver, "--no-video", *more])


@pytest.fixture
def place(stored: Path, tmp_path: Path) -> Path:
    """A copy of all that, that may be changed."""
    shutil.copytree(stored, tmp_path / "place")
    return tmp_path / "place"


def another_video(folder: Path) -> None:
    layouts.video(folder / "cam" / "drive.mp4", [layouts.picture(k + 1) for k in range(layouts.FRAMES)])


def edited(name: str, old: str, new: str) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        text = (folder / "cam" / name).read_text()
        assert old in text
        (folder / "cam" / name).write_text(text.replace(old, new, 1))

    return edit


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (another_video, "the drive 'my drive' changed: drive.mp4"),
        (edited("drive.toml", "wheelbase_m = 2.6", "wheelbase_m = 2.9"), "the drive 'my drive' changed: drive.toml"),
        (edited("signals.csv", ",x\n", ",y\n"), "the drive 'my drive' changed: signals.csv"),
    ],
)
def test_resume_refuses_changed_files_and_keeps_the_folder(
    change: Callable[[Path], None], reason: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = place / "run"
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    change(place)
    for more in ([], ["--mixed"]):
        assert replay(place, "neutral", "--out", str(run), "--resume", *more) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"vpf-sim: {run}: --resume: {reason}")
        assert said.endswith("; start a new run\n")
        assert said.count("\n") == 1
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


def test_resume_accepts_unchanged_inputs(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "cam" / "unrelated notes").write_text("mine")
    assert replay(place, "neutral", "--out", str(place / "run"), "--resume", "--json") == 0
    assert [drive["name"] for drive in json.loads(capsys.readouterr().out)["drives"]] == ["my drive"]


def test_resume_compares_the_code_of_a_custom_driver(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = "test_replay_inputs:Mine"
    assert replay_folder.manifest(ReplayPlan(driver=mine, drives={}), []).drivers.keys() == {mine}
    driver = f"vpf@{place / 'own.toml'}"
    assert replay(place, driver, "--out", str(place / "second")) == 0
    (place / "own.toml").write_text("[road_edges]\nlanes = 4\n")
    capsys.readouterr()
    assert replay(place, driver, "--out", str(place / "second"), "--resume") == 2
    assert "--resume: drivers changed: vpf@own.toml: was " in capsys.readouterr().err


def test_resume_does_not_depend_on_the_working_folder(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def replayed(prefix: str, *more: str) -> int:
        files = ["--driver", f"vpf@{prefix}own.toml", "--water", f"{prefix}wet.toml", "--faults", f"{prefix}late.toml"]
        given = [f"{prefix}cam", *files, "--no-video", "--out", f"{prefix}again"]
        return cli.run(["replay", *given, "--json", *more])

    (place / "wet.toml").write_text("droplets = 30.0\n")
    (place / "late.toml").write_text('base = "straight"\n[ego.sensor_faults]\nlatency_ms = 100.0\n')
    (place / "other").mkdir()
    monkeypatch.chdir(place)
    assert replayed("") == 0
    first = json.loads(capsys.readouterr().out)
    monkeypatch.chdir(place / "other")
    assert replayed("../", "--resume") == 0
    assert json.loads(capsys.readouterr().out)["drives"] == first["drives"], "nothing is replayed again"
    (place / "wet.toml").write_text("droplets = 40.0\n")
    assert replayed("../", "--resume") == 2
    assert "--resume: weathers changed: wet.toml: was " in capsys.readouterr().err


@pytest.mark.parametrize("manifest", ["[]", '"a"', "{", '{"plan": [], "drivers": 3}'])
def test_resume_of_a_spoilt_manifest_is_one_line(
    manifest: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / "run" / "manifest.json").write_text(manifest)
    assert replay(place, "neutral", "--out", str(place / "run"), "--resume") == 2
    said = capsys.readouterr().err
    assert said.startswith(f"vpf-sim: {place / 'run'}")
    assert said.count("\n") == 1


def test_a_folder_of_an_earlier_version_is_read(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It lacks keys and columns that came later, and has some that this version does not know."""
    record = json.loads((place / "run" / "replays.jsonl").read_text())
    lacked = ("mounting", "speed_interval", "warnings")
    stored = {key: value for key, value in record.items() if key not in lacked} | {"shadows": 3}
    (place / "run" / "replays.jsonl").write_text(json.dumps(stored) + "\n")
    table = place / "run" / "frames" / "my drive.parquet"
    columns = [name for name in FrameRow._fields if not name.startswith("obstacles")]
    parquet.write(parquet.read(table, columns, "frames", "frame"), columns, table)
    assert replay(place, "neutral", "--out", str(place / "run"), "--resume", "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)["drives"]
    assert found == {**record, "mounting": None, "speed_interval": None, "warnings": []}


@pytest.mark.parametrize(("key", "value"), [("frames", "many"), ("perception", None), ("origins", {"camera": 3})])
def test_a_record_that_is_none_is_one_line(
    key: str, value: object, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = place / "run" / "replays.jsonl"
    file.write_text(json.dumps(json.loads(file.read_text()) | {key: value}) + "\n")
    assert replay(place, "neutral", "--out", str(place / "run"), "--resume") == 2
    said = capsys.readouterr().err
    assert said.startswith(f'vpf-sim: {file}: "my drive": {key}')
    assert said.count("\n") == 1


@pytest.mark.parametrize("layout", LAYOUTS)
def test_changed_image_changes_the_hash_in_each_layout(layout: str, tmp_path: Path) -> None:
    recording = readers.read(LAYOUTS[layout](tmp_path))
    before = replay_folder.of_recording(recording)
    files = [path for path in sorted(tmp_path.rglob("*")) if path.suffix in (".png", ".jpg", ".mp4", ".hevc")]
    for one in files:
        one.write_bytes(one.read_bytes() + b"\0")
    after = replay_folder.of_recording(recording)
    name = files[0].name if files[0].suffix in (".mp4", ".hevc") else "images"
    assert replay_folder.changed(before, after, ("read", "derived")) == name


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Drives with odd names in drive.toml, two equal ones, two that differ in case; and their replay."""
    folder, made = tmp_path_factory.mktemp("many"), layouts.general(tmp_path_factory.mktemp("made") / "drive")
    for k, name in enumerate([*ODD_NAMES, "same", "same", "Same", "same-2"]):
        drive = shutil.copytree(made, folder / f"d{k:02d}")
        text = (drive / "drive.toml").read_text()
        lines = [line for line in text.splitlines() if not line.startswith("name")]
        (drive / "drive.toml").write_text("\n".join([lines[0], f"name = {json.dumps(name)}", *lines[1:]]) + "\n")
    run = folder / "runs" / "run"
    drives = sorted(str(path) for path in folder.glob("d*"))
    assert cli.run(["replay", *drives, "--driver", "neutral", "--no-video", "--out", str(run)]) == 0
    return folder, run


def test_names_in_drive_toml_cannot_leave_the_folder(many: tuple[Path, Path]) -> None:
    folder, run = many
    records = [json.loads(line) for line in (run / "replays.jsonl").read_text().splitlines()]
    names = [record["name"] for record in records]
    assert names[: len(ODD_NAMES)] == ODD_NAMES
    tables = {path.name for path in folder.rglob("*.parquet")}
    assert {run / "frames" / name for name in tables} == set(run.rglob("*.parquet")) == set(folder.rglob("*.parquet"))
    assert tables == {f"{record['file']}.parquet" for record in records}
    assert len({name.casefold() for name in tables}) == len(records) == len(ODD_NAMES) + 4
    assert not any(set(name) & set('/\\:*?"<>|\n') for name in tables)
    assert not Path("/tmp/vpf_sim_outside.parquet").exists()


def test_two_drives_of_one_name_get_different_files(many: tuple[Path, Path]) -> None:
    records = [json.loads(line) for line in (many[1] / "replays.jsonl").read_text().splitlines()]
    assert [record["name"] for record in records[-4:]] == ["same", "same-2", "Same-3", "same-2-2"]
