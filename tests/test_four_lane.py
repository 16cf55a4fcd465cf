"""The environment: its contract with gymnasium, every end of an episode, determinism."""

from collections.abc import Callable
from math import inf, pi, radians
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

import vpf_sim  # noqa: F401 (registers the environment)
from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, Floats

HEAD = """
schema = 1
[road]
segments = [{kind = "line", length_m = 200}]
"""
FULL_AHEAD, FULL_BRAKE, NEUTRAL = np.array([1.0, 0.0]), np.array([-1.0, 0.0]), np.array([0.0, 0.0])
SMALL = Rig(Camera(width_px=64, height_px=48, fx_px=32.0, fy_px=32.0, cx_px=31.5, cy_px=23.5))


class FakeRenderer:
    """Frames that show nothing but that time passes: most ends of an episode have nothing to do with the picture."""

    def __init__(self, road: object, rig: Rig, weather: object, seed: int) -> None:  # noqa: ARG002
        self._shape = (rig.camera.height_px, rig.camera.width_px, 3)

    def render(self, ego: object, time_s: float) -> np.ndarray:  # noqa: ARG002
        frame = np.zeros(self._shape, np.uint8)
        frame[:2] = [round(time_s * 60.0) % 250 + 1, round(time_s * 60.0) // 250 + 1, 7]
        return frame

    def truth(self, names: tuple[str, ...]) -> dict[str, Any]:
        return dict.fromkeys(names, np.zeros(2))


@pytest.fixture
def blind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worlds without a picture."""
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", FakeRenderer)


def scenario(text: str) -> scenarios.Scenario:
    return scenarios.parse(HEAD + text, "test.toml")


def drive(env: FourLane, policy: Callable[[FourLane], Floats], seed: int = 0) -> list[tuple[Any, ...]]:
    """All that step returned, up to the end of the episode."""
    env.reset(seed=seed)
    steps = []
    while not steps or not (steps[-1][2] or steps[-1][3]):
        steps.append(env.step(policy(env)))
    return steps


def constantly(action: Floats) -> Callable[[FourLane], Floats]:
    return lambda env: action  # noqa: ARG005


def ending(text: str, action: Floats = NEUTRAL) -> tuple[list[tuple[Any, ...]], FourLane]:
    env = FourLane(scenario(text), rig=SMALL)
    return drive(env, constantly(action)), env


GOAL = "[goal]\ns_m = 30.0\n"
FAR = "[goal]\ns_m = 190.0\n"
BARRIER = '[[bodies]]\nkind = "barrier"\ns_m = 40.0\nlane = 2\n'


@pytest.mark.usefixtures("blind")
def test_success_is_the_centre_crossing_the_goals_cross_section() -> None:
    steps, env = ending(GOAL)
    assert steps[-1][4]["status"] == "success"
    assert (steps[-1][2], steps[-1][3]) == (True, False)
    assert 30.0 <= env.ego.position[0] < 30.0 + 5.55 / 60.0
    assert steps[-1][1] == pytest.approx(5.0 + 5.55 / 60.0 / 10.0)
    assert steps[-1][4]["route_m"] == pytest.approx(env.ego.position[0] - 5.0)
    assert all(step[4]["status"] == "running" for step in steps[:-1])


@pytest.mark.usefixtures("blind")
def test_success_counts_in_any_lane() -> None:
    env = FourLane(scenario(GOAL + "[ego]\nlane = 4\nlateral_m = -0.5\n"), rig=SMALL)
    steps = drive(env, constantly(NEUTRAL))
    assert steps[-1][4]["status"] == "success"
    assert steps[-1][4]["lane_offset_m"] == pytest.approx(-0.5)


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("kind", ["car", "van", "truck", "cone", "pallet", "barrier", "pedestrian"])
def test_collision_names_the_kind_hit_and_moves_the_car_by_nothing_but_its_speed(kind: str) -> None:
    steps, env = ending(FAR + f'[[bodies]]\nkind = "{kind}"\ns_m = 40.0\nlane = 2\nlateral_m = 0.6\n')
    info = steps[-1][4]
    assert (info["status"], info["collided_with"], info["clearance_m"]) == ("collision", kind, 0.0)
    assert (steps[-1][2], steps[-1][3]) == (True, False)
    assert steps[-1][1] == pytest.approx(-5.0 + 5.55 / 60.0 / 10.0)
    along = [step[0]["ego"][0] for step in steps]
    assert np.diff(along) == pytest.approx(5.55 / 60.0)
    assert {step[0]["ego"][1] for step in steps} == {1.75}
    face = 40.0 - scenarios.SIZES[kind].length_m / 2.0  # type: ignore[index]
    assert face <= env.ego.position[0] + 2.25 <= face + 5.55 / 60.0


@pytest.mark.usefixtures("blind")
def test_a_car_from_behind_is_a_collision_too() -> None:
    text = FAR + '[ego]\ns_m = 30.0\nspeed_mps = 0.0\n[[bodies]]\nkind = "car"\ns_m = 10.0\nlane = 2\nspeed_mps = 8.0\n'
    env = FourLane(scenario(text), rig=SMALL)
    env.reset(seed=0)
    env.road.vehicles[0].act = lambda: None  # it does not look
    info = next(info for *_, info in (env.step(NEUTRAL) for _ in range(200)) if info["status"] != "running")
    assert (info["status"], info["collided_with"]) == ("collision", "car")
    assert env.ego.position.tolist() == [30.0, 1.75]


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_off_road_is_any_corner_more_than_the_margin_beyond_the_edge(side: float) -> None:
    lane = 1 if side > 0 else 4
    steps, env = ending(FAR + f"[ego]\nlane = {lane}\nheading_deg = {side * 5.0}\n")
    assert (steps[-1][4]["status"], steps[-1][2]) == ("off_road", True)
    assert steps[-1][1] < -4.9
    corner = 2.25 * np.sin(radians(5.0)) + 0.95 * np.cos(radians(5.0))
    beyond = side * env.ego.position[1] + corner - 7.0
    assert 0.2 < beyond < 0.2 + 5.55 / 60.0 * np.sin(radians(5.0)) + 1e-9


@pytest.mark.usefixtures("blind")
def test_the_end_of_the_road_is_off_road_where_the_goal_is_to_stop() -> None:
    steps, env = ending('[goal]\ns_m = 190.0\nkind = "stop"\n[ego]\ns_m = 150.0\n[limits]\ntime_s = 30.0\n')
    assert steps[-1][4]["status"] == "off_road"
    assert env.ego.position[0] + 2.25 == pytest.approx(200.2, abs=5.55 / 60.0)


@pytest.mark.usefixtures("blind")
def test_timeout_is_the_limit_or_three_times_the_way_at_the_reference_speed() -> None:
    slow = "[ego]\nspeed_mps = 0.5\n"
    steps, _ = ending(FAR + slow + "[limits]\ntime_s = 2.0\n")
    assert (steps[-1][4]["status"], steps[-1][2], steps[-1][3]) == ("timeout", False, True)
    assert len(steps) == 120
    steps, _ = ending(GOAL + slow)
    assert steps[-1][4]["status"] == "timeout"
    assert len(steps) == np.ceil(3.0 * 25.0 / 5.55 * 60.0)


@pytest.mark.usefixtures("blind")
def test_stuck_is_ten_seconds_of_standing() -> None:
    steps, _ = ending(FAR, FULL_BRAKE)
    slow = sum(step[0]["ego"][3] < 0.2 for step in steps)
    assert (steps[-1][4]["status"], steps[-1][3], slow) == ("stuck", True, 600)


STOP = '[goal]\ns_m = 190.0\nkind = "stop"\n'


def braking_at(x: float) -> Callable[[FourLane], Floats]:
    return lambda env: FULL_BRAKE if env.ego.position[0] >= x else NEUTRAL


@pytest.mark.usefixtures("blind")
def test_stop_is_two_seconds_of_standing_at_one_to_fifteen_metres() -> None:
    env = FourLane(scenario(STOP + BARRIER), rig=SMALL)
    steps = drive(env, braking_at(28.0))
    standing = sum(step[0]["ego"][3] < 0.05 for step in steps)
    assert (steps[-1][4]["status"], standing) == ("success", 120)
    assert 1.0 < steps[-1][4]["clearance_m"] < 15.0


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("x", [10.0, 34.3])
def test_stop_too_far_from_or_too_near_the_body_is_no_success(x: float) -> None:
    env = FourLane(scenario(STOP + BARRIER), rig=SMALL)
    steps = drive(env, braking_at(x))
    assert steps[-1][4]["status"] == "stuck"
    assert not 1.0 <= steps[-1][4]["clearance_m"] <= 15.0


class Frames(FakeRenderer):
    """Frames that go wrong after half a second."""

    wrong: Callable[[np.ndarray], np.ndarray]

    def render(self, ego: object, time_s: float) -> np.ndarray:
        frame = super().render(ego, min(time_s, 0.5))
        return self.wrong(frame) if time_s > 0.5 else frame


WRONG: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "black": np.zeros_like,
    "constant": lambda frame: np.full_like(frame, 90),
    "wrong shape": lambda frame: frame[1:],
    "stale": lambda frame: frame,
}


@pytest.mark.parametrize("fault", WRONG)
def test_an_invalid_frame_ends_the_episode(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    faulty = type("Faulty", (Frames,), {"wrong": staticmethod(WRONG[fault])})
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", faulty)
    steps, _ = ending(FAR)
    assert (steps[-1][4]["status"], steps[-1][3], len(steps)) == ("invalid_frame", True, 31)
    assert steps[-1][4]["invalid_frame"] == {"frame": 31, "time_s": 31.0 / 60.0, "fault": fault}
    assert not any("invalid_frame" in step[4] for step in steps[:-1])


class Blind(FakeRenderer):
    """Black from the first frame on."""

    def render(self, ego: object, time_s: float) -> np.ndarray:
        return np.zeros_like(super().render(ego, time_s))


def test_a_camera_that_never_works_is_said_at_the_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", Blind)
    env = FourLane(scenario(FAR), rig=SMALL)
    _, info = env.reset(seed=0)
    assert info["status"] == "invalid_frame"
    *_, truncated, info = env.step(NEUTRAL)
    assert truncated
    assert info["invalid_frame"] == {"frame": 0, "time_s": 0.0, "fault": "black"}


def test_the_same_frame_twice_is_right_while_the_car_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", type("S", (Frames,), {"wrong": staticmethod(WRONG["stale"])}))
    steps, _ = ending(FAR + "[ego]\nspeed_mps = 0.0\n")
    assert steps[-1][4]["status"] == "stuck"


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
@pytest.mark.parametrize("action", [[np.nan, 0.0], [0.0], [0.0, inf]])
def test_an_action_that_is_not_two_finite_numbers_is_refused(action: list[float]) -> None:
    env = FourLane(scenario(FAR), rig=SMALL)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"^action: expected two finite numbers in \[-1, 1\], throttle and steering"):
        env.step(np.array(action))


@pytest.mark.usefixtures("blind")
def test_an_action_array_is_left_as_it_was() -> None:
    env, action = FourLane(scenario(FAR), rig=SMALL), np.array([2.0, -3.0])
    env.reset(seed=0)
    env.step(action)
    assert action.tolist() == [2.0, -3.0]


@pytest.mark.usefixtures("blind")
def test_what_the_evaluation_is_offered() -> None:
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
def test_twenty_frames_a_second_is_the_other_clock() -> None:
    env = FourLane(scenario(GOAL), rig=SMALL, rate_hz=20.0)
    steps = drive(env, constantly(NEUTRAL))
    assert len(steps) == np.ceil(25.0 / (5.55 / 20.0))
    assert steps[-1][0]["time"][0] == pytest.approx(len(steps) / 20.0)
    assert (env.metadata["render_fps"], FourLane.metadata["render_fps"]) == (20, 60)


def test_without_frames_all_but_the_image_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    seeing, blind = FourLane("town04", rig=SMALL), FourLane("town04", rig=SMALL, frames=False)
    check_env(blind, skip_render_check=True)
    observed, info = seeing.reset(seed=3)
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", None)
    unseen, told = blind.reset(seed=3)
    for command in (*20 * [FULL_AHEAD], *20 * [np.array([0.2, 0.3])]):
        assert observed.keys() == {*unseen, "image"}
        assert all(np.array_equal(observed[key], unseen[key]) for key in unseen)
        assert info == told
        (observed, *judged, info), (unseen, *also, told) = seeing.step(command), blind.step(command)
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


def test_names_paths_and_loaded_scenarios_and_weathers_are_the_same_world(tmp_path: Path) -> None:
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
def test_vector_environments_give_what_single_ones_give(vector: Callable[..., Any]) -> None:
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
    assert set(info) == {"status", "route_m", "lane_offset_m", "clearance_m", "collided_with"}
    assert info["clearance_m"] == inf
