"""What the README shows runs, and what it names exists."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PYTHON_BLOCKS = re.findall(r"```python\n(.*?)```\n+prints\n+```text\n(.*?)```", README, re.DOTALL)
COMMANDS = sorted(set(re.findall(r"^vpf-sim ([a-z]+)", README, re.MULTILINE)))


def test_there_is_something_to_run() -> None:
    assert PYTHON_BLOCKS
    assert {"drive", "sweep", "benchmark", "replay"} <= set(COMMANDS)


@pytest.mark.parametrize(("code", "printed"), PYTHON_BLOCKS)
def test_the_example_prints_what_it_claims(code: str, printed: str, tmp_path: Path) -> None:
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.stderr == ""
    assert done.stdout == printed


@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_exist(command: str) -> None:
    run = [sys.executable, "-m", "vpf_sim.cli", command, "--help"]
    done = subprocess.run(run, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split()[:3] == ["Usage:", "vpf-sim", command]


def test_links_and_pictures_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)|src=\"([^\"]+)\"", README):
        path = "".join(target)
        assert path.startswith("https://") or (ROOT / path).exists(), path
