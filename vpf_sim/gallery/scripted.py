"""Scripted drives: a camera follows a given path, so that every weather shows the same poses."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import atan2, cos, pi

import numpy as np
from highway_env.road.road import Road

from vpf_sim.envs.camera import Renderer, Rig, Weather
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.road import build_road
from vpf_sim.envs.road_objects import place_objects
from vpf_sim.envs.sensors import Sensors
from vpf_sim.evaluation.truth.true_motion import Shot
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.parts import Sensors as SensorErrors
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

    def s_m(self, time_s: float) -> float:
        """The place along the road at a time."""
        return self.start_m + self.speed_mps * time_s


@dataclass(frozen=True, slots=True)
class TimedPath:
    """A path along a road on which the places at N times are given; its last speed is kept."""

    times_s: Floats  # (N,) ascending
    places_m: Floats  # (N,) s along the road
    offset_m: Callable[[float], float]

    def s_m(self, time_s: float) -> float:
        """The place along the road at a time."""
        (before_s, last_s), (before_m, last_m) = self.times_s[-2:], self.places_m[-2:]
        beyond_s = max(time_s - last_s, 0.0)
        beyond_m = beyond_s * (last_m - before_m) / (last_s - before_s)
        return float(np.interp(time_s, self.times_s, self.places_m) + beyond_m)


@dataclass(frozen=True, slots=True)
class ScriptedDrive:
    """A camera on a path; traffic keeps its lanes, and `moved` has the places s of bodies over time, by number."""

    scenario: Scenario
    path: Path | TimedPath
    rig: Rig = field(default_factory=Rig)
    rate_hz: float = 60.0
    moved: Mapping[int, Callable[[float], float]] = field(default_factory=dict)
    pitch_deg: float = 0.0  # standard deviation of the body's pitch on its springs

    def shots(self, weather: Weather, seed: int, count: int) -> Iterator[Shot]:
        """Yield the first `count` frames in a weather."""
        road = build_road(self.scenario, stream(seed, "road"))
        place_objects(road, self.scenario)
        renderer = Renderer(road, self.rig, weather, seed)
        body = Sensors(SensorErrors(pitch_deg=self.pitch_deg), self.rig.camera, self.rate_hz, seed)
        carrier = Carrier()
        for k in range(count):
            time_s = k / self.rate_hz
            self._move(road, time_s)
            pose = self.pose(road.network.centre, self.path.s_m(time_s))
            carrier.position, carrier.heading = pose[:2], float(pose[2])
            level = renderer.render(carrier, time_s)
            pitched = body.frame(level)
            yield Shot(k, level if pitched is None else pitched, pose, renderer)
            road.act()
            road.step(1.0 / self.rate_hz)

    def _move(self, road: Road, time_s: float) -> None:
        """Put the bodies with given places there."""
        actors = [number for number, body in enumerate(self.scenario.bodies) if body.is_actor]
        for number, s_m in self.moved.items():
            road.vehicles[actors.index(number)].put_at(s_m(time_s))

    def pose(self, centre: CentreLine, s_m: float) -> Floats:
        """(3,) pose on the path at s, heading along it."""
        x, y = centre.position_at(s_m, self.path.offset_m(s_m))
        behind, ahead = (centre.position_at(s, self.path.offset_m(s)) for s in (s_m - SLOPE_STEP_M, s_m + SLOPE_STEP_M))
        return np.array([x, y, atan2(ahead[1] - behind[1], ahead[0] - behind[0])])


def smooth_step(start_m: float, end_m: float, s_m: float) -> float:
    """0 before the start, 1 after the end, a half cosine between."""
    share = min(max((s_m - start_m) / (end_m - start_m), 0.0), 1.0)
    return 0.5 - 0.5 * cos(pi * share)
