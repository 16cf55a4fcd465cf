"""The parts that differ on Windows, switched on by the one flag that selects them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from vpf_sim import cli, system
from vpf_sim.evaluation.gate.checks import drive_command
from vpf_sim.evaluation.gate.run_cells import Cell
from vpf_sim.system import command

ROOT = Path(__file__).parents[1]
FOLDERS = ("vpf_sim", "controllers", "envs", "scenarios")
SOURCES = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
POSIX_ONLY = (
    r"^\s*(?:import|from) (?:fcntl|grp|pwd|resource|termios)\b"
    r"|\bos\.(?:fork|kill|killpg|nice|setsid|set_blocking|symlink|uname)\("
)


def windows_words(line: str) -> list[str]:
    """The arguments that a program gets on Windows, by the documented rules of CommandLineToArgvW."""
    words, word, inside, i = [], None, False, 0
    while i < len(line):
        slashes = len(line[i:]) - len(line[i:].lstrip("\\"))
        i += slashes
        if i < len(line) and line[i] == '"':
            word = (word or "") + "\\" * (slashes // 2)
            if slashes % 2:
                word += '"'
            else:
                inside = not inside
            i += 1
            continue
        if slashes:
            word = (word or "") + "\\" * slashes
        elif line[i] in " \t" and not inside:
            words, word, i = words + [word] * (word is not None), None, i + 1
        else:
            word, i = (word or "") + line[i], i + 1
    return words + [word] * (word is not None)


WORDS = ["plain", "C:\\My runs\\a", "two words", "ends in\\", "a&b\\", 'say "hi"', 'a\\"b', "it's", "50% off", ""]


@pytest.mark.parametrize("word", WORDS)
def test_windows_gives_each_word_back(word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "WINDOWS", True)
    words = ["vpf-sim", word, "--clips", "3"]
    assert windows_words(system.quoted(words)) == words


@pytest.mark.parametrize("word", ["a&b", "a|b", "a>b", "(a)", "a;b", "a^b"])
def test_characters_that_cmd_interprets_are_inside_quotes(word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "WINDOWS", True)
    assert command("report", word) == f'vpf-sim report "{word}"'


def test_the_rerun_of_a_failed_check_is_a_loop_of_the_users_shell(monkeypatch: pytest.MonkeyPatch) -> None:
    cell, drive = Cell("town04", "clear", "pid"), "vpf-sim drive town04 --weather clear --driver pid --seed"
    assert drive_command(cell, [3, 5]) == f"for seed in 3 5; do {drive} $seed; done"
    monkeypatch.setattr(system, "WINDOWS", True)
    assert drive_command(cell, [3, 5]) == f"foreach ($seed in 3, 5) {{ {drive} $seed }}"


@pytest.mark.parametrize("windows", [False, True])
def test_a_restart_keeps_environment_and_exit_code(windows: bool) -> None:
    child = "import os, sys; print(os.environ['GIVEN']); sys.exit(5)"
    code = (
        f"import os, sys; from vpf_sim import system; system.WINDOWS = {windows}\n"
        f"system.replace_process([sys.executable, '-c', {child!r}], {{**os.environ, 'GIVEN': 'here'}})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (5, "here\n", "")


@pytest.mark.parametrize("windows", [False, True])
def test_the_command_line_limits_its_threads_on_every_system(windows: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    class Restarted(Exception):  # noqa: N818
        pass

    def restart(words: list[str], environment: dict[str, str]) -> None:
        assert words[1:] == ["-P", "-m", "vpf_sim.cli", "drive", "town04"]
        assert environment["OMP_NUM_THREADS"] == "1"
        raise Restarted

    monkeypatch.setattr(system, "WINDOWS", windows)
    monkeypatch.setattr(system, "replace_process", restart)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setattr(sys, "argv", ["vpf-sim", "drive", "town04"])
    with pytest.raises(Restarted):
        cli.main()


def test_no_source_needs_a_posix_system() -> None:
    found = {path: re.findall(POSIX_ONLY, path.read_text("utf-8"), re.M) for path in SOURCES}
    assert {path: calls for path, calls in found.items() if calls} == {}


def test_no_text_is_read_or_written_in_the_systems_own_encoding(tmp_path: Path) -> None:
    """Windows' own encoding is not UTF-8; Python warns of each text file without an encoding."""
    environment = {**os.environ, "PYTHONWARNDEFAULTENCODING": "1", "PYTHONWARNINGS": "error::EncodingWarning:vpf_sim"}
    code = "from vpf_sim import cli; raise SystemExit(cli.run(['drivers', 'list']) or cli.run(['scenarios', 'list']))"
    done = subprocess.run([sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
