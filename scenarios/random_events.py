"""What happens on a random road: crossing, cutting in, braking hard, doors, oncoming traffic. The seed draws it."""

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from vpf_sim.scenarios.kinds import SIZES, ObjectKind
from vpf_sim.scenarios.parts import Ego, Goal, Manoeuvre, ObjectSpec, Road

Event = Literal["crossing", "cut-in", "hard-brake", "door"]
EVENTS: tuple[Event, ...] = ("crossing", "cut-in", "hard-brake", "door")

CROSSING_MPS: dict[ObjectKind, tuple[float, float]] = {
    "pedestrian": (1.0, 2.0),
    "cyclist": (2.5, 4.5),
    "deer": (3.0, 6.0),
}
VEHICLES: tuple[ObjectKind, ...] = ("car", "van", "truck")
BESIDE_M = (1.0, 3.0)  # from the carriageway's edge, where crossing begins and ends
TO_SPARE_M = (1.0, 9.0)  # distance left to the ego when an actor that crosses is in its lane, if the ego does not brake
CUT_IN_M, CUT_IN_MPS = (8.0, 15.0), (0.8, 1.5)  # free road at which it begins, and speed sideways
BRAKES_WITHIN_M, BRAKES_MPS2 = (8.0, 16.0), (4.0, 8.0)
WAITS_S, GOES_ON_MPS = (3.0, 7.0), (6.5, 9.0)
OPENS_WITHIN_M, OPENS_MPS = (6.0, 14.0), (1.0, 2.0)
OPEN_M = 0.95  # how far a door reaches out
FIRST_ONCOMING_M, ONCOMING_MPS = 80.0, (5.0, 12.0)
LEAST_STRETCH_M, APART_M = 30.0, 15.0  # of road for each, and between the middles of two
DOOR_ROOM_M = 12.0  # of road on either side of a parked car without a row of objects
LAST_M = 25.0  # least distance of a place from the goal


def events(
    kinds: tuple[Event, ...],
    count: int,
    road: Road,
    ego: Ego,
    goal: Goal,
    rows_m: Sequence[float],
    rng: np.random.Generator,
) -> Iterator[ObjectSpec]:
    """`count` events, evenly spread along the route: one in each stretch. Rows of objects stand at `rows_m`.

    Where a vehicle has no room beside the ego's lane, it brakes hard in it instead.
    """
    stretch_m = max(goal.s_m - LAST_M - ego.s_m, 0.0) / max(count, 1)
    for number in range(count):
        s_m = ego.s_m + stretch_m * (number + float(rng.uniform(0.4, 0.9)))
        kind = kinds[int(rng.integers(len(kinds)))]
        if kind == "crossing":
            yield _crossing(road, ego, s_m, rng)
        elif kind == "door" and road.own_lanes > 1 and all(abs(row_m - s_m) > DOOR_ROOM_M for row_m in rows_m):
            yield from _door(road, ego, s_m, rng)
        elif kind == "cut-in" and road.own_lanes > 1:
            yield _cut_in(road, ego, s_m, rng)
        else:
            yield _hard_brake(ego, s_m, rng)


def oncoming(count: int, road: Road, ego: Ego, goal: Goal, rng: np.random.Generator) -> Iterator[ObjectSpec]:
    """`count` vehicles, or as many as fit, that come towards the ego in the leftmost lane: one in each stretch."""
    first_m = ego.s_m + FIRST_ONCOMING_M
    count = min(count, max(int((goal.s_m - first_m) // LEAST_STRETCH_M), 0))
    stretch_m = (goal.s_m - first_m) / max(count, 1)
    for number in range(count):
        s_m = first_m + stretch_m * number + float(rng.uniform(0.0, stretch_m - APART_M))
        speed_mps = float(rng.uniform(*ONCOMING_MPS))
        yield ObjectSpec(kind=_vehicle(rng), s_m=s_m, lane=road.lanes, speed_mps=speed_mps, oncoming=True)


def _crossing(road: Road, ego: Ego, s_m: float, rng: np.random.Generator) -> ObjectSpec:
    kinds = tuple(CROSSING_MPS)
    kind = kinds[int(rng.integers(len(kinds)))]
    side = 1.0 if rng.random() < 0.5 else -1.0
    lateral_mps = float(rng.uniform(*CROSSING_MPS[kind]))
    lane_m = road.lane_offset_m(ego.lane)
    starts_m, ends_m = (sign * (road.half_width_m + float(rng.uniform(*BESIDE_M))) for sign in (side, -side))
    way_s = abs(starts_m - lane_m) / lateral_mps
    within_m = ego.speed_reference_mps * way_s + float(rng.uniform(*TO_SPARE_M))
    crosses = Manoeuvre(within_m=within_m, lateral_m=ends_m - lane_m, lateral_mps=lateral_mps)
    return ObjectSpec(kind=kind, s_m=s_m, lane=ego.lane, lateral_m=starts_m - lane_m, manoeuvres=(crosses,))


def _cut_in(road: Road, ego: Ego, s_m: float, rng: np.random.Generator) -> ObjectSpec:
    """A slower vehicle in a lane beside the ego's, which moves in front of it, slows down, and goes on."""
    lane = _lane_beside(road, ego, rng)
    speed_mps = ego.speed_reference_mps * float(rng.uniform(0.4, 0.8))
    enters = Manoeuvre(
        within_m=float(rng.uniform(*CUT_IN_M)),
        lateral_m=road.lane_offset_m(ego.lane) - road.lane_offset_m(lane),
        lateral_mps=float(rng.uniform(*CUT_IN_MPS)),
        speed_mps=speed_mps * float(rng.uniform(0.5, 0.9)),
    )
    return ObjectSpec(kind=_vehicle(rng), s_m=s_m, lane=lane, speed_mps=speed_mps, manoeuvres=(enters, _goes_on(rng)))


def _door(road: Road, ego: Ego, s_m: float, rng: np.random.Generator) -> Iterator[ObjectSpec]:
    """A car parked in the lane beside, near the ego's, whose door opens as the ego comes near."""
    lane = _lane_beside(road, ego, rng)
    side = 1.0 if lane > ego.lane else -1.0  # on which the ego is, + is right
    car, panel = SIZES["car"], SIZES["door"]
    parked_m = side * 0.5 * (road.lane_width_m - car.width_m)
    closed_m = parked_m + side * 0.5 * (car.width_m + panel.width_m)
    open_m = parked_m + side * (0.5 * car.width_m + OPEN_M - 0.5 * panel.length_m)
    opens = Manoeuvre(
        within_m=float(rng.uniform(*OPENS_WITHIN_M)),
        lateral_m=open_m,
        lateral_mps=float(rng.uniform(*OPENS_MPS)),
    )
    yield ObjectSpec(kind="car", s_m=s_m, lane=lane, lateral_m=parked_m)
    yield ObjectSpec(kind="door", s_m=s_m + 0.5, lane=lane, lateral_m=closed_m, manoeuvres=(opens,))


def _lane_beside(road: Road, ego: Ego, rng: np.random.Generator) -> int:
    lanes = [lane for lane in (ego.lane - 1, ego.lane + 1) if 1 <= lane <= road.own_lanes]
    return lanes[int(rng.integers(len(lanes)))]


def _hard_brake(ego: Ego, s_m: float, rng: np.random.Generator) -> ObjectSpec:
    """A slower vehicle ahead, which stops hard as the ego comes near, and goes on."""
    speed_mps = ego.speed_reference_mps * float(rng.uniform(0.5, 0.9))
    brakes = Manoeuvre(
        within_m=float(rng.uniform(*BRAKES_WITHIN_M)), speed_mps=0.0, rate_mps2=float(rng.uniform(*BRAKES_MPS2))
    )
    return ObjectSpec(
        kind=_vehicle(rng), s_m=s_m, lane=ego.lane, speed_mps=speed_mps, manoeuvres=(brakes, _goes_on(rng))
    )


def _goes_on(rng: np.random.Generator) -> Manoeuvre:
    return Manoeuvre(after_s=float(rng.uniform(*WAITS_S)), speed_mps=float(rng.uniform(*GOES_ON_MPS)))


def _vehicle(rng: np.random.Generator) -> ObjectKind:
    return VEHICLES[int(rng.integers(len(VEHICLES)))]
