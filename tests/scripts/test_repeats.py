"""Repeated sweeps: equal to the last bit, and each verified."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts" / "repeat_sweeps.py"


@pytest.mark.slow
def test_repeated_sweeps_are_equal_and_verified(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--rounds", "2", "--out", str(tmp_path / "repeats")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "2 of 2 runs equal, 2 of 2 verified"
