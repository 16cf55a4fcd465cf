"""Every ending of an episode, by the rules of the reference."""

from collections.abc import Callable
from math import radians

import numpy as np
import pytest
from straight_road import (
    BARRIER,
    FAR,
    FULL_BRAKE,
    GOAL,
    NEUTRAL,
    SMALL,
    FakeRenderer,
    constantly,
    drive,
    ending,
    scenario,
)

from vpf_sim import scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.types import Floats

pytest_plugins = ["straight_road"]


@pytest.mark.usefixtures("blind")
def test_success_when_the_centre_crosses_the_goal() -> None:
    steps, env = ending(GOAL)
    assert steps[-1][4]["status"] == "success"
    assert (steps[-1][2], steps[-1][3]) == (True, False)
    assert 30.0 <= env.ego.position[0] < 30.0 + 5.55 / 60.0
    assert steps[-1][1] == pytest.approx(5.0 + 5.55 / 60.0 / 10.0)
    assert steps[-1][4]["route_m"] == pytest.approx(env.ego.position[0] - 5.0)
    assert all(step[4]["status"] == "running" for step in steps[:-1])
    assert [step[4]["is_success"] for step in steps] == [False] * (len(steps) - 1) + [True]


@pytest.mark.usefixtures("blind")
def test_success_counts_in_any_lane() -> None:
    env = FourLane(scenario(GOAL + "[ego]\nlane = 4\nlateral_m = -0.5\n"), rig=SMALL)
    steps = drive(env, constantly(NEUTRAL))
    assert steps[-1][4]["status"] == "success"
    assert steps[-1][4]["lane_offset_m"] == pytest.approx(-0.5)


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("kind", ["car", "van", "truck", "cone", "pallet", "barrier", "pedestrian"])
def test_collision_names_the_kind_and_does_not_displace_the_car(kind: str) -> None:
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
def test_rear_end_collision_counts() -> None:
    text = FAR + '[ego]\ns_m = 30.0\nspeed_mps = 0.0\n[[bodies]]\nkind = "car"\ns_m = 10.0\nlane = 2\nspeed_mps = 8.0\n'
    env = FourLane(scenario(text), rig=SMALL)
    env.reset(seed=0)
    env.road.vehicles[0].act = lambda: None  # it ignores obstacles
    info = next(info for *_, info in (env.step(NEUTRAL) for _ in range(200)) if info["status"] != "running")
    assert (info["status"], info["collided_with"]) == ("collision", "car")
    assert env.ego.position.tolist() == [30.0, 1.75]


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_corner_beyond_the_edge_margin_is_off_road(side: float) -> None:
    lane = 1 if side > 0 else 4
    steps, env = ending(FAR + f"[ego]\nlane = {lane}\nheading_deg = {side * 5.0}\n")
    assert (steps[-1][4]["status"], steps[-1][2]) == ("off_road", True)
    assert steps[-1][1] < -4.9
    corner = 2.25 * np.sin(radians(5.0)) + 0.95 * np.cos(radians(5.0))
    beyond = side * env.ego.position[1] + corner - 7.0
    assert 0.2 < beyond < 0.2 + 5.55 / 60.0 * np.sin(radians(5.0)) + 1e-9


@pytest.mark.usefixtures("blind")
def test_end_of_the_road_is_off_road() -> None:
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
def test_stuck_after_ten_seconds_at_standstill() -> None:
    steps, _ = ending(FAR, FULL_BRAKE)
    slow = sum(step[0]["ego"][3] < 0.2 for step in steps)
    assert (steps[-1][4]["status"], steps[-1][3], slow) == ("stuck", True, 600)


STOP = '[goal]\ns_m = 190.0\nkind = "stop"\n'


def braking_at(x: float) -> Callable[[FourLane], Floats]:
    return lambda env: FULL_BRAKE if env.ego.position[0] >= x else NEUTRAL


@pytest.mark.usefixtures("blind")
def test_stop_goal_needs_two_seconds_at_1_to_15_m() -> None:
    env = FourLane(scenario(STOP + BARRIER), rig=SMALL)
    steps = drive(env, braking_at(28.0))
    standing = sum(step[0]["ego"][3] < 0.05 for step in steps)
    assert (steps[-1][4]["status"], standing) == ("success", 120)
    assert 1.0 < steps[-1][4]["clearance_m"] < 15.0


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("x", [10.0, 34.3])
def test_stop_goal_fails_too_far_or_too_near(x: float) -> None:
    env = FourLane(scenario(STOP + BARRIER), rig=SMALL)
    steps = drive(env, braking_at(x))
    assert steps[-1][4]["status"] == "stuck"
    assert not 1.0 <= steps[-1][4]["clearance_m"] <= 15.0


class Frames(FakeRenderer):
    """Frames that become invalid after half a second."""

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


def test_camera_broken_from_the_start_is_reported_at_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", Blind)
    env = FourLane(scenario(FAR), rig=SMALL)
    _, info = env.reset(seed=0)
    assert info["status"] == "invalid_frame"
    observed, *_, truncated, info = env.step(NEUTRAL)
    assert truncated
    assert observed["time"] == pytest.approx(1.0 / 60.0), "the step is carried out"
    assert info["invalid_frame"] == {"frame": 0, "time_s": 0.0, "fault": "black"}


def test_repeated_frame_is_valid_at_standstill(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", type("S", (Frames,), {"wrong": staticmethod(WRONG["stale"])}))
    steps, _ = ending(FAR + "[ego]\nspeed_mps = 0.0\n")
    assert steps[-1][4]["status"] == "stuck"
