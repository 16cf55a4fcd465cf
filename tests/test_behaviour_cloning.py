"""Behaviour cloning: what the training drives record, how decisions are stacked, and a whole training in small."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import policies
import pytest

import vpf_sim
from behaviour_cloning import scenes
from behaviour_cloning.collect import LANE_M, Drive, collect, drive
from behaviour_cloning.expert import Expert
from vpf_sim import drivers
from vpf_sim.drivers.learned.manifest import Crop, Manifest, PictureInput, StateInput
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for

EXAMPLES = Path(__file__).parents[1] / "examples"
MANIFEST = Manifest(
    schema=1,
    rate_hz=20.0,
    image=PictureInput(width_px=32, height_px=16, frames_ago=(2, 0), crop=Crop(top_share=0.5)),
    state=StateInput(values=("speed",)),
)
EMPTY_ROAD = next(seed for seed in range(50) if not scenes.draw(seed).has_obstacles)
TOML = """schema = 1
rate_hz = 20.0
[image]
width_px = 32
height_px = 16
frames_ago = [2, 0]
crop = {top_share = 0.5}
[state]
values = ["speed"]
"""


def learner(folder: Path, throttle: float, steering: float) -> Path:
    """A learner that always does the same."""
    inputs = [("image", (1, 2, 16, 32)), ("state", (1, 1))]
    return policies.write(folder, policies.constant(throttle, steering), TOML, inputs=inputs)


def test_scenes_follow_from_their_seeds_and_are_of_all_kinds() -> None:
    drawn = [scenes.draw(seed) for seed in range(80)]
    assert drawn == [scenes.draw(seed) for seed in range(80)]
    assert {scene.has_obstacles for scene in drawn} == {True, False}
    assert {"clear", "rain"} < {scene.weather for scene in drawn}
    for seed, scene in enumerate(drawn):
        assert bool(scene.scenario.draw(seed).bodies) == scene.has_obstacles or scene.has_obstacles


def test_the_expert_is_idm_or_steers_as_pure_pursuit_on_an_empty_road() -> None:
    env = FourLane("curve-left", frames=False)
    observed, _ = env.reset(seed=3)
    made = {name: drivers.create(name) for name in ("idm", "pure-pursuit")}
    experts = {has_obstacles: Expert(has_obstacles) for has_obstacles in (True, False)}
    for one in (*made.values(), *experts.values()):
        one.reset(setup_for(one, env, 3))
    observation = read(observed)
    idm, pursuit = (one.act(observation) for one in made.values())
    assert experts[True].act(observation) == idm
    assert experts[False].act(observation) == replace(pursuit, throttle=idm.throttle)
    assert idm.steering != pursuit.steering


def test_a_drive_repeats_and_has_the_manifests_sizes() -> None:
    first, second = (drive((EMPTY_ROAD, 0.0, None, MANIFEST, 12)) for _ in range(2))
    assert first.pictures.shape == (12, 1, 16, 32)
    assert first.states.shape == (12, 1)
    assert first.labels.shape == (12, 2)
    for key in ("pictures", "states", "labels"):
        assert (getattr(first, key) == getattr(second, key)).all()


def test_the_expert_labels_what_the_learner_does_wrong(tmp_path: Path) -> None:
    """A learner that turns right at once leaves its lane, while the expert steers more and more to the left."""
    task = (EMPTY_ROAD, 1.0, learner(tmp_path, 0.0, 0.25), MANIFEST, 400)
    found = drive(task)
    assert len(found) < 100, f"it ends where the car is {LANE_M} m off its lane"
    steering = found.labels[:, 1]
    assert steering[-10:].max() < -0.1
    assert (steering != 0.25).all()


def test_a_drive_that_stands_for_long_ends(tmp_path: Path) -> None:
    found = drive((EMPTY_ROAD, 1.0, learner(tmp_path, -1.0, 0.0), MANIFEST, 400))
    assert len(found) < 100
    assert found.states[-1] == 0.0
    assert found.labels[-1, 0] > 0.5, "the expert would drive on"


def test_another_process_drives_the_same() -> None:
    seeds = range(EMPTY_ROAD, EMPTY_ROAD + 1)
    found = [*collect(seeds, 0.0, None, MANIFEST, 4, workers=2)]
    for seed, one in zip(seeds, found, strict=True):
        alone = drive((seed, 0.0, None, MANIFEST, 4))
        assert (one.labels == alone.labels).all()
        assert (one.pictures == alone.pictures).all()


def recorded(level: int, count: int) -> Drive:
    """A drive whose k-th picture has the grey level `level` + k."""
    levels = np.arange(level, level + count, dtype=np.uint8)
    pictures = np.broadcast_to(levels[:, None, None, None], (count, 1, 4, 6)).copy()
    return Drive(pictures, np.zeros((count, 1), np.float32), np.ones((count, 2), np.float32), "running")


def test_decisions_stack_frames_of_their_own_drive_only() -> None:
    pytest.importorskip("torch", reason="needs the extra learn")
    from behaviour_cloning.fit import Decisions

    decisions = Decisions([recorded(10, 4), recorded(100, 3)], (2, 0))
    stacked = np.round(255.0 * decisions.stacked(np.arange(7))[:, :, 0, 0])
    assert stacked.tolist() == [[10, 10], [10, 11], [10, 12], [11, 13], [100, 100], [100, 101], [100, 102]]


def test_a_mirrored_decision_steers_to_the_other_side() -> None:
    pytest.importorskip("torch", reason="needs the extra learn")
    from behaviour_cloning.fit import mirror

    pictures = np.arange(24, dtype=np.float32).reshape(2, 1, 3, 4)
    labels = np.array([[0.5, 0.25], [0.5, 0.25]], np.float32)
    before = pictures.copy()
    mirror(pictures, labels, np.array([True, False]))
    assert labels.tolist() == [[0.5, -0.25], [0.5, 0.25]]
    assert (pictures[0] == np.flip(before[0], axis=-1)).all()
    assert (pictures[1] == before[1]).all()


def test_the_network_does_not_answer_to_brightness_and_contrast() -> None:
    torch = pytest.importorskip("torch", reason="needs the extra learn")
    from behaviour_cloning.network import Network

    network = Network(3, 64, 160).eval()
    picture, speed = torch.rand(1, 3, 64, 160), torch.full((1, 1), 0.09)
    with torch.no_grad():
        one, other = network(picture, speed), network(2.0 * picture + 5.0, speed)
    assert torch.allclose(one, other, atol=0.05)


def test_a_training_in_small_writes_a_policy_that_drives(tmp_path: Path) -> None:
    """And the exported model answers as the network does."""
    pytest.importorskip("torch", reason="needs the extra learn")
    tiny = ["--rounds", "2", "--drives", "1", "--decisions", "40", "--epochs", "1", "--workers", "1"]
    command = [sys.executable, "-W", "ignore", EXAMPLES / "train_bc.py", "out", *tiny]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "round 1: seeds 2:3, learner 50%" in done.stdout
    model = tmp_path / "out" / "policy.onnx"
    assert model.stat().st_size < 2e6
    driver = drivers.create(f"onnx:{model}")
    training = driver.manifest.training  # type: ignore[attr-defined]
    assert training.seeds == "0:3"
    assert 0 < training.frames <= 3 * 40
    episode = vpf_sim.drive("straight", driver=f"onnx:{model}", seed=1)
    assert episode.status != "error", episode.error
