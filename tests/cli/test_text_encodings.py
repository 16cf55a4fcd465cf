"""Text files as editors and shells of Windows save them: with a byte order mark, also in UTF-16."""

import codecs
import json
from pathlib import Path

import pytest
import recorded_layouts as layouts
from malformed import RULES, SCENARIO, SWEEP, WEATHER
from short_scenario import SHORT
from stored import record, store

from vpf_sim import cli
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.reporting.run_data import open_run

ENCODINGS = {
    "utf-8": lambda text: codecs.BOM_UTF8 + text.encode(),
    "utf-16-le": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "utf-16-be": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "windows line ends": lambda text: codecs.BOM_UTF8 + text.replace("\n", "\r\n").encode(),
}
COMMANDS = {
    "scenario.toml": (SCENARIO, ["scenarios", "validate", "scenario.toml"]),
    "base.toml": ('base = "straight"\n', ["scenarios", "show", "base.toml"]),
    "weather.toml": (WEATHER, ["weathers", "validate", "weather.toml"]),
    "sweep.toml": (SWEEP, ["sweep", "sweep.toml", "--dry-run"]),
    "variant.toml": ('base = "paper"\n', ["drivers", "show", "vpf@variant.toml"]),
    "rules.toml": (RULES.replace("0.9", "0.0"), ["check", "run", "--rules", "rules.toml"]),
    "compared.toml": ('[[rules]]\nno_worse_than = "before.json"\n', ["check", "run", "--rules", "compared.toml"]),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a run and its summary."""
    monkeypatch.chdir(tmp_path)
    plan = Plan(("straight",), ("clear", "rain"), ("vpf",), "0:3")
    run = store(tmp_path / "run", plan, [record(job) for job in plan.jobs()])
    for file in (run / "summary.json", tmp_path / "before.json"):
        write_json(file, open_run(run).summary().as_json())
    return tmp_path


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_marked_file_is_read_as_one_without_a_mark(
    name: str, encoding: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, command = COMMANDS[name]
    (folder / name).write_text(text)
    expected = cli.run(command), *capsys.readouterr()
    assert expected[0] in (0, 1), expected
    (folder / name).write_bytes(ENCODINGS[encoding](text))
    assert (cli.run(command), *capsys.readouterr()) == expected


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("name", ["summary.json", "manifest.json"])
def test_a_marked_file_of_a_run_is_read(
    name: str, encoding: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["results", "run"]
    capsys.readouterr()
    expected = cli.run(command), *capsys.readouterr()
    assert expected[0] == 0, expected
    file = folder / "run" / name
    file.write_bytes(ENCODINGS[encoding](json.dumps(json.loads(file.read_text()), indent=1)))
    assert (cli.run(command), *capsys.readouterr()) == expected


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_recorded_drive_with_marks_is_read(encoding: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive = layouts.general(tmp_path / "drive")
    scores = []
    for out in ("plain", "marked"):
        command = ["replay", str(drive), "--driver", "neutral", "--no-video", "--json", "--out", str(tmp_path / out)]
        assert cli.run(command) == 0
        scores.append(json.loads(capsys.readouterr().out)["drives"])
        if out == "plain":
            for file in (drive / "drive.toml", drive / "signals.csv"):
                file.write_bytes(ENCODINGS[encoding](file.read_text()))
    assert scores[0] == scores[1]


def test_text_that_is_neither_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "short.toml"
    for content in (codecs.BOM_UTF16_LE + b"\x00", SHORT.encode("utf-16-le"), codecs.BOM_UTF8 * 2 + SHORT.encode()):
        file.write_bytes(content)
        assert cli.run(["scenarios", "validate", str(file)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"vpf-sim: {file}: expected ")
