"""Names of catalogs come before files and folders of the working folder; a path with a separator is a file."""

from pathlib import Path

import pytest
from malformed import SWEEP, WEATHER
from short_scenario import SHORT

from vpf_sim import cli

NAMES = {
    "hard": ["sweep", "hard", "--dry-run"],
    "straight": ["scenarios", "show", "straight"],
    "rain": ["weathers", "show", "rain"],
    "paper": ["drivers", "show", "vpf@paper"],
    "learned-bc": ["drivers", "show", "learned-bc"],
}
FILES = {
    "hard": (SWEEP, ["sweep", "./hard", "--dry-run"], "24 episodes"),
    "straight": (SHORT, ["scenarios", "show", "./straight"], '"s_m": 11.0'),
    "rain": (WEATHER, ["weathers", "show", "./rain"], '"precipitation": 40.0'),
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["folder", "file"])
def test_a_name_means_the_catalogs_whatever_lies_beside(
    name: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    expected = cli.run(NAMES[name]), *capsys.readouterr()
    assert expected[0] == 0, expected
    (tmp_path / name).mkdir() if kind == "folder" else (tmp_path / name).write_text("no TOML")
    assert (cli.run(NAMES[name]), *capsys.readouterr()) == expected


@pytest.mark.parametrize("name", FILES)
def test_a_path_with_a_separator_means_the_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text, command, shown = FILES[name]
    (tmp_path / name).write_text(text)
    assert cli.run(command) == 0
    assert shown in capsys.readouterr().out
