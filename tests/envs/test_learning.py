"""The environment for learned policies: observation, reward, drawing of worlds."""

from typing import Any

import cv2
import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import FrameStackObservation

import vpf_sim  # noqa: F401 (registers the environment)
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.learning import FourLanePixels, RewardWeights
from vpf_sim.errors import InputError
from vpf_sim.types import Camera

AHEAD = np.zeros(2, np.float32)
RIGHT = np.array([0.0, 1.0], np.float32)
ONLY = dict.fromkeys(("progress", "lane", "comfort", "time", "contact", "arrival"), 0.0)


def bends(env: FourLanePixels) -> bool:
    """Whether the drawn road has a bend."""
    return any(segment.kind == "arc" for segment in env.world.scenario.road.segments)


@pytest.mark.parametrize("kind", [{}, {"state": True, "grey": False}])
def test_it_is_a_gymnasium_environment(kind: dict[str, Any]) -> None:
    env = gymnasium.make("vpf_sim/FourLanePixels-v0", render_mode="rgb_array", **kind)
    check_env(env.unwrapped, skip_render_check=True)
    assert env.observation_space.contains(env.reset(seed=0)[0])


@pytest.mark.parametrize("kind", [{}, {"state": True}, {"grey": False, "image_size": (64, 48)}])
def test_stable_baselines3_takes_it(kind: dict[str, Any]) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="needs Stable-Baselines3")
    env = FourLanePixels(**kind)
    checker.check_env(env)
    assert env.observation_space.contains(env.reset(seed=0)[0])


def test_wrappers_of_gymnasium_stack_its_frames() -> None:
    env = FrameStackObservation(gymnasium.make("vpf_sim/FourLanePixels-v0", image_size=(64, 48)), 4)
    stacked, _ = env.reset(seed=3)
    assert stacked.shape == (4, 48, 64, 1)


def test_the_image_is_the_grey_frame_at_the_end_of_a_decision() -> None:
    """Apart from the sensor's noise, which differs between a camera of 60 Hz and one of 15."""
    env = FourLanePixels("straight", image_size=(96, 64), action_repeat=4)
    env.reset(seed=5)
    world = FourLane("straight", rig=Rig(Camera(96, 64)))
    world.reset(seed=5)
    for _ in range(5):
        seen, *_ = env.step(AHEAD)
        for _ in range(4):
            expected, *_ = world.step(AHEAD)
    assert cv2.PSNR(seen[:, :, 0], cv2.cvtColor(expected["image"], cv2.COLOR_RGB2GRAY)) > 35.0


def test_longer_ticks_move_the_car_alike() -> None:
    """A fifth of a second of four ticks or of twelve; the steering, at a limited rate, is not quite the same."""
    places = []
    for rate_hz, ticks in ((20.0, 4), (60.0, 12)):
        env = FourLanePixels("straight", image_size=(64, 48), action_repeat=ticks, rate_hz=rate_hz)
        env.reset(seed=5)
        for _ in range(10):
            _, _, _, _, info = env.step(0.1 * RIGHT)
        assert env.metadata["render_fps"] == 5
        places.append((info["route_m"], info["lane_offset_m"]))
    np.testing.assert_allclose(*places, atol=0.05)
    assert abs(places[0][1]) > 1.0, "it steers"


@pytest.mark.parametrize("weather", ["clear", "rain"])
def test_a_small_camera_shows_what_a_large_one_does(weather: str) -> None:
    """Its frame is the large one's, shrunk; rain has drops that small pixels do not show."""
    sizes = ((640, 480), (96, 72))
    worlds = [FourLane("town04", weather, rig=Rig(Camera.of(*size, 90.0))) for size in sizes]
    for world in worlds:
        world.reset(seed=4)
    for _ in range(20):
        large, small = (world.step(AHEAD, ticks=3)[0]["image"] for world in worlds)
        shrunk = cv2.resize(large, sizes[1], interpolation=cv2.INTER_AREA)
        difference = cv2.absdiff(shrunk, small).astype(float)
        assert difference.mean() < 8.0
        assert np.abs((shrunk.astype(float) - small).mean(axis=(1, 2))).max() < 15.0  # of any row


def test_an_action_is_held_until_the_episode_ends() -> None:
    """Held for longer than the road, it ends with the picture and the state of that moment."""
    held, ticked = FourLane("straight"), FourLane("straight", frames=False)
    for world in (held, ticked):
        world.reset(seed=5)
    observed, reward, ended, _, info = held.step(RIGHT, ticks=600)
    total, over = 0.0, False
    while not over:
        last, gained, over, _, _ = ticked.step(RIGHT)
        total += gained
    assert ended
    assert info["status"] == "off_road"
    assert np.array_equal(observed["ego"], last["ego"])
    assert np.array_equal(observed["time"], last["time"])
    assert observed["image"].shape == (480, 640, 3)
    assert reward == pytest.approx(total)


def test_the_goal_turns_with_the_car() -> None:
    env = FourLanePixels("heading-30", state=True, image_size=(64, 48))
    observation, _ = env.reset(seed=1)
    world = env.world
    way_m = np.array(world.goal_m) - world.ego.position
    forward = np.array([np.cos(world.ego.heading), np.sin(world.ego.heading)])
    right = np.array([-forward[1], forward[0]])  # y points right
    assert isinstance(observation, dict)
    expected = np.clip([way_m @ forward / 100.0, way_m @ right / 100.0], -1.0, 1.0)
    assert observation["state"][2:4] == pytest.approx(expected)


def test_progress_is_paid_by_the_metre() -> None:
    env = FourLanePixels("straight", reward=RewardWeights(**{**ONLY, "progress": 2.0}), image_size=(64, 48))
    env.reset(seed=0)
    _, reward, *_ = env.step(AHEAD)
    assert reward == pytest.approx(2.0 * 5.55 * 3 / 60.0, rel=1e-3)


def test_a_change_of_action_costs_once_a_decision() -> None:
    env = FourLanePixels("straight", reward=RewardWeights(**{**ONLY, "comfort": 0.5}), image_size=(64, 48))
    env.reset(seed=0)
    rewards = [env.step(action)[1] for action in (AHEAD, RIGHT, RIGHT)]
    assert rewards == pytest.approx([0.0, -0.5, 0.0])


def test_leaving_the_road_costs_and_the_terms_sum_to_the_reward() -> None:
    env = FourLanePixels("straight", reward=RewardWeights(contact=7.0), image_size=(64, 48), action_repeat=10)
    env.reset(seed=0)
    ended = False
    while not ended:
        _, reward, ended, _, info = env.step(RIGHT)
        assert sum(info["reward_terms"].values()) == pytest.approx(reward)
    assert info["status"] == "off_road"
    assert info["reward_terms"]["contact"] == -7.0


def test_a_reset_draws_scenario_and_weather_by_its_seed() -> None:
    env = FourLanePixels(["straight", "curve-left"], ["clear", "rain"], image_size=(64, 48))
    drawn: set[tuple[bool, bool]] = set()
    for seed in range(12):
        first, _ = env.reset(seed=seed)
        drawn.add((bends(env), env.world.weather.precipitation > 0.0))
        again, _ = env.reset(seed=seed)
        assert np.array_equal(first, again)
    assert len(drawn) == 4


def test_levels_limit_the_draw_to_the_first_scenarios() -> None:
    env = FourLanePixels(["straight", "curve-left"], image_size=(64, 48))
    env.levels = 1
    kinds: set[bool] = set()
    for seed in range(8):
        env.reset(seed=seed)
        kinds.add(bends(env))
    assert kinds == {False}
    env.levels = 3
    with pytest.raises(InputError, match=r"^levels: expected 1 to 2, the number of scenarios, got 3$"):
        env.reset(seed=0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"action_repeat": 0}, "action_repeat: expected 1 to 60 ticks, got 0"),
        ({"image_size": 84}, r"image_size: expected \(width, height\) in pixels, got 84"),
        ({"action_repeat": True}, "action_repeat: expected 1 to 60 ticks, got True"),
        ({"rate_hz": 30}, "rate_hz: expected 60 or 20, got 30"),
        ({"fov_deg": "wide"}, "fov_deg: expected a number of degrees, got 'wide'"),
        ({"grey": "yes"}, "grey: expected True or False, got 'yes'"),
        ({"scenario": []}, "scenario: expected at least one, got none"),
        ({"weathers": "sunny"}, "weather 'sunny'"),
        ({"reward": {"lane": 1.0}}, "reward: expected a vpf_sim.envs.learning.RewardWeights, got {'lane': 1.0}"),
    ],
)
def test_wrong_options_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        FourLanePixels(**wrong)


def test_a_weight_below_zero_is_refused() -> None:
    with pytest.raises(InputError, match=r"^reward: lane: expected a finite number of at least 0, got -1.0$"):
        RewardWeights(lane=-1.0)
