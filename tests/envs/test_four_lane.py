"""The environment: its contract with gymnasium, its clock, determinism."""

from collections.abc import Callable
from math import inf, pi, radians
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from straight_road import FAR, FULL_AHEAD, GOAL, NEUTRAL, SMALL, constantly, drive, scenario

import vpf_sim  # noqa: F401 (registers the environment)
from vpf_sim import scenarios
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.contacts import nearest
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError

pytest_plugins = ["straight_road"]


@pytest.mark.usefixtures("blind")
def test_the_reward_is_metres_over_ten_less_the_squared_change_of_action() -> None:
    env = FourLane(scenario(FAR), rig=SMALL)
    env.reset(seed=0)
    _, first, *_ = env.step(np.array([0.0, 0.5]))
    _, second, *_ = env.step(np.array([0.5, 0.5]))
    assert first == pytest.approx(5.55 / 600.0 - 0.01 * 0.25, abs=1e-4)
    assert second == pytest.approx(5.55 / 600.0 - 0.01 * 0.25, abs=1e-4)


@pytest.mark.usefixtures("blind")
def test_actions_are_shares_of_what_the_car_can_do() -> None:
    env = FourLane(scenario(FAR), rig=SMALL)
    for action, change_mps, steering_rad in [
        ((1.0, 1.0), 3.0 / 60.0, 1.0 / 60.0),
        ((-0.5, 0.01), -3.0 / 60.0, radians(0.4)),
        ((9.0, -9.0), 3.0 / 60.0, -1.0 / 60.0),
    ]:
        env.reset(seed=0)
        env.step(np.array(action))
        assert env.ego.speed - 5.55 == pytest.approx(change_mps)
        assert env.ego.steering_rad == pytest.approx(steering_rad)


@pytest.mark.usefixtures("blind")
@pytest.mark.usefixtures("blind")
def test_the_nearest_object_is_the_one_of_the_last_step() -> None:
    env = FourLane("crossing", rig=SMALL)
    _, info = env.reset(seed=0)
    for _ in range(3):
        assert env.nearest == nearest(env.ego)
        assert info["clearance_m"] == env.nearest[0] < inf
        *_, info = env.step(FULL_AHEAD)


@pytest.mark.parametrize("action", [[np.nan, 0.0], [0.0], [0.0, inf]])
def test_action_must_be_two_finite_numbers(action: list[float]) -> None:
    env = FourLane(scenario(FAR), rig=SMALL)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"^action: expected two finite numbers in \[-1, 1\], throttle and steering"):
        env.step(np.array(action))


@pytest.mark.usefixtures("blind")
def test_action_array_is_not_modified() -> None:
    env, action = FourLane(scenario(FAR), rig=SMALL), np.array([2.0, -3.0])
    env.reset(seed=0)
    env.step(action)
    assert action.tolist() == [2.0, -3.0]


@pytest.mark.usefixtures("blind")
def test_attributes_for_the_evaluation() -> None:
    env = FourLane("curve-right", rig=SMALL)
    env.reset(seed=4)
    lane = env.road.network.get_lane(("start", "end", 2))
    assert env.scenario == scenarios.load("curve-right").draw(4)
    assert env.ego in env.road.vehicles
    assert lane.local_coordinates(np.array(env.goal_m)) == pytest.approx((205.0, 0.0), abs=1e-9)
    assert lane.local_coordinates(env.route[0]) == pytest.approx((5.0, 0.0), abs=1e-9)
    assert (env.rate_hz, env.speed_reference_mps, env.camera) == (60.0, 5.55, SMALL.camera)
    assert env.ego.place[1] - 1.75 == pytest.approx(env.scenario.ego.lateral_m)
    assert env.ego.heading == pytest.approx(radians(env.scenario.ego.heading_deg))


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize(
    ("heading", "yaw"), [(3.0 * pi + 0.1, -pi + 0.1), (-pi, pi), (-3.0 * pi - 0.1, pi - 0.1), (1, 1)]
)
def test_the_yaw_is_the_heading_wrapped(heading: float, yaw: float) -> None:
    env = FourLane("straight", rig=SMALL)
    env.reset(seed=0)
    env.ego.heading = heading
    observed, *_ = env.step(NEUTRAL)
    assert observed["ego"][2] == pytest.approx(yaw)


@pytest.mark.usefixtures("blind")
def test_rate_of_20_hz_is_supported() -> None:
    env = FourLane(scenario(GOAL), rig=SMALL, rate_hz=20.0)
    steps = drive(env, constantly(NEUTRAL))
    assert len(steps) == np.ceil(25.0 / (5.55 / 20.0))
    assert steps[-1][0]["time"][0] == pytest.approx(len(steps) / 20.0)
    assert (env.metadata["render_fps"], FourLane.metadata["render_fps"]) == (20, 60)


def test_episode_without_frames_is_otherwise_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    seeing, blind = FourLane("town04", rig=SMALL), FourLane("town04", rig=SMALL, frames=False)
    check_env(blind, skip_render_check=True)
    observed, info = seeing.reset(seed=3)
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", None)
    blind_observed, blind_info = blind.reset(seed=3)
    for command in (*20 * [FULL_AHEAD], *20 * [np.array([0.2, 0.3])]):
        assert observed.keys() == {*blind_observed, "image"}
        assert all(np.array_equal(observed[key], blind_observed[key]) for key in blind_observed)
        assert info == blind_info
        (observed, *judged, info), (blind_observed, *also, blind_info) = seeing.step(command), blind.step(command)
        assert judged == also
    assert blind.renderer is None


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"scenario": "strait"}, "unknown scenario 'strait': did you mean 'straight'?"),
        ({"weather": "cleer"}, "unknown weather 'cleer': did you mean 'clear'?"),
        ({"truth": ("dept",)}, "unknown truth 'dept': did you mean 'depth'?"),
        ({"render_mode": "rgb_arry"}, "unknown render mode 'rgb_arry': did you mean 'rgb_array'?"),
        ({"rate_hz": 30.0}, "rate_hz: expected 60 or 20, got 30"),
        *(
            ({"frames": False, **wish}, "frames: expected them to be taken for a render mode or for truth, got False")
            for wish in ({"truth": ("foe",)}, {"render_mode": "rgb_array"})
        ),
    ],
)
def test_wrong_options_are_one_clear_line(options: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError) as caught:
        FourLane(**options)
    assert str(caught.value) == line


def test_names_paths_and_loaded_objects_give_the_same_world(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text((Path(scenarios.__file__).parent / "catalog" / "straight.toml").read_text("utf-8"), "utf-8")
    frames = []
    for option in ("straight", str(path), scenarios.load("straight")):
        env = FourLane(option, weathers.load("clear") if option == "straight" else "clear")
        frames.append(env.reset(seed=2)[0]["image"])
    assert (frames[0] == frames[1]).all()
    assert (frames[0] == frames[2]).all()


@pytest.fixture
def unseen_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.mark.usefixtures("unseen_window")
def test_gymnasiums_checker_passes_without_a_warning(recwarn: pytest.WarningsRecorder) -> None:
    env = gymnasium.make("vpf_sim/FourLane-v0", scenario="town04")
    check_env(env.unwrapped)
    assert [str(warning.message) for warning in recwarn] == []


def rollout(env: gymnasium.Env[Any, Any], seed: int | None, steps: int = 12) -> list[bytes]:
    rng = np.random.default_rng(1)
    observed, _ = env.reset(seed=seed)
    seen = [observed]
    for _ in range(steps):
        observed, *_ = env.step(rng.uniform(-1.0, 1.0, 2).astype(np.float32))
        seen.append(observed)
    return [value.tobytes() for observed in seen for value in observed.values()]


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    env, other = FourLane("town04"), FourLane("town04")
    first = rollout(env, 1003)
    assert rollout(env, 1003) == first
    assert rollout(other, 1003) == first
    assert rollout(other, 1004) != first


@pytest.mark.usefixtures("blind")
def test_a_reset_without_a_seed_draws_the_next_of_a_reproducible_sequence() -> None:
    env, other = FourLane("town04", rig=SMALL), FourLane("town04", rig=SMALL)
    env.reset(seed=5)
    other.reset(seed=5)
    starts = [env.reset()[0]["ego"].tolist() for _ in range(3)]
    assert [other.reset()[0]["ego"].tolist() for _ in range(3)] == starts
    assert starts[0] != starts[1]


@pytest.mark.parametrize("vector", [SyncVectorEnv, AsyncVectorEnv])
def test_vector_environments_equal_single_ones(vector: Callable[..., Any]) -> None:
    def make() -> gymnasium.Env[Any, Any]:
        return gymnasium.make("vpf_sim/FourLane-v0", scenario="straight")

    envs, single = vector([make, make]), make()
    observed, _ = envs.reset(seed=[3, 4])
    for _ in range(3):
        observed, *_ = envs.step(np.array([[0.5, 0.1], [0.5, 0.1]], np.float32))
    envs.close()
    single.reset(seed=4)
    for _ in range(3):
        alone, *_ = single.step(np.array([0.5, 0.1], np.float32))
    assert all((observed[key][1] == alone[key]).all() for key in alone)
    assert not (observed["ego"][0] == observed["ego"][1]).all()


def test_the_rgb_array_is_the_frame_and_a_copy_of_it() -> None:
    env = FourLane("straight", render_mode="rgb_array")
    observed, _ = env.reset(seed=0)
    picture = env.render()
    assert picture is not None
    assert (picture == observed["image"]).all()
    picture[:] = 0
    assert observed["image"].any()


def test_every_step_returns_fresh_arrays() -> None:
    env = FourLane("straight")
    first, _ = env.reset(seed=0)
    kept = {key: value.copy() for key, value in first.items()}
    second, *_ = env.step(FULL_AHEAD)
    assert all((first[key] == kept[key]).all() for key in kept)
    assert not any(np.shares_memory(first[key], second[key]) for key in kept)


@pytest.mark.usefixtures("blind")
def test_truth_is_given_on_request_only() -> None:
    _, info = FourLane("straight", rig=SMALL, truth=("foe",)).reset(seed=0)
    assert "foe" in info
    _, info = FourLane("straight", rig=SMALL).reset(seed=0)
    assert set(info) == {"status", "is_success", "route_m", "lane_offset_m", "clearance_m", "collided_with"}
    assert info["clearance_m"] == inf
