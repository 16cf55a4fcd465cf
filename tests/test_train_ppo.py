"""PPO: a whole training in small writes a policy that drives, with a throttle that holds the speed."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import vpf_sim

SCRIPT = Path(__file__).parents[1] / "examples" / "train_ppo.py"
SPEED_MPS = 5.55


def test_a_training_in_small_writes_a_policy_that_drives(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra learn")
    tiny = ["--steps", "64", "--steps-of-an-update", "32", "--worlds", "1", "--test-seeds", "0:1"]
    command = [sys.executable, "-W", "ignore", SCRIPT, "out", *tiny]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    episode = vpf_sim.drive("straight", driver=f"onnx:{tmp_path / 'out' / 'policy.onnx'}", seed=1)
    assert episode.status != "error", episode.error
    decisions = episode.steps.iloc[:-1:12]
    np.testing.assert_allclose(decisions["throttle"], SPEED_MPS - decisions["speed_mps"], atol=1e-5)


def test_a_training_that_is_stopped_says_so(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra learn")
    tiny = ["--steps", "640", "--stop-at", "64", "--steps-of-an-update", "32", "--worlds", "1", "--test-seeds", "0:1"]
    command = [sys.executable, "-W", "ignore", SCRIPT, "out", *tiny]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    training = tomllib.loads((tmp_path / "out" / "policy.toml").read_text())["training"]
    assert training["frames"] == 64
    assert "--steps 640 --stop-at 64" in training["command"]
