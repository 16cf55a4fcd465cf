"""What a camera in a car adds to the picture."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera.onboard.recorder import ExposureControl
from vpf_sim.envs.camera.rig import preset
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError
from vpf_sim.types import Floats, Image

STAY = np.zeros(2)
SILENT = Rig(noise_sd=0.0)


def first(rig: Rig, scenario: str = "straight", truth: tuple[str, ...] = ()) -> tuple[Image, dict[str, Any]]:
    observed, info = FourLane(scenario, "clear", rig=rig, truth=truth).reset(seed=3)
    return np.asarray(observed["image"]), info


def change(**added: Any) -> Floats:
    """(H, W) grey levels by which something changes the first frame."""
    plain, changed = first(SILENT)[0], first(replace(SILENT, **added))[0]
    return np.asarray(cv2.absdiff(plain, changed).max(axis=2), float)


def test_the_bonnet_covers_the_lower_edge_and_hides_it() -> None:
    changed = change(bonnet=True) > 10
    assert changed[440:].mean() > 0.9
    assert not changed[:400].any()
    hidden = first(replace(SILENT, bonnet=True), truth=("hidden",))[1]["hidden"]
    assert hidden[450:].mean() > 0.9
    assert not hidden[:400].any()


def test_dirt_covers_its_share() -> None:
    hidden = first(replace(SILENT, dirt=0.1), truth=("hidden",))[1]["hidden"]
    assert 0.05 < hidden.mean() < 0.12
    assert 0.05 < (change(dirt=0.1) > 5).mean() < 0.25


def test_the_dashboard_is_mirrored_in_the_lower_half() -> None:
    changed = change(reflection=0.2)
    assert changed[:200].max() <= 3.0 + changed[:200].mean()
    assert changed[380:].mean() > 15.0


def test_text_is_burnt_into_the_corner() -> None:
    rows, columns = np.nonzero(change(overlay=True) > 30)
    assert rows.min() > 440
    assert columns.max() < 400


def test_a_compressed_frame_is_near_the_plain_one() -> None:
    rough, fine = change(jpeg_quality=20).mean(), change(jpeg_quality=95).mean()
    assert 0.0 < fine < rough < 12.0


def test_a_rolling_shutter_leans_what_stands_upright_while_the_car_turns() -> None:
    """At a yaw rate w, the scene moves by -fx w pixels a second; rows half a picture apart are T / 2 apart in time."""
    turning = np.array([0.0, 1.0])
    worlds = [FourLane("straight", rig=replace(SILENT, rolling_shutter_ms=ms)) for ms in (0.0, 40.0)]
    for world in worlds:
        world.reset(seed=3)
        for _ in range(30):
            world.step(turning)
    plain, rolled = (world.step(turning)[0]["image"] for world in worlds)
    rate = worlds[0].ego.yaw_rate_radps
    top = slice(100, 130)  # 125 rows above the middle
    expected_px = 320.0 * rate * 0.04 * 125.0 / 480.0
    window = np.hanning(640)[None] * np.ones((30, 1))
    grey = [cv2.cvtColor(picture[top], cv2.COLOR_RGB2GRAY).astype(np.float64) for picture in (plain, rolled)]
    (shift_px, _), _ = cv2.phaseCorrelate(*grey, window)
    assert expected_px > 1.0
    assert shift_px == pytest.approx(expected_px, abs=0.6)


def test_exposure_control_follows_the_scene_with_its_lag() -> None:
    control = ExposureControl(lag_s=0.5)
    means = []
    for tick in range(120):
        frame = np.full((48, 64, 3), 150 if tick < 60 else 75, np.uint8)
        control.apply(frame, tick / 60.0)
        means.append(float(frame.mean()))
    assert means[0] == pytest.approx(112.0, abs=1.0)
    assert means[60] < 70.0  # just after it got dark
    assert means[90] == pytest.approx(112.0 - 56.0 * np.exp(-1.0), rel=0.08)  # 1 / e of the way is left after a lag
    assert means[119] > means[90]


def test_skipped_frames_change_nothing_in_later_ones() -> None:
    every, some = (FourLane("straight", rig=Rig(auto_exposure_s=0.3, overlay=True)) for _ in range(2))
    for world in (every, some):
        world.reset(seed=3)
    for tick in range(30):
        seen = every.step(STAY)[0]["image"]
        other = some.step(STAY, with_frame=tick % 3 == 2)[0]
    assert np.array_equal(seen, other["image"])


@pytest.mark.parametrize("name", ["dash-cam", "phone", "kitti"])
def test_a_scenario_file_names_its_camera(name: str) -> None:
    text = f'base = "straight"\nschema = 1\n[ego]\ncamera = "{name}"\n'
    env = FourLane(scenarios.parse(text, "camera.toml"))
    observed, _ = env.reset(seed=0)
    camera = preset(name).camera  # type: ignore[arg-type]
    assert env.camera == camera
    assert observed["image"].shape == (camera.height_px, camera.width_px, 3)
    assert env.observation_space.contains(observed)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"dirt": 0.7}, "camera: dirt: expected 0 to 0.5, got 0.7"),
        ({"bonnet": 1}, "camera: bonnet: expected True or False, got 1"),
        ({"jpeg_quality": 0}, "camera: jpeg_quality: expected 1 to 100, got 0"),
        ({"auto_exposure_s": float("nan")}, "camera: auto_exposure_s: expected 0 to 10, got nan"),
    ],
)
def test_wrong_options_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}$"):
        Rig(**wrong)
