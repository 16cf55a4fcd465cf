"""The camera poses of the gallery, equal in every weather."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import atan2, cos, pi
from typing import Any

import numpy as np
from highway_env.road.road import Road

from vpf_sim import scenarios
from vpf_sim.envs.actor import place_objects
from vpf_sim.envs.camera import Renderer, Rig, Weather
from vpf_sim.envs.camera.rig import preset
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.road import build_road
from vpf_sim.envs.sensors import Sensors
from vpf_sim.evaluation.truth.true_motion import Shot
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.parts import CameraName, ObjectSpec, RoadAppearance
from vpf_sim.scenarios.parts import Sensors as SensorErrors
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

SEED = 12
SUN_HEADING_DEG = 215.0  # heading of the sun in every preset
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
        sensors = Sensors(SensorErrors(pitch_deg=self.pitch_deg), self.rig.camera, self.rate_hz, seed)
        carrier = Carrier()
        for k in range(count):
            time_s = k / self.rate_hz
            self._move(road, time_s)
            pose = self.pose(road.network.centre, self.path.s_m(time_s))
            carrier.position, carrier.heading = pose[:2], float(pose[2])
            level = renderer.render(carrier, time_s)
            pitched = sensors.frame(level)
            yield Shot(k, level if pitched is None else pitched, pose, renderer)
            road.act()
            road.step(1.0 / self.rate_hz)

    def _move(self, road: Road, time_s: float) -> None:
        """Put the bodies with given places there."""
        actors = [number for number, obj in enumerate(self.scenario.bodies) if obj.is_actor]
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


@dataclass(frozen=True, slots=True)
class Pose:
    """A position on a road, reached at constant speed along a lane; `objects` have their positions at that time."""

    name: str
    caption: str
    scenario: str
    s_m: float
    lane: int = 2  # counted from the right
    speed_mps: float = 10.0
    objects: tuple[ObjectSpec, ...] = ()
    heading_deg: float | None = None  # of the road's start; None: the scenario's own
    look: RoadAppearance | None = None  # None: the scenario's own
    camera: CameraName = "default"

    def drive(self, lead_s: float, rate_hz: float) -> ScriptedDrive:
        """The drive of `lead_s` seconds that ends at the pose."""
        scenario = self._scenario(lead_s)
        offset_m = scenario.road.lane_offset_m(self.lane)
        path = Path(self.s_m - lead_s * self.speed_mps, self.speed_mps, lambda _: offset_m)
        return ScriptedDrive(scenario, path, preset(self.camera), rate_hz)

    def _scenario(self, lead_s: float) -> Scenario:
        plain = scenarios.drawn_road(self.scenario, SEED)
        started = (_before(obj, lead_s) for obj in self.objects)
        road = plain.road
        if self.heading_deg is not None:
            road = road.model_copy(update={"heading_deg": self.heading_deg})
        if self.look is not None:
            road = road.model_copy(update={"look": self.look})
        return plain.model_copy(update={"road": road, "bodies": (*plain.bodies, *started)})


def _before(obj: ObjectSpec, lead_s: float) -> ObjectSpec:
    """An object where it was `lead_s` seconds ago."""
    driven_m = lead_s * obj.speed_mps * (-1.0 if obj.oncoming else 1.0)
    return obj.model_copy(update={"s_m": obj.s_m - driven_m})


def _object(kind: str, s_m: float, lane: int, lateral_m: float = 0.0, **more: Any) -> ObjectSpec:
    return ObjectSpec.model_validate({"kind": kind, "s_m": s_m, "lane": lane, "lateral_m": lateral_m, **more})


POSES = (
    Pose(
        "car-ahead",
        "a car 14 m ahead, at the same speed",
        "straight",
        s_m=90.0,
        objects=(
            _object("car", 107.0, 2, speed_mps=10.0),
            _object("van", 132.0, 3, speed_mps=11.0),
            _object("car", 121.0, 1, speed_mps=9.0),
        ),
    ),
    Pose(
        "bend", "into a bend to the right", "curve-right", s_m=52.0, objects=(_object("car", 84.0, 3, speed_mps=10.0),)
    ),
    Pose(
        "truck",
        "beside a truck",
        "straight",
        s_m=90.0,
        objects=(_object("truck", 99.0, 3, speed_mps=10.5), _object("car", 126.0, 2, speed_mps=10.0)),
    ),
    Pose("empty-road", "an empty road and its puddles", "straight", s_m=70.0, lane=1, speed_mps=8.0),
    Pose(
        "sun",
        "towards the sun",
        "straight",
        s_m=120.0,
        lane=3,
        heading_deg=SUN_HEADING_DEG,
        objects=(_object("car", 142.0, 2, speed_mps=10.0), _object("truck", 175.0, 1, speed_mps=9.0)),
    ),
    Pose("town04", "the paper's road, before its first parked car", "town04", s_m=61.0, speed_mps=5.55),
    Pose(
        "works",
        "cones, a barrier, a pallet, a pedestrian",
        "heading-30",
        s_m=70.0,
        lane=3,
        speed_mps=5.55,
        objects=(
            *(_object("cone", 78.0 + 5.0 * step, 2, 1.2 - 0.55 * step) for step in range(5)),
            _object("barrier", 95.0, 2, 0.4),
            _object("pallet", 84.0, 4, -0.6),
            _object("pedestrian", 88.0, 1, 0.8),
        ),
    ),
    Pose(
        "oncoming",
        "one lane each way: a cyclist, a deer, oncoming traffic",
        "oncoming",
        s_m=52.0,
        lane=1,
        speed_mps=8.0,
        objects=(
            _object("cyclist", 64.0, 1, 1.0, speed_mps=5.0),
            _object("deer", 65.0, 1, 2.6),
            _object("car", 72.0, 2, speed_mps=8.0, oncoming=True),
        ),
    ),
    Pose(
        "marks",
        "painted symbols, and shadows of the scenery",
        "curve-left",
        s_m=50.0,
        look=RoadAppearance(marks=True, shadows=True),
    ),
    Pose(
        "street",
        "a bus lane, tram rails, kerbs and hatching; the door of a parked car",
        "straight",
        s_m=60.0,
        lane=3,
        look=RoadAppearance(bus_lane=True, tram_rails=True, kerbs=True, double_lines=True, hatching=True),
        objects=(
            _object("car", 74.0, 2, -0.4),
            _object("door", 74.5, 2, -1.8, manoeuvres=({"after_s": 0.0, "lateral_m": -1.85, "lateral_mps": 1.0},)),
        ),
    ),
    Pose(
        "dash-cam",
        "through a dash-cam: bonnet, reflections, dirt, text",
        "straight",
        s_m=90.0,
        objects=(_object("car", 103.0, 2, speed_mps=10.0), _object("van", 118.0, 3, speed_mps=10.0)),
        camera="dash-cam",
    ),
)


def video_drive(rate_hz: float) -> ScriptedDrive:
    """A drive past the paper's first parked car, with traffic."""
    plain = scenarios.drawn_road("town04", SEED)
    traffic = (_object("car", 64.0, 1, speed_mps=12.0), _object("van", 95.0, 3, speed_mps=10.0))
    scenario = plain.model_copy(update={"bodies": (*plain.bodies, *traffic)})
    lane_m = scenario.road.lane_offset_m(2)

    def offset_m(s_m: float) -> float:
        return lane_m + 0.9 * (smooth_step(52.0, 70.0, s_m) - smooth_step(84.0, 102.0, s_m))

    return ScriptedDrive(scenario, Path(46.0, 11.0, offset_m), rate_hz=rate_hz)
