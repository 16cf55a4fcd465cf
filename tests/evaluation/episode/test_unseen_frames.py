"""Frames that the driver does not use are not rendered; the others and the drive are unchanged."""

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from short_scenario import SHORT
from straight_road import FAR, SMALL, FakeRenderer
from straight_road import scenario as straight

from vpf_sim import drivers, scenarios
from vpf_sim.driver_interface import Command
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.episode.episode import NO_FRAME, read, setup_for
from vpf_sim.types import Camera, Image

STEPS = 60
THIRD, SECOND, SELDOM = (lambda step: step % 3 == 0), (lambda step: step % 2 == 0), (lambda step: step in (20, 21, 58))
BUSY = """
schema = 1
[road]
segments = [{kind = "line", length_m = 30}, {kind = "arc", length_m = 200, radius_m = 100}]
[goal]
s_m = 200.0
[ego.sensors]
pitch_deg = 0.3
[[bodies]]
kind = "car"
s_m = 20.0
lane = 3
speed_mps = 7.0
[[bodies]]
kind = "truck"
s_m = 32.0
lane = 1
[[bodies]]
kind = "cone"
s_m = 24.0
lane = 4
"""
CAMERA = Rig(Camera(width_px=160, height_px=120, fx_px=80.0, fy_px=80.0, cx_px=79.5, cy_px=59.5))
RAIN = weathers.load("rain")
WEATHERS = {
    "clear": weathers.load("clear"),
    "wet": weathers.load("WetNoon"),
    "rain": RAIN,
    "rain before a dry glass": RAIN.model_copy(update={"droplets": 0.0, "wiper_period_s": 0.0}),
    "drops on the glass alone": weathers.load("clear").model_copy(update={"droplets": 80.0, "wiper_period_s": 1.5}),
}


def frames(weather: weathers.Weather, looks: Callable[[int], bool]) -> Iterator[tuple[int, Image]]:
    """The frames of the steps that are looked at, on a way that winds."""
    with closing(FourLane(scenarios.parse(BUSY, "busy.toml"), weather, rig=CAMERA)) as env:
        env.reset(seed=5)
        for step in range(1, STEPS):
            action = np.array([0.3 * np.sin(step / 9.0), 0.2 * np.sin(step / 25.0)])
            observed, *_ = env.step(action, with_frame=looks(step))
            assert ("image" in observed) == looks(step)
            if looks(step):
                yield step, observed["image"]


@pytest.mark.parametrize("weather", WEATHERS)
def test_frames_after_skipped_ones_are_unchanged(weather: str) -> None:
    every = dict(frames(WEATHERS[weather], lambda _: True))
    for looks in (THIRD, SECOND, SELDOM):
        for step, image in frames(WEATHERS[weather], looks):
            assert np.array_equal(image, every[step]), f"step {step}"


def test_a_step_without_a_frame_has_the_same_observation() -> None:
    seen, unseen = (FourLane("town04", "rain", truth=("foe", "depth")) for _ in range(2))
    with closing(seen), closing(unseen):
        for env in (seen, unseen):
            env.reset(seed=1)
        for _ in range(4):
            observed, *told, info = seen.step(np.array([0.5, 0.1]))
            other, *other_told, other_info = unseen.step(np.array([0.5, 0.1]), with_frame=False)
            assert told == other_told
            assert observed.keys() - other.keys() == {"image"}
            assert all(np.array_equal(observed[name], other[name]) for name in other)
            assert info.keys() - other_info.keys() == {"depth"}, "there is no picture to tell it of"
            assert all(np.array_equal(info[name], other_info[name]) for name in other_info)


class Stuck(FakeRenderer):
    """It shows the first frame for ever."""

    def render(self, ego: object, time_s: float) -> np.ndarray:  # noqa: ARG002
        return super().render(ego, 0.0)

    def skip(self, ego: object, time_s: float) -> None:
        """Nothing is drawn."""


def test_a_stale_frame_is_detected_across_skipped_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", Stuck)
    env = FourLane(straight(FAR), rig=SMALL)
    env.reset(seed=0)
    statuses = [env.step(np.zeros(2), with_frame=step == 5)[4]["status"] for step in range(6)]
    assert statuses == ["running"] * 5 + ["invalid_frame"]


@pytest.mark.parametrize("driver", ["vpf", "vpf@full-frame"])
def test_a_vision_driver_declares_which_frames_it_uses(driver: str) -> None:
    """It does the same where all others are kept from it, and another thing where one of its own is."""

    def done(blinded: Callable[[bool, int], bool]) -> tuple[list[tuple[Command, bytes]], int]:
        tested, found, looked = drivers.create(driver), [], 1
        with closing(FourLane(scenarios.parse(BUSY, "busy.toml"), "clear")) as env:
            observed, _ = env.reset(seed=5)
            tested.reset(setup_for(tested, env, 5))
            looks = True
            for step in range(STEPS):
                observation = read(observed)
                if blinded(looks, step):
                    observation = replace(observation, image=np.zeros_like(observation.image))
                command, plan = drivers.command_of(tested, observation), drivers.trace_of(tested)
                assert plan is not None
                found.append((command, plan.perception.flow.points_px.tobytes()))
                looks = drivers.needs_next_frame(tested)
                looked += looks
                observed, *_ = env.step(np.zeros(2))
        return found, looked

    whole, looked = done(lambda looks, step: False)  # noqa: ARG005
    assert looked == (1 + STEPS // 3 if driver == "vpf" else 1 + STEPS)
    assert done(lambda looks, step: not looks)[0] == whole  # noqa: ARG005
    assert done(lambda looks, step: looks and step > STEPS // 2)[0] != whole


def test_a_watched_drive_has_the_same_record(tmp_path: Path) -> None:
    path = tmp_path / "short.toml"
    path.write_text(SHORT)
    shown: list[Image] = []
    alone = episode.run(str(path), "rain", "vpf", 3)
    watched = episode.run(str(path), "rain", "vpf", 3, watch=lambda image, _: shown.append(image))
    assert watched.record == alone.record
    assert len(shown) == alone.record.steps
    assert all(image.shape != NO_FRAME.shape for image in shown)
    assert np.flatnonzero(alone.steps.looked).tolist() == list(range(0, len(shown), 3))
