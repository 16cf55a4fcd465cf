"""Commands that are offered run as they stand: every word comes back whole from a shell."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from systems import POSIX_ONLY

from vpf_sim import system
from vpf_sim.evaluation.gate.checks import drive_command
from vpf_sim.evaluation.gate.run_cells import Cell
from vpf_sim.system import command

ROOT = Path(__file__).parents[1]
WRITTEN_OUT = re.compile(r"vpf-sim [a-z]+ (?:--?[a-z]+ )*\{")  # an f-string or a template that fills in a word
WORDS = [
    "plain",
    "two words",
    "it's",
    'say "hi"',
    "$HOME",
    "`id`",
    "a;b",
    "a&b",
    "*",
    "a\nb",
    "~",
    "#1",
    "Köln",
    "a\\b",
]


@pytest.fixture(autouse=True)
def posix(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "WINDOWS", False)  # its commands are in test_system


@POSIX_ONLY
@pytest.mark.parametrize("word", WORDS)
def test_a_shell_gives_each_word_back(word: str) -> None:
    line = command("report", Path(word), out=word, clips=3, no_video=True, mixed=False, water=None)
    words = ["vpf-sim", "report", word, "--out", word, "--clips", "3", "--no-video"]
    assert shlex.split(line) == words
    shown = subprocess.run(
        ["sh", "-c", f"vpf_sim() {{ printf '%s\\0' \"$@\"; }}; {line.replace('vpf-sim', 'vpf_sim', 1)}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert shown.stdout.split("\0")[:-1] == words[1:]


def test_a_path_with_a_dash_in_front_is_no_option() -> None:
    assert shlex.split(command("report", Path("-x"))) == ["vpf-sim", "report", "./-x"]


@POSIX_ONLY
def test_the_seeds_to_drive_again_are_a_loop_that_a_shell_runs() -> None:
    line = drive_command(Cell("my roads/it's.toml", "clear", "pid"), [3, 5])
    shown = subprocess.run(
        ["sh", "-c", f"vpf_sim() {{ printf '%s|' \"$@\"; }}; {line.replace('vpf-sim', 'vpf_sim')}"],
        capture_output=True,
        text=True,
        check=True,
    )
    parts = "drive|my roads/it's.toml|--weather|clear|--driver|pid|--seed|"
    assert shown.stdout == f"{parts}3|{parts}5|"


def test_no_command_is_put_together_elsewhere() -> None:
    """There nobody would quote what a user named."""
    assert WRITTEN_OUT.search("f'vpf-sim report {path}'")
    assert WRITTEN_OUT.search("vpf-sim video {{ folder }}")
    sources = [*(ROOT / "vpf_sim").rglob("*.py"), *(ROOT / "vpf_sim").rglob("*.jinja")]
    assert [path for path in sources if WRITTEN_OUT.search(path.read_text("utf-8"))] == []
