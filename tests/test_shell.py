"""Commands that are offered run as they stand: every word comes back whole from a shell."""

import shlex
import subprocess
from pathlib import Path

import pytest

from vpf_sim.evaluation.gate.cells import Cell
from vpf_sim.evaluation.gate.gate import again
from vpf_sim.shell import command

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


def test_the_seeds_to_drive_again_are_a_loop_that_a_shell_runs() -> None:
    line = again(Cell("my roads/it's.toml", "clear", "pid"), [3, 5])
    shown = subprocess.run(
        ["sh", "-c", f"vpf_sim() {{ printf '%s|' \"$@\"; }}; {line.replace('vpf-sim', 'vpf_sim')}"],
        capture_output=True,
        text=True,
        check=True,
    )
    parts = "drive|my roads/it's.toml|--weather|clear|--driver|pid|--seed|"
    assert shown.stdout == f"{parts}3|{parts}5|"
