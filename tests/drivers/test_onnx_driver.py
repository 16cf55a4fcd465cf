"""Learned drivers: a policy's answers are the commands, at its rate and of its frames; what does not fit is refused."""

import re
import sys
from math import isnan
from pathlib import Path

import numpy as np
import policies
import pytest
from onnx import TensorProto
from policies import MANIFEST
from short_scenario import write_short

import vpf_sim
from vpf_sim import cli, configuration, drivers
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.learned.driver import OnnxDriver, shrink
from vpf_sim.drivers.learned.manifest import Crop, Manifest, PictureInput
from vpf_sim.envs.ego import MAX_SPEED_MPS, YAW_RATE_LIMIT_RADPS
from vpf_sim.envs.learning import FourLanePixels
from vpf_sim.policy_state import SPEED_SCALE_MPS, STATE, YAW_RATE_SCALE_RADPS, policy_state
from vpf_sim.types import Camera, Image, VehicleModel

SETUP = DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (150.0, 0.0), 0)
NO_STATE = MANIFEST.partition("[state]")[0]


def frame(level: int = 90, image: Image | None = None) -> Observation:
    if image is None:
        image = np.full((480, 640, 3), level, np.uint8)
    return Observation(image, 0.0, 0.0, 0.0, 0.0, 5.55, 0.0, (150.0, 0.0))


@pytest.fixture
def constant(tmp_path: Path) -> Path:
    return policies.write(tmp_path, policies.constant(0.25, -0.125))


def test_a_drives_commands_are_the_policys_answers(constant: Path, tmp_path: Path) -> None:
    episode = vpf_sim.drive(write_short(tmp_path), driver=f"onnx:{constant}")
    assert len(episode.steps) > 50
    assert set(episode.steps["throttle"].dropna()) == {0.25}
    assert set(episode.steps["steering"].dropna()) == {-0.125}


def test_an_answer_beyond_full_throttle_is_full_throttle(tmp_path: Path) -> None:
    driver = OnnxDriver(policies.write(tmp_path, policies.constant(7.0, -7.0)))
    driver.reset(SETUP)
    command = driver.act(frame())
    assert (command.throttle, command.steering) == (1.0, -1.0)


@pytest.mark.parametrize(("rate_hz", "held"), [(60.0, 1), (20.0, 3), (5.0, 12), (100.0, 1)])
def test_a_command_is_held_between_decisions(rate_hz: float, held: int, tmp_path: Path) -> None:
    """By a policy that adds an eighth to its last throttle at each decision."""

    def edit(text: str) -> str:
        return text.replace("20.0", str(rate_hz))

    driver = OnnxDriver(policies.write(tmp_path, policies.last_action_plus(0.125, 0.0), edit=edit))
    driver.reset(SETUP)
    throttles, due = [], [True]
    for _ in range(4 * held):
        throttles.append(driver.act(frame()).throttle)
        due.append(driver.needs_next_frame)
    assert throttles == [0.125 * (1 + step // held) for step in range(4 * held)]
    assert due == [step % held == 0 for step in range(4 * held + 1)], "frames are drawn for decisions only"


def test_an_episode_begins_without_memory_of_the_last(tmp_path: Path) -> None:
    driver = OnnxDriver(policies.write(tmp_path, policies.last_action_plus(0.125, 0.0)))
    for _ in range(2):
        driver.reset(SETUP)
        assert [driver.act(frame()).throttle for _ in range(4)] == [0.125, 0.125, 0.125, 0.25]


def test_frames_of_earlier_decisions_are_stacked_in_the_order_of_the_manifest(tmp_path: Path) -> None:
    """Levels of 51 k at decision k: first channel two decisions ago, last channel now; before the first, the first."""
    manifest = NO_STATE.replace("[image]", "[image]\nframes_ago = [2, 0]")
    path = policies.write(tmp_path, policies.ends_of_the_picture(), manifest, inputs=[("image", (1, 2, 6, 8))])
    driver = OnnxDriver(path)
    driver.reset(SETUP)
    answers = []
    for step in range(12):
        command = driver.act(frame(51 * (1 + step // 3)))
        answers.append([round(command.throttle, 6), round(command.steering, 6)])
    assert answers[::3] == [[0.2, 0.2], [0.2, 0.4], [0.2, 0.6], [0.4, 0.8]]


def test_without_a_frame_the_last_command_is_held(tmp_path: Path) -> None:
    driver = OnnxDriver(policies.write(tmp_path, policies.last_action_plus(0.125, 0.0), edit=lambda t: t))
    driver.reset(SETUP)
    nothing = frame(image=np.empty((0, 0, 3), np.uint8))
    assert [driver.act(nothing).throttle for _ in range(3)] == [0.0, 0.0, 0.0]
    assert driver.act(frame()).throttle == 0.125
    assert [driver.act(nothing).throttle for _ in range(3)] == [0.125] * 3


def test_a_policy_of_the_state_alone_needs_no_frames(tmp_path: Path) -> None:
    manifest = 'schema = 1\nrate_hz = 60.0\n[state]\nvalues = ["speed", "yaw_rate"]\n'
    path = policies.write(tmp_path, policies.last_action_plus(0.0, 0.0), manifest, inputs=[("state", (1, 2))])
    driver = OnnxDriver(path)
    assert not drivers.uses_images(driver)
    driver.reset(SETUP)
    assert driver.act(frame()).throttle == pytest.approx(5.55 / MAX_SPEED_MPS)


def test_the_state_is_that_of_the_environment_to_learn_in() -> None:
    assert (SPEED_SCALE_MPS, YAW_RATE_SCALE_RADPS) == (MAX_SPEED_MPS, YAW_RATE_LIMIT_RADPS)
    env = FourLanePixels(state=True, image_size=(64, 48))
    env.reset(seed=1)
    action = np.array([0.5, 0.125])
    observed = env.step(action)[0]
    assert isinstance(observed, dict)
    ego = env.world.ego
    pose = np.array([*ego.position, ego.heading])
    state = policy_state(pose, ego.speed, ego.yaw_rate_radps, env.world.goal_m, action)
    np.testing.assert_allclose(observed["state"], state, atol=1e-6)
    assert len(STATE) == len(state)


def unsure(folder: Path, uncertainty: str) -> Path:
    policy = policies.unsure_as_the_picture_ends(0.25, 0.5)
    manifest = f"{NO_STATE}[uncertainty]\n{uncertainty}\n"
    return policies.write(folder, policy, manifest, inputs=[("image", (1, 1, 6, 8))], more_outputs=["deviation"])


def test_a_policy_states_how_unsure_it_is_of_its_command(tmp_path: Path) -> None:
    """The deviation of the steering, which is the picture's grey level here, by the limit of a quarter."""
    driver = OnnxDriver(unsure(tmp_path, "limit = 0.25"))
    driver.reset(SETUP)
    assert isnan(driver.uncertainty()), "before the first decision"
    stated = []
    for level in (51, 153, 153, 153):
        assert driver.act(frame(level)).steering == 0.5
        stated.append(driver.uncertainty())
    assert stated == pytest.approx([0.8, 0.8, 0.8, 2.4]), "held with the command"
    driver.reset(SETUP)
    assert isnan(driver.uncertainty())


def test_the_record_keeps_how_unsure_a_policy_was(tmp_path: Path) -> None:
    """Its deviation is between 0 and 1: always above a limit of a thousandth, never above one of 2."""
    scores = []
    for number, limit in enumerate((0.001, 2.0)):
        (folder := tmp_path / str(number)).mkdir()
        model = unsure(folder, f"limit = {limit}")
        episode = vpf_sim.drive(write_short(folder), driver=f"onnx:{model}")
        stated = episode.steps["uncertainty"].dropna()
        assert episode.record["uncertainty"]["mean"] == pytest.approx(stated.mean())
        scores.append(episode.record["uncertainty"])
    assert [one["unsure_share"] for one in scores] == [1.0, 0.0]
    assert scores[0]["max"] == pytest.approx(2000.0 * scores[1]["max"])


def test_a_policy_that_states_nothing_has_no_uncertainty_in_its_record(constant: Path, tmp_path: Path) -> None:
    episode = vpf_sim.drive(write_short(tmp_path), driver=f"onnx:{constant}")
    assert episode.record["uncertainty"] == {"mean": None, "max": None, "unsure_share": None}


def test_an_output_for_the_uncertainty_that_is_missing_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = unsure(tmp_path, 'limit = 0.25\noutput = "doubt"')
    message = "uncertainty.output: expected an output of policy.onnx, 'action' or 'deviation', got 'doubt'"
    assert_refused(path, f"{path.with_suffix('.toml')}: {message}", capsys)
    same = 'limit = 0.25\noutput = "action"'
    message = "uncertainty.output: expected another name than output, got 'action'"
    assert_refused(unsure(tmp_path, same), f"{path.with_suffix('.toml')}: {message}", capsys)


def test_a_frame_is_cropped_and_averaged() -> None:
    """A frame whose lower right quarter has blocks of 20 x 10 pixels, of one grey level each."""
    levels = np.arange(12 * 16).reshape(12, 16)
    image = np.full((240, 640, 3), 255, np.uint8)
    image[120:, 320:] = np.kron(levels, np.ones((10, 20)))[..., None]
    half = Crop(left_share=0.5, top_share=0.5)
    assert (shrink(image, PictureInput(16, 12, crop=half)) == levels).all()
    coarser = shrink(image, PictureInput(8, 6, crop=half))[0]
    np.testing.assert_allclose(coarser, levels.reshape(6, 2, 8, 2).mean(axis=(1, 3)), atol=0.51)


def test_colours_are_the_channels_in_the_order_red_green_blue() -> None:
    image = np.broadcast_to(np.array([10, 20, 30], np.uint8), (48, 64, 3))
    shrunk = shrink(image, PictureInput(8, 6, colour="rgb"))
    assert shrunk.shape == (3, 6, 8)
    assert shrunk[:, 0, 0].tolist() == [10, 20, 30]


def test_grey_levels_are_normalised(tmp_path: Path) -> None:
    manifest = NO_STATE.replace("[image]", "[image]\nmean = 100.0\ndeviation = 200.0")
    driver = OnnxDriver(
        policies.write(tmp_path, policies.ends_of_the_picture(), manifest, inputs=[("image", (1, 1, 6, 8))])
    )
    driver.reset(SETUP)
    assert driver.act(frame(150)).throttle == pytest.approx(0.25)


FAULTS = {
    "rate_hz = 20.0": ("rate_hz = 0.0", "rate_hz: expected > 0, got 0.0"),
    "width_px = 8": ("width_px = 8.5", "image.width_px: expected an integer, got 8.5"),
    "height_px = 6": ("heigth_px = 6", "image.heigth_px: unknown key, did you mean 'height_px'?"),
    '["throttle", "steering"]': ('["throttle", "lane"]', "state.values[1]: expected one of speed, yaw_rate"),
    "schema = 1": ("schema = 2", "schema: expected 1, got 2"),
    "[state]": (
        "[image.crop]\ntop_share = 0.8\nbottom_share = 0.7\n[state]",
        "image.crop.top_share: expected < bottom_share, 0.7, got 0.8",
    ),
}


@pytest.mark.parametrize("old", FAULTS)
def test_a_fault_of_the_manifest_is_one_line(old: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new, message = FAULTS[old]
    path = policies.write(tmp_path, policies.constant(0.0, 0.0), MANIFEST.replace(old, new))
    assert_refused(path, f"{path.with_suffix('.toml')}: {message}", capsys)


def test_a_manifest_needs_an_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = policies.write(tmp_path, policies.constant(0.0, 0.0), "schema = 1\nrate_hz = 20.0\n")
    assert_refused(path, f"{path.with_suffix('.toml')}: expected at least one of [image] and [state]", capsys)


def test_all_that_the_model_has_otherwise_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A line each."""
    manifest = MANIFEST.replace("[image]", 'output = "command"\n[image]\ninput = "camera"')
    path = policies.write(tmp_path, policies.constant(0.0, 0.0), manifest)
    assert cli.run(["drive", "straight", "--driver", f"onnx:{path}"]) == 2
    where = path.with_suffix(".toml")
    assert [line.removeprefix("vpf-sim: ") for line in capsys.readouterr().err.splitlines()] == [
        f"{where}: image.input: expected an input of policy.onnx, 'image' or 'state', got 'camera'",
        f"{where}: output: expected an output of policy.onnx, 'action', got 'command'",
    ]


@pytest.mark.parametrize("shape", [(1, 3, 6, 8), (1, 1, 8, 6), (2, 1, 6, 8), (1, 48)])
def test_a_picture_of_another_shape_is_refused(
    shape: tuple[int, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = policies.write(tmp_path, policies.constant(0.0, 0.0), NO_STATE, inputs=[("image", shape)])
    message = f"image: expected the shape of 'image' in policy.onnx, {shape}, got (1, 1, 6, 8)"
    assert_refused(path, f"{path.with_suffix('.toml')}: {message}", capsys)


def test_an_answer_of_another_shape_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = policies.write(tmp_path, policies.constant(0.0, 0.0, 0.0), output=("action", (1, 3)))
    message = "output 'action': expected tensor(float) of shape (1, 2), throttle and steering, got tensor(float) of"
    assert_refused(path, f"{path}: {message} (1, 3)", capsys)


def test_a_picture_of_another_type_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inputs = [("image", (1, 1, 6, 8))]
    path = policies.write(tmp_path, policies.constant(0.0, 0.0), NO_STATE, inputs=inputs, kind=TensorProto.UINT8)
    assert_refused(path, f"{path}: input 'image': expected tensor(float), got tensor(uint8)", capsys)


def test_an_input_that_the_manifest_lacks_is_refused(constant: Path, capsys: pytest.CaptureFixture[str]) -> None:
    constant.with_suffix(".toml").write_text(NO_STATE)
    message = "expected [image] or [state] for each input of policy.onnx, got none for 'state'"
    assert_refused(constant, f"{constant.with_suffix('.toml')}: {message}", capsys)


def test_dimensions_that_the_model_leaves_open_fit(tmp_path: Path) -> None:
    inputs = [("image", ("batch", 1, 6, 8)), ("state", ("batch", 2))]
    driver = OnnxDriver(policies.write(tmp_path, policies.constant(0.25, 0.5), inputs=inputs))
    driver.reset(SETUP)
    assert driver.act(frame()).steering == 0.5


def test_what_is_missing_or_no_model_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "none.onnx"
    assert_refused(path, f"{path.with_suffix('.toml')}: expected a readable policy manifest file", capsys)
    path.with_suffix(".toml").write_text(MANIFEST)
    assert_refused(path, f"{path}: expected a readable ONNX model, got: No such file or directory", capsys)
    path.write_bytes(b"no model")
    assert_refused(path, f"{path}: expected an ONNX model in one file, got: ", capsys)


def test_without_onnxruntime_the_remedy_is_named(
    constant: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    remedy = "expected onnxruntime, which is not installed: pip install 'vpf_sim[onnx]'"
    assert_refused(constant, f"{constant}: {remedy}", capsys)
    assert cli.run(["drivers", "list"]) == 0
    assert "learned-bc" in capsys.readouterr().out


def assert_refused(path: Path, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The command ends with exit code 2 and this one line."""
    assert cli.run(["drive", "straight", "--driver", f"onnx:{path}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.removeprefix("vpf-sim: ").startswith(message), line


def test_the_manifest_of_the_page_is_one() -> None:
    page = (Path(__file__).parents[2] / "docs" / "learning.md").read_text("utf-8")
    (toml,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    manifest = configuration.build(Manifest, configuration.parse(toml, "page"), "page")
    assert manifest.image is not None
    assert manifest.image.shape == (1, 3, 64, 160)
