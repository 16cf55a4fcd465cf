"""Scripted drives: a camera follows a given path, so that every weather shows the same poses."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import atan2, cos, pi

import numpy as np

from vpf_sim.envs.camera import Renderer, Rig, Weather
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.road import build_road
from vpf_sim.envs.road_objects import place_objects
from vpf_sim.evaluation.truth.true_motion import Shot
from vpf_sim.scenarios import Scenario
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

SLOPE_STEP_M = 0.1  # half step of the path's finite-difference heading


@dataclass(slots=True)
class Carrier:
    """The pose of the camera's carrier."""

    position: Floats = field(default_factory=lambda: np.zeros(2))  # (2,) m
    heading: float = 0.0  # rad


@dataclass(frozen=True, slots=True)
class Path:
    """A path along a road at constant speed: `offset_m(s)` right of the carriageway's centre."""

    start_m: float
    speed_mps: float
    offset_m: Callable[[float], float]


@dataclass(frozen=True, slots=True)
class ScriptedDrive:
    """A camera on a path; traffic keeps its lanes."""

    scenario: Scenario
    path: Path
    rig: Rig = field(default_factory=Rig)
    rate_hz: float = 60.0

    def shots(self, weather: Weather, seed: int, count: int) -> Iterator[Shot]:
        """Yield the first `count` frames in a weather."""
        road = build_road(self.scenario, stream(seed, "road"))
        place_objects(road, self.scenario)
        renderer = Renderer(road, self.rig, weather, seed)
        carrier = Carrier()
        for k in range(count):
            time_s = k / self.rate_hz
            pose = self.pose(road.network.centre, self.path.start_m + self.path.speed_mps * time_s)
            carrier.position, carrier.heading = pose[:2], float(pose[2])
            yield Shot(k, renderer.render(carrier, time_s), pose, renderer)
            road.act()
            road.step(1.0 / self.rate_hz)

    def pose(self, centre: CentreLine, s_m: float) -> Floats:
        """(3,) pose on the path at s, heading along it."""
        x, y = centre.position_at(s_m, self.path.offset_m(s_m))
        behind, ahead = (centre.position_at(s, self.path.offset_m(s)) for s in (s_m - SLOPE_STEP_M, s_m + SLOPE_STEP_M))
        return np.array([x, y, atan2(ahead[1] - behind[1], ahead[0] - behind[0])])


def smooth_step(start_m: float, end_m: float, s_m: float) -> float:
    """0 before the start, 1 after the end, a half cosine between."""
    share = min(max((s_m - start_m) / (end_m - start_m), 0.0), 1.0)
    return 0.5 - 0.5 * cos(pi * share)
