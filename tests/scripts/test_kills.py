"""Sweeps killed at random moments and resumed: none loses, repeats or changes an episode."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts" / "kill_sweeps.py"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the script finds workers in /proc")
def test_killed_sweeps_resume_to_the_same_records(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--rounds", "3", "--seed", "1", "--out", str(tmp_path / "kills")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "3 of 3 rounds equal to the undisturbed sweep of 12 episodes, 0 lost"
