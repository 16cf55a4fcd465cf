"""The driver that is a person: what keys and a gamepad do, the pace, and the window."""

from dataclasses import replace

import numpy as np
import pygame
import pytest
from key_events import Person, axis, key

from vpf_sim import drivers, window
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.keyboard import DEAD_AXIS, MOST_LEFT_OUT, SIDEWARD_MPS2, Hands, KeyboardDriver
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, VehicleModel

SETUP = DriverSetup(Camera(64, 48), VehicleModel(), 60.0, 5.55, (150.0, 0.0), 0)
STEP_S = 1.0 / 60.0


def seen(step: int, speed_mps: float = 5.55) -> Observation:
    image = np.full((48, 64, 3), 40 + step % 100, np.uint8)
    return Observation(image, step * STEP_S, 0.0, 0.0, 0.0, speed_mps, 0.0, (150.0, 0.0))


def commands(
    monkeypatch: pytest.MonkeyPatch, script: dict[int, list[pygame.event.Event]], steps: int, speed_mps: float = 5.55
) -> list[tuple[float, float]]:
    """(throttle, steering) of each step, with a script of events by the number of the look at them."""
    Person(monkeypatch, lambda look: script.get(look, []))
    driver = drivers.create("keyboard")
    driver.reset(SETUP)
    return [(one.throttle, one.steering) for one in (driver.act(seen(i, speed_mps)) for i in range(steps))]


def test_a_held_key_presses_the_pedal_and_its_release_lets_go(monkeypatch: pytest.MonkeyPatch) -> None:
    made = commands(monkeypatch, {0: [key("w")], 30: [key("w", down=False)]}, 32)
    throttle = [one for one, _ in made]
    assert throttle[:3] == pytest.approx([0.05, 0.1, 0.15])
    assert throttle[29] == 1.0
    assert throttle[30:] == [0.0, 0.0]
    assert {steering for _, steering in made} == {0.0}


@pytest.mark.parametrize(("name", "sign"), [("down", -1), ("s", -1), ("space", -1), ("up", 1), ("w", 1)])
def test_pedal_keys(name: str, sign: int, monkeypatch: pytest.MonkeyPatch) -> None:
    assert commands(monkeypatch, {0: [key(name)]}, 25)[-1] == (sign, 0.0)


@pytest.mark.parametrize(("name", "sign"), [("left", -1), ("a", -1), ("right", 1), ("d", 1)])
def test_a_turned_wheel_gives_the_same_sideward_acceleration_at_every_speed(
    name: str, sign: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = VehicleModel()
    for speed_mps in (6.0, 12.0, 30.0):
        _, steering = commands(monkeypatch, {0: [key(name)]}, 60, speed_mps)[-1]
        radius_m = vehicle.wheelbase_m / np.tan(abs(steering) * vehicle.steering_limit_rad)
        assert np.sign(steering) == sign
        assert speed_mps**2 / radius_m == pytest.approx(SIDEWARD_MPS2)
    assert commands(monkeypatch, {0: [key(name)]}, 60, 0.0)[-1] == (0.0, sign)


def test_the_wheel_returns_faster_than_it_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    made = commands(monkeypatch, {0: [key("d")], 20: [key("d", down=False)]}, 30, 0.0)
    steering = [one for _, one in made]
    assert steering[19] == pytest.approx(0.5)
    assert steering[20] < steering[19] - 0.05
    assert steering[-1] == 0.0


def test_opposite_keys_cancel(monkeypatch: pytest.MonkeyPatch) -> None:
    assert commands(monkeypatch, {0: [key("a"), key("d"), key("up"), key("down")]}, 5)[-1] == (0.0, 0.0)


def test_a_gamepad(monkeypatch: pytest.MonkeyPatch) -> None:
    stick, left, right = (
        pygame.CONTROLLER_AXIS_LEFTX,
        pygame.CONTROLLER_AXIS_TRIGGERLEFT,
        pygame.CONTROLLER_AXIS_TRIGGERRIGHT,
    )
    start = pygame.event.Event(pygame.CONTROLLERBUTTONDOWN, button=0)
    script = {
        0: [start, axis(right, 32767)],
        1: [axis(right, 0), axis(left, 32767), axis(stick, -32768)],
        2: [axis(left, 0), axis(stick, round(0.9 * DEAD_AXIS * 32767))],
        3: [axis(stick, 32767), axis(pygame.CONTROLLER_AXIS_RIGHTX, 32767)],
    }
    assert commands(monkeypatch, script, 4, 0.0) == [(1.0, 0.0), (-1.0, -1.0), (0.0, 0.0), (0.0, 1.0)]


def test_it_waits_for_the_first_key_and_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pygame.time, "wait", lambda _: 0)
    script = {4: [key("q")], 6: [key("p")], 9: [key("p")]}
    person = Person(monkeypatch, lambda look: script.get(look, []))
    driver = drivers.create("keyboard")
    driver.reset(SETUP)
    looks = []
    for step in range(4):
        driver.act(seen(step))
        looks.append(person.looks)
    assert looks == [5, 6, 7, 10]  # the first waits for Q, the third is told to pause, the fourth waits for P


@pytest.mark.parametrize(
    "event", [pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE), pygame.event.Event(pygame.QUIT)]
)
def test_escape_and_a_closed_window_stop(event: pygame.event.Event, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(KeyboardInterrupt):
        commands(monkeypatch, {0: [event]}, 1)


def test_the_window_shows_the_frame_and_closes_with_the_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    Person(monkeypatch, lambda look: [key("q")] if look == 0 else [])
    driver = KeyboardDriver()
    driver.reset(SETUP)
    driver.act(seen(7))
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert (shown == seen(7).image).all()
    assert "arrows or WASD" in pygame.display.get_caption()[0]
    del driver
    assert not pygame.display.get_init()


def test_without_a_display_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with pytest.raises(InputError, match="no display: expected one that a window can be seen on"):
        drivers.create("keyboard").reset(SETUP)


class Clock:
    """A clock that only sleeping and `now_s` move."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        monkeypatch.setattr(window, "perf_counter", lambda: self.now_s)
        monkeypatch.setattr(window, "sleep", self.sleep)

    def sleep(self, time_s: float) -> None:
        assert time_s > 0.0
        self.now_s += time_s


def test_the_pace_is_that_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)
    pace = window.Pace(60.0)
    pace.start(2.0)
    for step in range(1, 61):
        clock.now_s += 0.005  # what the simulation takes
        pace.wait(2.0 + step * STEP_S)
        assert not pace.is_late
    assert clock.now_s == pytest.approx(101.0)


def test_a_short_delay_is_made_good_and_a_long_one_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)
    pace = window.Pace(60.0)
    pace.start(0.0)
    clock.now_s += 0.06
    pace.wait(0.0)
    assert pace.is_late
    for step in range(1, 11):
        pace.wait(step * STEP_S)
    assert not pace.is_late
    assert clock.now_s == pytest.approx(100.0 + 10 * STEP_S)
    clock.now_s += 5.0
    pace.wait(10 * STEP_S)
    for step in range(11, 71):
        pace.wait(step * STEP_S)
    assert clock.now_s == pytest.approx(100.0 + 10 * STEP_S + 5.0 + 60 * STEP_S - 6 * STEP_S)


def test_a_late_driver_leaves_frames_out(monkeypatch: pytest.MonkeyPatch) -> None:
    Person(monkeypatch, lambda look: [key("q")] if look == 0 else [])
    clock = Clock(monkeypatch)
    driver = drivers.create("keyboard")
    driver.reset(SETUP)
    driver.act(seen(0))
    assert drivers.needs_next_frame(driver)
    drawn = []
    for step in range(1, 13):
        clock.now_s += 0.06
        drawn.append(drivers.needs_next_frame(driver))
        observation = seen(step)
        driver.act(observation if drawn[-1] else replace(observation, image=np.empty((0, 0, 3), np.uint8)))
    assert drawn == [True, *[False] * MOST_LEFT_OUT, True, *[False] * MOST_LEFT_OUT, True, False]


def test_full_steering_is_never_more_than_full() -> None:
    hands = Hands(VehicleModel())
    assert [hands.full_steering(speed) for speed in (0.0, 0.5, 2.0)] == [1.0, 1.0, 1.0]
