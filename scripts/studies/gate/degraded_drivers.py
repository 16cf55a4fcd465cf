"""Ten degradations of `vpf`, each a mistake that a change of code can make, for `gate_proof.py`.

Each is a small driver around the unchanged `vpf`, or a variant of it: `vpf-sim drive town04 --driver
degraded_drivers:SteeringBias` runs one, from this folder.
"""

from collections import deque
from dataclasses import replace
from math import radians, tan
from pathlib import Path

import cv2
import numpy as np

import vpf_sim
from vpf_sim import drivers
from vpf_sim.types import Image, Plan


class Degraded(vpf_sim.Driver):
    """`vpf` without a degradation; subclasses change its setup, its observations or its commands."""

    def __init__(self) -> None:
        self._driver = drivers.create("vpf")

    @property
    def needs_next_frame(self) -> bool:
        return drivers.needs_next_frame(self._driver)

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        self._driver.reset(self.setup(setup))

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        return self.command(self._driver.act(self.observation(observation)))

    def trace(self) -> Plan | None:
        return self._driver.trace()

    def setup(self, setup: vpf_sim.DriverSetup) -> vpf_sim.DriverSetup:
        """The setup that `vpf` gets."""
        return setup

    def observation(self, observation: vpf_sim.Observation) -> vpf_sim.Observation:
        """The observation that `vpf` gets."""
        return observation

    def command(self, command: vpf_sim.Command) -> vpf_sim.Command:
        """The command that is carried out."""
        return command


class SteeringBias(Degraded):
    """The steering has an offset of 2 degrees to the right."""

    def command(self, command: vpf_sim.Command) -> vpf_sim.Command:
        return replace(command, steering=command.steering + 2.0 / 40.0)


class LateCommands(Degraded):
    """Commands are carried out 0.3 s late."""

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        super().reset(setup)
        self._queue = deque([vpf_sim.Command(0.0, 0.0)] * round(0.3 * setup.rate_hz))

    def command(self, command: vpf_sim.Command) -> vpf_sim.Command:
        self._queue.append(command)
        return self._queue.popleft()


class CoarseSteering(Degraded):
    """The steering is rounded to steps of 4 degrees."""

    def command(self, command: vpf_sim.Command) -> vpf_sim.Command:
        return replace(command, steering=round(command.steering * 10.0) / 10.0)


class WeakBrakes(Degraded):
    """The brake command is scaled by 0.25."""

    def command(self, command: vpf_sim.Command) -> vpf_sim.Command:
        return replace(command, throttle=max(command.throttle, 0.25 * command.throttle))


class YawRateSign(Degraded):
    """The yaw rate has the wrong sign: an axis that points up instead of down."""

    def observation(self, observation: vpf_sim.Observation) -> vpf_sim.Observation:
        return replace(observation, yaw_rate_radps=-observation.yaw_rate_radps)


class WrongMounting(Degraded):
    """The camera is taken to look 2 degrees farther left than it does."""

    def setup(self, setup: vpf_sim.DriverSetup) -> vpf_sim.DriverSetup:
        camera = setup.camera
        shift_px = camera.fx_px * tan(radians(2.0))
        return replace(setup, camera=replace(camera, cx_px=camera.cx_px + shift_px))


class NoisyFlow(Degraded):
    """Each frame is shifted at random by about a pixel, so that the optical flow is noisy."""

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        super().reset(setup)
        self._random = np.random.default_rng(setup.seed)

    def observation(self, observation: vpf_sim.Observation) -> vpf_sim.Observation:
        if not observation.image.size:
            return observation
        dx, dy = self._random.normal(0.0, 1.0, 2)
        height, width = observation.image.shape[:2]
        shift = np.array([[1.0, 0.0, dx], [0.0, 1.0, dy]])
        image = cv2.warpAffine(observation.image, shift, (width, height), borderMode=cv2.BORDER_REPLICATE)
        return replace(observation, image=image)


class StaleFrames(Degraded):
    """Frames are 0.25 s old, but have the time stamp of now."""

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        super().reset(setup)
        self._frames: deque[Image] = deque(maxlen=round(0.25 * setup.rate_hz) + 1)

    @property
    def needs_next_frame(self) -> bool:
        return True

    def observation(self, observation: vpf_sim.Observation) -> vpf_sim.Observation:
        self._frames.append(observation.image)
        return replace(observation, image=self._frames[0])


DEGRADED = {
    "steering bias": "degraded_drivers:SteeringBias",
    "late commands": "degraded_drivers:LateCommands",
    "coarse steering": "degraded_drivers:CoarseSteering",
    "weak brakes": "degraded_drivers:WeakBrakes",
    "yaw rate sign": "degraded_drivers:YawRateSign",
    "wrong mounting": "degraded_drivers:WrongMounting",
    "noisy flow": "degraded_drivers:NoisyFlow",
    "stale frames": "degraded_drivers:StaleFrames",
    "blind to low obstacles": f"vpf@{Path(__file__).with_name('blind_to_low_obstacles.toml')}",
    "blind to moving cars": "vpf@static_obstacles",
}
