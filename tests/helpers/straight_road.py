"""The environment on 200 m of straight road, with frames that cost nothing."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.four_lane import FourLane
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
