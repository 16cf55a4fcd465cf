"""The command line: exit codes, one-line errors, and JSON output."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from short_scenario import write_short

from vpf_sim import cli


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["drvie"], "No such command 'drvie'. Did you mean 'drive', 'drivers', 'video'?"),
        (["drive"], "Missing argument 'SCENARIO'."),
        (["drive", "town04", "--sed", "3"], "No such option: --sed (Possible options: --seed)"),
        (["drive", "town05"], "unknown scenario 'town05': did you mean 'town04'?"),
        (["drive", "twon04-clean"], "unknown scenario 'twon04-clean': did you mean 'town04-clean'?"),
        (["drive", "town04", "--weather", "claer"], "unknown weather 'claer': did you mean 'clear'?"),
        (["drive", "town04", "--driver", "vfp"], "unknown driver 'vfp': did you mean 'vpf'?"),
        (["drive", "town04", "--driver", "nowhere:Mine"], "driver 'nowhere:Mine': cannot import 'nowhere'"),
        (["drive", "town04", "--seed", "-3"], "Invalid value for '--seed'"),
        (["drive", "missing.toml"], "missing.toml: expected a readable scenario file"),
        (["sweep", "--seeds", "5:2"], "--seeds: expected A:B with A below B, got '5:2', which holds no seed"),
        (["sweep", "--seeds", "5"], "--seeds: expected A:B with whole numbers, such as 1000:1030, got '5'"),
        (["sweep", "--seeds", "0:99999999999999"], "--seeds: expected at most 1000000 seeds, got '0:99999999999999'"),
        (["sweep", "--scenario", "twon04"], "unknown scenario 'twon04': did you mean 'town04'?"),
        (["sweep", "--dry-run", "--weather", "claer"], "unknown weather 'claer': did you mean 'clear'?"),
        (["sweep", "--dry-run", "--workers", "2", "--cluster", "tcp://x:1"], "--workers: expected --workers or --clus"),
        (["sweep", "--workers", "0"], "Invalid value for '--workers'"),
        (["sweep", "--resume"], "--resume: expected the folder of the run in --out, got none"),
        (["sweep", "--resume", "--out", "gone"], "gone: --resume: expected the folder of a run, found nothing"),
        (
            ["sweep", "--resume", "--out", "."],
            ".: --resume: expected the manifest.json of a run, found none; name what to",
        ),
        (["benchmark", "--resume", "--out", "gone"], "gone: --resume: expected the folder of a run, found nothing"),
        (["sweep", "missing.toml"], "missing.toml: expected a readable sweep file"),
        (["benchmark", "--seeds", "a:b"], "--seeds: expected A:B with whole numbers"),
        (["benchmark", "--driver", "pdi"], "unknown driver 'pdi': did you mean 'pid'?"),
        (["check", "gone", "--rules", "rules.toml"], "gone: expected a run folder, got nothing of that name"),
        (["score"], "Missing argument 'RUN'."),
        (["score", "gone"], "gone/manifest.json: expected the manifest of a run, got: No such file or directory"),
        (["doctor", "--profile", "--scenario", "town05"], "unknown scenario 'town05': did you mean 'town04'?"),
        (["doctor", "--steps", "60"], "--steps: expected together with --profile, got it alone"),
        (["scenarios", "show", "slalon"], "unknown scenario 'slalon': did you mean 'slalom'?"),
        (["drivers", "show", "pdi"], "unknown driver 'pdi': did you mean 'pid'?"),
        (["weathers", "show", "claer"], "unknown weather 'claer': did you mean 'clear'?"),
    ],
)
def test_wrong_use_is_one_clear_line(
    arguments: list[str],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    code = cli.run(arguments)
    said = capsys.readouterr()
    assert code == 2
    assert said.out == ""
    assert said.err.startswith(f"vpf-sim: {sentence}")
    assert said.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == [], "nothing is left behind"


def test_watch_is_refused_without_a_display(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SDL_VIDEODRIVER", "offscreen")
    assert cli.run(["drive", "straight", "--watch"]) == 2
    assert "no display" in capsys.readouterr().err


def test_drive_prints_one_json_object_and_its_exit_code_is_the_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.run(["drive", str(write_short(tmp_path)), "--driver", "pid", "--seed", "4", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["timing"].keys() == {"wall_s", "steps_per_s"}
    (out,) = (tmp_path / "runs").iterdir()
    stored = json.loads((out / "episodes.jsonl").read_text())
    assert stored == {key: value for key, value in record.items() if key != "timing"}
    assert stored["status"] == "success"


DRIVER = """
from vpf_sim import Command

class Broken:
    privileged = "none"
    def reset(self, setup): pass
    def act(self, observation): raise KeyError("lost")

class Chatty(Broken):
    def __init__(self): print("made")
    def act(self, observation):
        print("braking")
        return Command(1.0, 0.0)

class Unmade(Broken):
    def __init__(self): raise RuntimeError("no weights")
"""


def test_a_users_driver_is_found_in_the_working_directory(tmp_path: Path) -> None:
    short = str(write_short(tmp_path))
    (tmp_path / "mine.py").write_text(DRIVER)
    command = [sys.executable, "-m", "vpf_sim.cli", "drive", short, "--driver", "mine:Broken", "--json"]
    broken = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (broken.returncode, json.loads(broken.stdout)["status"]) == (1, "error")
    assert "KeyError: 'lost'" in broken.stderr
    assert "Traceback" not in broken.stderr


@pytest.fixture
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, from which a user's driver is imported, for commands that run in this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    (tmp_path / "mine.py").write_text(DRIVER)
    return tmp_path


def test_prints_of_a_driver_in_a_sweep_do_not_reach_stdout(in_folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Those in a drive: tests/test_process_state.py."""
    grid = ["--scenario", str(write_short(in_folder)), "--driver", "mine:Chatty", "--seeds", "0:1", "--workers", "1"]
    assert cli.run(["sweep", *grid, "--json"]) == 0
    said = capfd.readouterr()
    json.loads(said.out)
    assert "made\n" in said.err
    assert "braking\n" in said.err


def test_a_driver_that_cannot_be_created_is_wrong_input(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["drive", "straight", "--driver", "mine:Unmade"]) == 2
    said = capsys.readouterr()
    assert said.err == "vpf-sim: driver 'mine:Unmade': making it raised RuntimeError: no weights\n"
    assert not (in_folder / "runs").exists()


def test_listings(capsys: pytest.CaptureFixture[str]) -> None:
    for command, key, name in (
        ("scenarios", "scenarios", "town04"),
        ("drivers", "drivers", "vpf"),
        ("weathers", "weathers", "clear"),
    ):
        assert cli.run([command, "list", "--json"]) == 0
        assert name in [row["name"] for row in json.loads(capsys.readouterr().out)[key]]
        assert cli.run([command, "list"]) == 0
        assert name in capsys.readouterr().out
        assert cli.run([command, "show", name]) == 0
        json.loads(capsys.readouterr().out)
    assert cli.run(["drivers", "validate", "pid"]) == 0


def test_a_stopped_drive_leaves_no_empty_run_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object) -> None:
        assert (tmp_path / "run" / "manifest.json").exists()
        raise KeyboardInterrupt

    monkeypatch.setattr("vpf_sim.evaluation.episode.episode.run", stop)
    assert cli.run(["drive", "straight", "--driver", "neutral", "--out", str(tmp_path / "run")]) == 130
    assert capsys.readouterr().err == "vpf-sim: stopped by Ctrl-C; the drive is not stored\n"
    assert list(tmp_path.iterdir()) == []


HEAVY = "{'highway_env', 'cv2', 'scipy', 'pandas', 'duckdb', 'pygame', 'av'}"


@pytest.mark.parametrize(
    "arguments", [["--help"], ["drive", "--help"], ["scenarios", "list"], ["drivers", "list"], ["weathers", "list"]]
)
def test_help_and_listings_load_nothing_heavy(arguments: list[str]) -> None:
    code = f"import sys; from vpf_sim import cli; cli.run({arguments}); print('loaded', {HEAVY} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("loaded set()\n")
