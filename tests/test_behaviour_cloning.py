"""Behaviour cloning: what the training drives record, how decisions are stacked, and a whole training in small."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import policies
import pytest

import vpf_sim
from behaviour_cloning import scenes
from behaviour_cloning.collect import LANE_M, Drive, Settings, collect, drive
from behaviour_cloning.teacher import Teacher
from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver
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


def settings(decisions: int, teacher: str = "pid", model: Path | None = None) -> Settings:
    """The learner, if there is one, has the wheel all the time."""
    return Settings(teacher, MANIFEST, decisions, 0.0 if model is None else 1.0, model)


def test_scenes_follow_from_their_seeds_and_are_of_all_kinds() -> None:
    drawn = [scenes.draw(seed) for seed in range(80)]
    assert drawn == [scenes.draw(seed) for seed in range(80)]
    assert {scene.has_obstacles for scene in drawn} == {True, False}
    assert {"clear", "rain"} < {scene.weather for scene in drawn}
    for seed, scene in enumerate(drawn):
        assert bool(scene.scenario.draw(seed).bodies) == scene.has_obstacles or scene.has_obstacles


def side_by_side(at_the_wheel: str, seconds: float) -> tuple[Command, Command, Command]:
    """The last commands of the teacher, of `expert`, and of the driver that has the wheel in a bend."""
    env = FourLane("curve-left", frames=False)
    observed, _ = env.reset(seed=3)
    asked: list[Driver] = [Teacher("expert"), drivers.create("expert"), drivers.create(at_the_wheel)]
    for driver in asked:
        driver.reset(setup_for(driver, env, 3))
    for _ in range(round(seconds * env.rate_hz)):
        observation = read(observed)
        label, expert, command = (drivers.command_of(driver, observation) for driver in asked)
        observed, *_ = env.step(np.array([command.throttle, command.steering]))
    return label, expert, command


def test_a_teacher_that_has_the_wheel_labels_what_it_does() -> None:
    label, expert, _ = side_by_side("expert", 9.0)
    assert abs(expert.steering) > 0.01, "it steers"
    assert label.steering == pytest.approx(expert.steering, abs=0.003)
    assert label.throttle == expert.throttle


def test_a_teacher_labels_what_to_do_now_whoever_drove_before() -> None:
    """The controller of `expert` integrates, so its own steering leaves the lane's while another keeps it."""
    label, expert, command = side_by_side("pid", 3.0)
    assert abs(expert.steering - command.steering) > 0.1
    assert label.steering == pytest.approx(command.steering, abs=0.05)


def test_a_drive_repeats_and_has_the_manifests_sizes() -> None:
    first, second = (drive((EMPTY_ROAD, settings(12))) for _ in range(2))
    assert first.pictures.shape == (12, 1, 16, 32)
    assert first.states.shape == (12, 1)
    assert first.labels.shape == (12, 2)
    for key in ("pictures", "states", "labels"):
        assert (getattr(first, key) == getattr(second, key)).all()


def test_the_teacher_labels_what_the_learner_does_wrong(tmp_path: Path) -> None:
    """A learner that turns right at once leaves its lane, while the teacher steers more and more to the left."""
    found = drive((EMPTY_ROAD, settings(400, "pure-pursuit", learner(tmp_path, 0.0, 0.25))))
    assert len(found) < 100, f"it ends where the car is {LANE_M} m off its lane"
    steering = found.labels[:, 1]
    assert steering[-10:].max() < -0.1
    assert (steering != 0.25).all()


def test_a_drive_ends_where_the_learner_stands_for_long_and_the_teacher_would_drive(tmp_path: Path) -> None:
    found = drive((EMPTY_ROAD, settings(400, model=learner(tmp_path, -1.0, 0.0))))
    assert len(found) < 100
    assert found.states[-1] == 0.0
    assert found.labels[-1, 0] > 0.5, "the teacher would drive on"


def test_another_process_drives_the_same() -> None:
    seeds = range(EMPTY_ROAD, EMPTY_ROAD + 1)
    found = [*collect(seeds, settings(4), workers=2)]
    for seed, one in zip(seeds, found, strict=True):
        alone = drive((seed, settings(4)))
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
    for before, after in zip(one, other, strict=True):
        assert torch.allclose(before, after, atol=0.05)


def test_a_network_learns_to_say_where_the_teacher_is_random() -> None:
    """Bright pictures' labels are noise of a known deviation, and dark pictures' are always the same."""
    torch = pytest.importorskip("torch", reason="needs the extra learn")
    from behaviour_cloning.fit import Decisions, answers, fit
    from behaviour_cloning.network import Network

    torch.manual_seed(0)
    rng, count = np.random.default_rng(0), 600
    noisy = np.arange(count) % 2 == 1
    pictures = np.zeros((count, 1, 16, 16), np.uint8)
    pictures[:, :, 8:, :] = np.where(noisy, 200, 20)[:, None, None, None]  # with the light below or above
    pictures[:, :, :8, :] = np.where(noisy, 20, 200)[:, None, None, None]
    labels = np.zeros((count, 2), np.float32)
    labels[noisy, 1] = rng.choice([-0.1, 0.1], noisy.sum())
    decisions = Decisions([Drive(pictures, np.zeros((count, 1), np.float32), labels, "running")], (0,))
    network = Network(1, 16, 16)
    [*fit(network, decisions, 30, 0)]
    stated = answers(network, decisions).deviations
    assert np.median(stated[noisy]) == pytest.approx(0.1 * 2.0**0.5, rel=0.4)
    assert np.median(stated[~noisy]) < 0.02


def test_the_errors_of_unsure_answers_are_compared_with_those_of_the_others() -> None:
    pytest.importorskip("torch", reason="needs the extra learn")
    from behaviour_cloning.fit import Answers, unsure_ratio

    deviations = np.arange(20, dtype=np.float32)
    errors = np.where(deviations >= 18.0, 0.6, 0.2).astype(np.float32)
    assert unsure_ratio(Answers(errors, deviations)) == pytest.approx(3.0)


def test_a_training_in_small_writes_a_policy_that_drives(tmp_path: Path) -> None:
    """And the exported model answers as the network does."""
    pytest.importorskip("torch", reason="needs the extra learn")
    tiny = [
        "--teacher",
        "pid",
        "--rounds",
        "2",
        "--drives",
        "1",
        "--decisions",
        "40",
        "--epochs",
        "1",
        "--workers",
        "1",
    ]
    command = [sys.executable, "-W", "ignore", EXAMPLES / "train_bc.py", "out", *tiny]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "round 1: seeds 2:3, learner 50%" in done.stdout
    model = tmp_path / "out" / "policy.onnx"
    assert model.stat().st_size < 2e6
    driver = drivers.create(f"onnx:{model}")
    training = driver.manifest.training  # type: ignore[attr-defined]
    assert training.expert == "pid"
    assert len(training.curve) == 1 + 3
    assert training.seeds == "0:3"
    assert 0 < training.frames <= 3 * 40
    episode = vpf_sim.drive("straight", driver=f"onnx:{model}", seed=1)
    assert episode.status != "error", episode.error
    assert episode.record["uncertainty"]["mean"] > 0.0
