"""Cameras of given sizes and fields of view, and invalid rigs."""

from math import atan, degrees
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from short_scenario import write_short

import vpf_sim
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError
from vpf_sim.types import Camera

NOT_A_CAMERA: Any = 3


@pytest.mark.parametrize("size", [(84, 84), (640, 480), (1280, 720), (64, 200)])
def test_the_lens_follows_the_size(size: tuple[int, int]) -> None:
    camera = Camera(*size)
    width, height = size
    assert 2.0 * degrees(atan(0.5 * width / camera.fx_px)) == pytest.approx(90.0)
    assert camera.fy_px == camera.fx_px
    assert (camera.cx_px, camera.cy_px) == (0.5 * (width - 1), 0.5 * (height - 1))


def test_given_intrinsics_are_kept() -> None:
    camera = Camera(100, 80, fy_px=70.0, cx_px=45.0)
    assert (camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px) == (70.0, 70.0, 45.0, 39.5)


@pytest.mark.parametrize("fov_deg", [20.0, 60.0, 90.0, 120.0])
def test_camera_of_a_field_of_view(fov_deg: float) -> None:
    camera = Camera.of(320, 240, fov_deg, height_m=1.2)
    assert 2.0 * degrees(atan(160.0 / camera.fx_px)) == pytest.approx(fov_deg)
    assert camera.height_m == 1.2


def test_the_default_camera_has_90_deg() -> None:
    assert Camera.of(640, 480, 90.0) == Camera()


def test_a_small_camera_sees_the_road() -> None:
    """By the true depth, the lower half of the image is ground."""
    env = FourLane("straight", rig=Rig(camera=Camera(84, 84)), truth=("depth",))
    _, info = env.reset(seed=1)
    assert np.isfinite(info["depth"][43:]).all()
    assert np.isinf(info["depth"][:20]).all()


@pytest.mark.parametrize(
    ("camera", "line"),
    [
        (Camera(84, 84, cx_px=319.5), "camera: cx_px: expected within the image, 0 to 83, got 319.5"),
        (Camera(84, 84, cy_px=-1.0), "camera: cy_px: expected within the image, 0 to 83, got -1"),
        (Camera(fx_px=float("nan")), "camera: fx_px: expected a finite number, got nan"),
        (Camera(84.5, 84), "camera: width_px: expected a whole number, got 84.5"),  # type: ignore[arg-type]
        (Camera(100_000, 84), "camera: width_px: expected at most 8192, got 100000"),
        (Camera.of(640, 480, 20.0, pitch_rad=-0.45), "camera: pitch_rad: expected one that shows the road, got only"),
        (NOT_A_CAMERA, "rig: camera: expected a vpf_sim.types.Camera, got 3"),
    ],
)
def test_camera_that_shows_no_road_is_rejected(camera: Camera, line: str) -> None:
    with pytest.raises(InputError) as caught:
        Rig(camera=camera)
    assert str(caught.value).startswith(line)


def test_impossible_field_of_view_is_rejected() -> None:
    with pytest.raises(InputError, match="fov_deg: expected 1 to 170, got 180"):
        Camera.of(640, 480, 180.0)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"truth": "depth"}, "truth: expected a tuple of names, such as ('depth',), got 'depth'"),
        ({"truth": 3}, "truth: expected a tuple of names, such as ('depth',), got 3"),
        ({"rig": 3}, "rig: expected a vpf_sim.envs.camera.Rig, got 3"),
        ({"scenario": 3}, "scenario: expected a name, a TOML file or a Scenario, got 3"),
        ({"weather": None}, "weather: expected a name, a TOML file or a Weather, got None"),
        ({"rate_hz": "60"}, "rate_hz: expected 60 or 20, got '60'"),
        ({"frames": "no"}, "frames: expected True or False, got 'no'"),
    ],
)
def test_options_of_another_type_are_one_clear_line(options: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError) as caught:
        FourLane(**options)
    assert str(caught.value) == line


def test_files_may_be_paths(tmp_path: Path) -> None:
    weather = tmp_path / "drizzle.toml"
    weather.write_text("precipitation = 15.0\n")
    env = FourLane(write_short(tmp_path), weather, frames=False)
    assert env.scenario.goal.s_m == FourLane(str(tmp_path / "short.toml"), frames=False).scenario.goal.s_m
    worlds = gymnasium.make("vpf_sim/FourLanePixels-v0", scenario=[tmp_path / "short.toml"], weather=weather)
    assert worlds.unwrapped.levels == 1  # type: ignore[attr-defined]


def test_wrapper_rejects_an_invalid_rig_or_weather() -> None:
    env = FourLane("straight")
    env.vehicle = None  # type: ignore[attr-defined]  # as highway-env's own have it
    env.road = None  # type: ignore[assignment]
    env.observation_space = FourLane("straight", frames=False).observation_space
    for options in ({"rig": 3}, {"weather": 3}):
        with pytest.raises(InputError, match=f"^{next(iter(options))}: expected"):
            vpf_sim.CameraObservation(env, **options)  # type: ignore[arg-type]
