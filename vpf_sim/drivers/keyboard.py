"""The driver that is a person: the camera's frames in a window, throttle and steering by keys or a gamepad."""

from contextlib import suppress
from dataclasses import dataclass, field
from math import atan, pi
from typing import Protocol
from weakref import finalize

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.types import Image, VehicleModel
from vpf_sim.window import Inputs, Pace, Window, require_display

KEYS = "arrows or WASD drive, space brakes, P pauses, Esc gives up"
THROTTLE_KEYS, BRAKE_KEYS = {"up", "w"}, {"down", "s", "space"}
LEFT_KEYS, RIGHT_KEYS = {"left", "a"}, {"right", "d"}
PEDAL_PER_S = 3.0  # how fast a held key presses a pedal; it is released at once
WHEEL_PER_S, RETURN_PER_S = 1.5, 4.0  # how fast a held key turns the wheel, and how fast it returns
SIDEWARD_MPS2 = 4.0  # what a fully turned wheel gives, so that keys can steer a fast car
MOST_LEFT_OUT = 4  # frames one after another
DEAD_AXIS = 0.08  # of a gamepad


class View(Protocol):
    """What the window shows of an observation."""

    @property
    def needs_every_frame(self) -> bool:
        """Whether no frame may be left out to keep the time."""
        return False

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        """Begin an episode."""
        return

    def press(self, key: str) -> None:  # noqa: ARG002
        """A key that may change the view."""
        return

    def picture(self, observation: Observation) -> Image:
        """(H, W, 3) RGB of the camera's size."""
        ...


class Camera(View):
    """The frame alone."""

    def picture(self, observation: Observation) -> Image:
        return observation.image


@dataclass(slots=True)
class Hands:
    """Pedals and steering wheel, moved by keys and by the axes of a gamepad."""

    vehicle: VehicleModel
    throttle: float = field(default=0.0, init=False)  # [-1, 1]
    wheel: float = field(default=0.0, init=False)  # [-1, 1]

    def command(self, inputs: Inputs, speed_mps: float, passed_s: float) -> Command:
        """The command after `passed_s` with these keys held."""
        pedal = bool(inputs.held & THROTTLE_KEYS) - bool(inputs.held & BRAKE_KEYS)
        turn = bool(inputs.held & RIGHT_KEYS) - bool(inputs.held & LEFT_KEYS)
        self.throttle = _towards(pedal, self.throttle if pedal * self.throttle > 0 else 0.0, PEDAL_PER_S * passed_s)
        returns = turn * self.wheel <= 0.0
        self.wheel = _towards(turn, self.wheel, (RETURN_PER_S if returns and self.wheel else WHEEL_PER_S) * passed_s)
        axes = inputs.axes
        throttle = self.throttle + _alive(axes.get("throttle", 0.0)) - _alive(axes.get("brake", 0.0))
        wheel = self.wheel + _alive(axes.get("steering", 0.0))
        return Command(_limited(throttle), _limited(wheel) * self.full_steering(speed_mps))

    def full_steering(self, speed_mps: float) -> float:
        """The steering in [0, 1] that a fully turned wheel gives at a speed."""
        angle_rad = atan(self.vehicle.wheelbase_m * SIDEWARD_MPS2 / speed_mps**2) if speed_mps > 0.0 else 0.5 * pi
        return min(angle_rad / self.vehicle.steering_limit_rad, 1.0)


class KeyboardDriver(Driver):
    """A person at the keys or a gamepad. The episode begins with the first key, and runs in real time."""

    privileged: Privilege = "none"

    def __init__(self, view: View | None = None) -> None:
        self._view = view or Camera()
        self._window: Window | None = None

    @property
    def needs_next_frame(self) -> bool:
        """On a slow machine frames are left out, so that the time stays real."""
        return self._view.needs_every_frame or not self._pace.is_late or self._left_out >= MOST_LEFT_OUT

    def reset(self, setup: DriverSetup) -> None:
        require_display()
        if self._window is None:
            self._window = Window(setup.camera.width_px, setup.camera.height_px, setup.rate_hz, grows=True)
            finalize(self, self._window.close)
        self._inputs, self._hands, self._pace = Inputs(), Hands(setup.vehicle), Pace(setup.rate_hz)
        self._passed_s, self._left_out, self._waits = 1.0 / setup.rate_hz, 0, True
        self._view.reset(setup)

    def act(self, observation: Observation) -> Command:
        self._left_out = 0 if observation.image.size else self._left_out + 1
        if not self._left_out:
            self._show(self._view.picture(observation))
        pressed = self._pressed(observation.time_s)
        for key in pressed:
            self._view.press(key)
        self._pace.wait(observation.time_s)
        return self._hands.command(self._inputs, observation.speed_mps, self._passed_s)

    def close(self, last: Image) -> None:
        """Show a last picture until a key is pressed."""
        self._waits = True
        self._show(last)
        with suppress(KeyboardInterrupt):  # Escape
            self._inputs.wait()

    def _pressed(self, time_s: float) -> list[str]:
        """The keys that went down; at the start and after a pause the next ones."""
        if not self._waits:
            pressed = self._inputs.poll()
            self._waits = "p" in pressed
            return pressed
        pressed, self._waits = self._inputs.wait(), False
        self._pace.start(time_s)
        return pressed

    def _show(self, picture: Image) -> None:
        assert self._window is not None
        self._window.draw(picture)
        self._window.caption(f"vpf_sim: {'any key goes on; ' if self._waits else ''}{KEYS}")


def _towards(wanted: float, now: float, step: float) -> float:
    return now + min(max(wanted - now, -step), step)


def _alive(axis: float) -> float:
    """An axis with its dead part at the middle taken out, [-1, 1]."""
    return max(abs(axis) - DEAD_AXIS, 0.0) / (1.0 - DEAD_AXIS) * (1.0 if axis > 0.0 else -1.0)


def _limited(value: float) -> float:
    return min(max(value, -1.0), 1.0)
