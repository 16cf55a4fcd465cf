"""A straight road with objects, driven at 5 m/s, and a synthetic perception with known errors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import nan
from types import SimpleNamespace
from typing import Any

import numpy as np

from vpf_sim.envs.contacts import nearest
from vpf_sim.envs.road import Carriageway
from vpf_sim.evaluation.perception.scorer import DriveEvaluation, PerceptionScorer
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.scenarios.kinds import SIZES, ObjectKind
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Expansion, Obstacles, RoadEdges

RATE_HZ, SPEED_MPS = 20.0, 5.0
EGO_M = (4.5, 1.9)  # length, width
LANE_M = 1.75  # of the own lane's middle, right of the road's centre, on which the ego drives
FOE_PX = (320.0, 240.0)


@dataclass(frozen=True)
class Stands:
    """An object on the road: m along it and right of its centre, with a speed along it."""

    kind: ObjectKind
    x_m: float
    y_m: float = LANE_M
    speed_mps: float = 0.0


@dataclass(frozen=True)
class Report:
    """One report in the ego's axes."""

    forward_m: float
    left_m: float
    right_m: float
    speed_mps: float = 0.0
    identity: int = 1
    existence: float = nan


@dataclass(frozen=True)
class Seen:
    """What is made up for one frame: errors of edges, lane and focus of expansion, and reports."""

    detections: Sequence[Report] = ()
    left_m: float = 0.0  # error to the right
    right_m: float = 0.0
    lane_m: float = 0.0
    foe_px: tuple[float, float] = (0.0, 0.0)
    road: float = 1.0  # confidence of edges and lane


def truth(obj: Stands, x_m: float, seconds: float, identity: int) -> Report:
    """A report without any error, for an ego at `x_m` on its lane."""
    size, aside = SIZES[obj.kind], obj.y_m - LANE_M
    ahead = obj.x_m + obj.speed_mps * seconds - x_m - 0.5 * size.length_m
    return Report(ahead, aside - 0.5 * size.width_m, aside + 0.5 * size.width_m, obj.speed_mps, identity)


def perfect(objects: Sequence[Stands], sight_m: float = 60.0) -> Callable[[float, float], Seen]:
    """A perception that knows everything within `sight_m` of the ego's centre."""

    def see(x_m: float, seconds: float) -> Seen:
        detections = [truth(obj, x_m, seconds, k) for k, obj in enumerate(objects)]
        return Seen([one for one in detections if 0.0 < one.forward_m < sight_m])

    return see


def drive(
    objects: Sequence[Stands],
    see: Callable[[float, float], Seen],
    length_m: float = 100.0,
    weather: str = "clear",
    seed: int = 0,
    driver: str = "made-up",
) -> DriveEvaluation:
    """The evaluation of a drive of `length_m` along the lane's middle; `see` is called at (x m, s) of each frame."""
    straight = Road.model_validate({"start_m": [0.0, 0.0], "segments": [{"kind": "line", "length_m": 400.0}]})
    road: Any = SimpleNamespace(network=Carriageway(straight), vehicles=[], objects=[])
    things = [_thing(obj, road) for obj in objects]
    road.objects += things
    rows = round(length_m / SPEED_MPS * RATE_HZ) + 1
    scorer = PerceptionScorer(rows)
    for row in range(rows - 1):
        seconds = row / RATE_HZ
        for thing, obj in zip(things, objects, strict=True):
            thing.place = (obj.x_m + obj.speed_mps * seconds, obj.y_m)
            thing.position = np.array(thing.place)
        x_m = seconds * SPEED_MPS
        ego: Any = SimpleNamespace(position=np.array([x_m, LANE_M]), heading=0.0, place=(x_m, LANE_M), road=road)
        ego.LENGTH, ego.WIDTH = EGO_M
        ego.diagonal = float(np.hypot(*EGO_M))
        world = SimpleNamespace(ego=ego, road=road, nearest=nearest(ego))
        scorer.add(row, _perception(see(x_m, seconds)), world, {"lane_offset_m": 0.0, "foe": FOE_PX})
    steps = StepTable.of([Step(row / RATE_HZ, *[0.0] * 7, np.inf) for row in range(rows)])
    name = f"road.{weather}.pid.{seed}"
    table, detections = steps.replaced(scorer.columns), scorer.detections_table()
    return DriveEvaluation(name, "road", weather, seed, driver, "same", table, scorer.lane_error_m, detections)


class Thing(SimpleNamespace):
    """One of its own, whatever it has in common with another."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def diagonal(self) -> float:
        """m, as objects of highway-env have it."""
        return float(np.hypot(self.LENGTH, self.WIDTH))


def _thing(obj: Stands, road: Any) -> Any:
    size = SIZES[obj.kind]
    thing = Thing(kind=obj.kind, heading=0.0, LENGTH=size.length_m, WIDTH=size.width_m, road=road)
    thing.speed = obj.speed_mps
    return thing


def _perception(seen: Seen) -> Any:
    """The records that a driver would give."""
    columns = [
        np.array([getattr(one, name) for one in seen.detections], float) for name in ("forward_m", "left_m", "right_m")
    ]
    some, identity = np.ones(len(seen.detections)), np.array([one.identity for one in seen.detections], np.int64)
    speed, existence = (
        np.array([getattr(one, name) for one in seen.detections]) for name in ("speed_mps", "existence")
    )
    edges = (-7.0 - LANE_M + seen.left_m, 7.0 - LANE_M + seen.right_m)
    x, y = np.array(FOE_PX) + seen.foe_px
    return SimpleNamespace(
        obstacles=Obstacles(*columns, some, some, identity, speed, existence),
        expansion=Expansion(x, y, np.eye(2), np.empty(0, np.bool_), 1.0),
        road=RoadEdges(*edges, 0.0, 0.0, 0.1, seen.road, seen.lane_m, 3.5, seen.road),
    )
