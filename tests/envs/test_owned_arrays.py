"""Arrays that leave an environment belong to the caller: changing them changes nothing later."""

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import vpf_sim
from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.four_lane import TRUTHS
from vpf_sim.types import Camera

SMALL = Rig(Camera(160, 120))
FAULTS = {
    "dropped": "drop_share = 0.5",
    "late": "latency_ms = 50.0",
    "frozen": "freeze_share = 0.5\nfreeze_s = 0.3",
    "torn": "torn_share = 0.5",
    "noisy and black": "noise_rows_share = 0.3\nblack_share = 0.3\ndrop_share = 0.3",
    "overexposed while frozen": "exposure_jump_share = 0.5\nfreeze_share = 0.3\nfreeze_s = 0.1",
}


def with_faults(faults: str, sensors: str = "") -> Any:
    return scenarios.parse(f'base = "straight"\n[ego.sensor_faults]\n{faults}\n{sensors}', "own.toml")


def arrays(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """All arrays in nested dictionaries."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from arrays(item)


def scribble(*given: Any) -> None:
    """Overwrite all arrays."""
    for array in arrays(dict(enumerate(given))):
        array[...] = True if array.dtype == bool else 99


def assert_scribbling_changes_nothing(make: Callable[[], Any], steps: int, action: Any) -> None:
    """Two environments return the same, although everything that one of them returns is overwritten."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        used, intact = make(), make()
    returned, expected = used.reset(seed=1), intact.reset(seed=1)
    for _ in range(steps):
        np.testing.assert_equal(returned, expected)
        scribble(*returned)
        if used.render_mode == "rgb_array":
            np.testing.assert_array_equal(used.render(), intact.render())
            scribble(used.render())
        taken = np.array(action) if isinstance(action, list) else action
        returned, expected = used.step(taken), intact.step(action)
        scribble(taken)
    np.testing.assert_equal(returned, expected)


@pytest.mark.parametrize("name", FAULTS)
def test_images_of_a_faulty_camera(name: str) -> None:
    scenario = with_faults(FAULTS[name])
    assert_scribbling_changes_nothing(
        lambda: gym.make("vpf_sim/FourLane-v0", scenario=scenario, rig=SMALL, render_mode="rgb_array"), 20, [0.1, 0.0]
    )


@pytest.mark.parametrize("name", ["dropped", "late", "frozen"])
def test_gymnasiums_checker_accepts_a_faulty_camera(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = gym.make("vpf_sim/FourLane-v0", scenario=with_faults(FAULTS[name]), rig=SMALL)
        check_env(env.unwrapped)
    assert env.observation_space.contains(env.reset(seed=0)[0])


def test_arrays_of_info_and_state() -> None:
    scenario = with_faults("speed_stuck_after_s = 0.05", "[ego.sensors]\nspeed_noise_mps = 0.1")
    assert_scribbling_changes_nothing(
        lambda: gym.make("vpf_sim/FourLane-v0", scenario=scenario, rig=SMALL, truth=TRUTHS, weather="rain"),
        4,
        [0.1, 0.0],
    )


@pytest.mark.parametrize("options", [{"grey": False}, {"state": True}])
def test_small_images_for_learning(options: dict[str, Any]) -> None:
    assert_scribbling_changes_nothing(
        lambda: gym.make(
            "vpf_sim/FourLanePixels-v0", scenarios=with_faults(FAULTS["late"]), render_mode="rgb_array", **options
        ),
        6,
        [0.1, 0.05],
    )


def test_vector_of_environments_that_does_not_copy() -> None:
    def one() -> Any:
        return gym.make("vpf_sim/FourLane-v0", scenario=with_faults(FAULTS["frozen"]), rig=SMALL)

    vector, intact = (gym.vector.SyncVectorEnv([one] * 2, copy=copy) for copy in (False, True))
    found, expected = vector.reset(seed=[1, 2])[0], intact.reset(seed=[1, 2])[0]
    for _ in range(8):
        np.testing.assert_equal(found, expected)
        scribble(found)
        found, expected = (each.step(np.zeros((2, 2)))[0] for each in (vector, intact))


def test_observations_of_the_camera_on_highway_environments() -> None:
    used, intact = (
        vpf_sim.CameraObservation(gym.make("merge-v0", disable_env_checker=True), "rain", SMALL) for _ in range(2)
    )
    returned, expected = used.reset(seed=1)[0], intact.reset(seed=1)[0]
    for _ in range(3):
        np.testing.assert_equal(returned, expected)
        scribble(returned)
        returned, expected = used.step(1)[0], intact.step(1)[0]


def test_frames_are_stale_by_what_the_camera_took() -> None:
    """The check of frames uses the camera's own, whatever a user drew into the observation."""
    env: Any = gym.make("vpf_sim/FourLane-v0", scenario="straight", rig=SMALL).unwrapped
    observed, _ = env.reset(seed=1)
    stuck = observed["image"].copy()
    env.renderer.render = lambda *_: stuck.copy()
    for _ in range(2):
        observed["image"][:] = 1
        observed, _, _, _, info = env.step(np.array([0.0, 0.0]))
    assert info["invalid_frame"]["fault"] == "stale"
