"""Repeated sweeps: equal to the last bit, and each verified."""

import subprocess
import sys
from pathlib import Path

import pytest
from run_script import run_script

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.mark.slow
def test_repeated_sweeps_are_equal_and_verified(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPTS / "repeat_sweeps.py"), "--rounds", "2", "--out", str(tmp_path / "repeats")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "2 of 2 runs equal, 2 of 2 verified"


@pytest.mark.parametrize("script", ["repeat_sweeps.py", "kill_sweeps.py"])
def test_a_folder_that_exists_is_refused_in_one_line(script: str, tmp_path: Path) -> None:
    done = run_script(SCRIPTS / script, "--out", tmp_path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == f"{script}: error: --out: expected a new folder, got {tmp_path}"
    assert "Traceback" not in done.stderr
