"""The camera poses of the gallery, equal in every weather."""

from dataclasses import dataclass
from typing import Any

from vpf_sim import scenarios
from vpf_sim.envs.camera.rig import preset
from vpf_sim.gallery.scripted import Path, ScriptedDrive, smooth_step
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.parts import CameraName, ObjectSpec, RoadAppearance

SEED = 12
SUN_HEADING_DEG = 215.0  # heading of the sun in every preset


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
        started = (_before(body, lead_s) for body in self.objects)
        road = plain.road
        if self.heading_deg is not None:
            road = road.model_copy(update={"heading_deg": self.heading_deg})
        if self.look is not None:
            road = road.model_copy(update={"look": self.look})
        return plain.model_copy(update={"road": road, "bodies": (*plain.bodies, *started)})


def _before(body: ObjectSpec, lead_s: float) -> ObjectSpec:
    """An object where it was `lead_s` seconds ago."""
    driven_m = lead_s * body.speed_mps * (-1.0 if body.oncoming else 1.0)
    return body.model_copy(update={"s_m": body.s_m - driven_m})


def _body(kind: str, s_m: float, lane: int, lateral_m: float = 0.0, **more: Any) -> ObjectSpec:
    return ObjectSpec.model_validate({"kind": kind, "s_m": s_m, "lane": lane, "lateral_m": lateral_m, **more})


POSES = (
    Pose(
        "car-ahead",
        "a car 14 m ahead, at the same speed",
        "straight",
        s_m=90.0,
        objects=(
            _body("car", 107.0, 2, speed_mps=10.0),
            _body("van", 132.0, 3, speed_mps=11.0),
            _body("car", 121.0, 1, speed_mps=9.0),
        ),
    ),
    Pose("bend", "into a bend to the right", "curve-right", s_m=52.0, objects=(_body("car", 84.0, 3, speed_mps=10.0),)),
    Pose(
        "truck",
        "beside a truck",
        "straight",
        s_m=90.0,
        objects=(_body("truck", 99.0, 3, speed_mps=10.5), _body("car", 126.0, 2, speed_mps=10.0)),
    ),
    Pose("empty-road", "an empty road and its puddles", "straight", s_m=70.0, lane=1, speed_mps=8.0),
    Pose(
        "sun",
        "towards the sun",
        "straight",
        s_m=120.0,
        lane=3,
        heading_deg=SUN_HEADING_DEG,
        objects=(_body("car", 142.0, 2, speed_mps=10.0), _body("truck", 175.0, 1, speed_mps=9.0)),
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
            *(_body("cone", 78.0 + 5.0 * step, 2, 1.2 - 0.55 * step) for step in range(5)),
            _body("barrier", 95.0, 2, 0.4),
            _body("pallet", 84.0, 4, -0.6),
            _body("pedestrian", 88.0, 1, 0.8),
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
            _body("cyclist", 64.0, 1, 1.0, speed_mps=5.0),
            _body("deer", 65.0, 1, 2.6),
            _body("car", 72.0, 2, speed_mps=8.0, oncoming=True),
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
            _body("car", 74.0, 2, -0.4),
            _body("door", 74.5, 2, -1.8, manoeuvres=({"after_s": 0.0, "lateral_m": -1.85, "lateral_mps": 1.0},)),
        ),
    ),
    Pose(
        "dash-cam",
        "through a dash-cam: bonnet, reflections, dirt, text",
        "straight",
        s_m=90.0,
        objects=(_body("car", 103.0, 2, speed_mps=10.0), _body("van", 118.0, 3, speed_mps=10.0)),
        camera="dash-cam",
    ),
)


def video_drive(rate_hz: float) -> ScriptedDrive:
    """A drive past the paper's first parked car, with traffic."""
    plain = scenarios.drawn_road("town04", SEED)
    traffic = (_body("car", 64.0, 1, speed_mps=12.0), _body("van", 95.0, 3, speed_mps=10.0))
    scenario = plain.model_copy(update={"bodies": (*plain.bodies, *traffic)})
    lane_m = scenario.road.lane_offset_m(2)

    def offset_m(s_m: float) -> float:
        return lane_m + 0.9 * (smooth_step(52.0, 70.0, s_m) - smooth_step(84.0, 102.0, s_m))

    return ScriptedDrive(scenario, Path(46.0, 11.0, offset_m), rate_hz=rate_hz)
