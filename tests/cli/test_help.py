"""Help, version and completion: nothing is cut, and every value is called by what it means."""

import os
import re
import subprocess
import sys
from typing import Any

import pytest
import typer

from vpf_sim import __version__, cli


def commands(command: Any, words: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], Any]]:
    """(words, command) of the program and all commands below it."""
    below = getattr(command, "commands", {}).items()
    return [(words, command), *(found for name, one in below for found in commands(one, (*words, name)))]


COMMANDS = commands(typer.main.get_command(cli.app))


@pytest.mark.parametrize("words", [words for words, _ in COMMANDS], ids=" ".join)
def test_help_has_a_short_option_and_is_not_cut(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    said = []
    for option in ("-h", "--help"):
        assert cli.run([*words, option]) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1]
    usage, _, rest = said[0].partition("\n")
    assert not re.search(r"<\w", rest), "a value is called by its Python type"
    assert usage.startswith(f"Usage: vpf-sim {' '.join(words)}".strip())
    assert not re.search(r"\.\.\.$", rest, re.MULTILINE), "a summary is cut"


@pytest.mark.parametrize(
    ("words", "parameter"),
    [
        pytest.param(words, parameter, id=f"{' '.join(words)} {parameter.name}")
        for words, command in COMMANDS
        for parameter in command.params
        if not getattr(parameter, "is_flag", False)
    ],
)
def test_a_value_is_called_by_what_it_means(words: tuple[str, ...], parameter: Any) -> None:
    """Not by its Python type, such as <str> or <path>."""
    assert words
    assert parameter.help
    assert parameter.metavar


def test_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out == f"vpf-sim {__version__}\n"


def completed(line: str) -> list[str]:
    """What a shell offers at the end of a line, called as bash's completion script does."""
    words = line.split(" ")
    requested = {"_VPF_SIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    done = subprocess.run(
        [sys.executable, "-c", "import sys; sys.argv = ['vpf-sim']; from vpf_sim import cli; cli.main()"],
        env={**os.environ, **requested},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("vpf-sim swe", ["sweep"]),
        ("vpf-sim drive cur", ["curve-left", "curve-right"]),
        ("vpf-sim drive town04 --weather Hard", ["HardRainNight", "HardRainNoon", "HardRainSunset"]),
        ("vpf-sim drive town04 --driver vpf-", ["vpf-paper", "vpf-literal"]),
        ("vpf-sim report --jso", ["--json"]),
    ],
)
def test_a_shell_completes_commands_options_and_names(line: str, offered: list[str]) -> None:
    assert completed(line) == offered


def test_the_completion_script_is_shown() -> None:
    """For a shell that is named, since a test has none to detect."""
    done = subprocess.run(
        [sys.executable, "-m", "vpf_sim.cli", "--show-completion", "bash"],
        env={**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^complete .*vpf-sim$", done.stdout, re.MULTILINE)
    assert "_VPF_SIM_COMPLETE=complete_bash" in done.stdout
