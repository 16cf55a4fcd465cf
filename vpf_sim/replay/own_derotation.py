"""The focus of expansion when nothing about the camera's rotation is recorded: it is fitted from the flow itself."""

from dataclasses import replace

import numpy as np

from vpf_sim.perception import expansion
from vpf_sim.perception.flow import FlowTracker
from vpf_sim.planning.variant import Variant
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Image


class OwnDerotation:
    """Flow and focus of expansion of a variant, told of no turn at all.

    The yaw rate then is as unknown as the pitch rate, and is given the same room.
    """

    def __init__(self, camera: Camera, variant: Variant, rate_hz: float) -> None:
        pitch, _, roll = variant.expansion.rotation_sd_radps
        self._camera = camera
        self._config = replace(variant.expansion, rotation_sd_radps=(pitch, pitch, roll))
        self._tracker = FlowTracker(camera, variant.flow, rate_hz)
        self._random = stream(0, "focus of expansion without rotation")
        self._along_m = 0.0

    def update(self, grey: Image, moved_m: float) -> Expansion:
        """At a grey (H, W) frame, `moved_m` on from the last, as the odometer has it."""
        self._along_m += moved_m
        flow = self._tracker.update(grey, np.array([self._along_m, 0.0, 0.0]))
        return expansion.estimate(flow, self._camera, self._config, self._random)
