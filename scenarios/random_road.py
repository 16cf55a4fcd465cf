"""Random scenarios: the seed draws road and obstacles within the limits of a file."""

from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, PositiveFloat

from vpf_sim.scenarios.kinds import SIZES, ObjectKind
from vpf_sim.scenarios.parts import (
    MOST_LANES,
    MOST_ROAD_M,
    Arc,
    Clothoid,
    ConsistentSection,
    Degrees,
    Ego,
    Exercise,
    Goal,
    Interval,
    Lanes,
    LaneWidth,
    Limits,
    Line,
    ObjectSpec,
    Road,
    RoadAppearance,
    Segment,
    Vary,
)
from vpf_sim.scenarios.random_events import EVENTS, Event, events, oncoming
from vpf_sim.scenarios.schema import Scenario, drawn
from vpf_sim.seeding import stream

BEYOND_GOAL_M = 60.0  # road beyond the goal
LAST_ROW_M = 15.0  # least distance of the last row from the goal
MOST_TURN_RAD = np.radians(80.0)  # largest turn from the first heading: the road never crosses itself
FIRST_LINE_M, LINE_M, ARC_M, CLOTHOID_M = (30.0, 60.0), (20.0, 60.0), (20.0, 70.0), (15.0, 30.0)
SIDE_GAP_M = 0.3  # between two obstacles of a row
KINDS: tuple[ObjectKind, ...] = ("car", "van", "truck", "cone", "pallet", "barrier", "pedestrian")  # drawn by default
TRIES = 40  # positions tried for each obstacle
Length = Annotated[float, Field(gt=0.0, le=MOST_ROAD_M / 2.0)]
Rows = Annotated[int, Field(ge=0, le=200)]
RowObjects = Annotated[int, Field(ge=1, le=20)]


class LateralInterval(NamedTuple):
    """An interval across the carriageway, m right of its centre."""

    left_m: float
    right_m: float

    def overlaps(self, other: "LateralInterval") -> bool:
        return self.left_m < other.right_m and other.left_m < self.right_m


class RandomRoad(ConsistentSection):
    """Limits of the uniform draws: a road of lines and bends, and rows of obstacles.

    Each row has a gap of at least `free_gap_m`. Its middle is at most `gap_shift_lanes` lanes from the previous row's;
    for the first row, from the ego's lane.
    """

    look: RoadAppearance = RoadAppearance()
    lanes: Lanes = Field(default=4, description="Number of lanes.")
    lane_width_m: LaneWidth = Field(default=3.5, description="Width of each lane.")
    length_m: Annotated[tuple[Length, Length], Field(strict=False)] = Field(
        default=(250.0, 400.0), description="Range of the route's length."
    )
    heading_deg: Annotated[tuple[Degrees, Degrees], Field(strict=False)] = Field(
        default=(-180.0, 180.0), description="Range of the first segment's heading."
    )
    radius_m: Interval = Field(default=(80.0, 400.0), description="Range of the radius of bends, to either side.")
    rows: Annotated[tuple[Rows, Rows], Field(strict=False)] = Field(
        default=(0, 4), description="Range of the number of rows of objects across the road."
    )
    row_bodies: Annotated[tuple[RowObjects, RowObjects], Field(strict=False)] = Field(
        default=(1, 3), description="Range of the number of objects in a row."
    )
    first_row_m: PositiveFloat = Field(default=50.0, description="Least distance of the first row from the ego.")
    row_spacing_m: PositiveFloat = Field(
        default=40.0, description="Least distance from the last object of a row to the first of the next."
    )
    free_gap_m: PositiveFloat = Field(default=3.5, description="Least width that each row leaves free.")
    gap_shift_lanes: PositiveFloat = Field(
        default=2.0, description="Largest shift of the gap's middle from that of the row before."
    )
    kinds: Annotated[tuple[ObjectKind, ...], Field(strict=False, min_length=1)] = Field(
        default=KINDS, description="Kinds of objects."
    )
    events: Annotated[tuple[Rows, Rows], Field(strict=False)] = Field(
        default=(0, 0), description="Range of the number of actors that get in the ego's way along the route."
    )
    event_kinds: Annotated[tuple[Event, ...], Field(strict=False, min_length=1)] = Field(
        default=EVENTS, description="What these actors do; one without room beside the ego's lane brakes hard in it."
    )
    oncoming: Annotated[tuple[Rows, Rows], Field(strict=False)] = Field(
        default=(0, 0),
        description="Range of the number of vehicles towards the ego, in one more lane on the left; as many as fit.",
    )

    @property
    def oncoming_lanes(self) -> int:
        return int(self.oncoming[1] > 0)

    def faults(self) -> Iterator[str]:
        """Every fault, for any seed."""
        for key in ("length_m", "heading_deg", "radius_m", "rows", "row_bodies", "events", "oncoming"):
            low, high = getattr(self, key)
            if low > high:
                yield f"{key}: expected [low, high] with low <= high, got [{low:g}, {high:g}]"
        if self.lanes + self.oncoming_lanes > MOST_LANES:
            yield f"lanes: expected at most {MOST_LANES - 1} beside the lane of oncoming traffic, got {self.lanes}"
        half_m, oncoming_m = self.lanes * self.lane_width_m / 2.0, self.oncoming_lanes * self.lane_width_m / 2.0
        if self.radius_m[0] <= half_m + oncoming_m:
            wide = f"{half_m + oncoming_m:g} m"
            yield f"radius_m: expected more than half the carriageway, {wide}, got {self.radius_m[0]:g}"
        if self.length_m[0] < self.first_row_m:
            yield f"length_m: expected at least first_row_m, {self.first_row_m:g} m, got {self.length_m[0]:g}"
        if self.free_gap_m > 2.0 * half_m:
            yield f"free_gap_m: expected at most the carriageway, {2.0 * half_m:g} m, got {self.free_gap_m:g}"


class RandomScenario(Exercise):
    """A scenario file with a section `random` in place of `road`, `goal` and `bodies`."""

    version: Literal[1] = Field(alias="schema")
    random: RandomRoad
    ego: Ego = Ego()
    limits: Limits | None = None
    vary: Vary = Field(default_factory=dict)

    def faults(self) -> Iterator[str]:
        """Every fault, for any seed."""
        for key in self.vary:
            if key[:3] != "ego":
                yield f'vary."{key}": expected a value of the ego, got one of the bodies'
        if self.ego.lane > self.random.lanes:
            yield f"ego.lane: expected 1 to {self.random.lanes}, counted from the right, got {self.ego.lane}"

    def draw(self, seed: int) -> Scenario:
        """The scenario of one seed."""
        rng = stream(seed, "random road")
        length_m = float(rng.uniform(*self.random.length_m))
        goal = Goal(s_m=self.ego.s_m + length_m)
        own = Road(
            look=self.random.look,
            lanes=self.random.lanes,
            lane_width_m=self.random.lane_width_m,
            heading_deg=float(rng.uniform(*self.random.heading_deg)),
            segments=tuple(_segments(self.random, goal.s_m + BEYOND_GOAL_M, rng)),
        )
        rows = list(_objects(self.random, own, self.ego, goal, stream(seed, "random rows")))
        added = self.random.oncoming_lanes
        road = own.model_copy(update={"lanes": own.lanes + added, "oncoming_lanes": added})
        acting, coming = stream(seed, "random events"), stream(seed, "random oncoming")
        count = _count(self.random.events, acting)
        rows_m = [body.s_m for body in rows]
        doing = events(self.random.event_kinds, count, road, self.ego, goal, rows_m, acting)
        towards = oncoming(_count(self.random.oncoming, coming), road, self.ego, goal, coming)
        bodies = (*rows, *doing, *towards)
        ego = drawn(self.ego, self.vary, "ego", "ego", seed)
        parts = {"road": road, "ego": ego, "goal": goal, "bodies": bodies, "limits": self.limits}
        return Scenario.model_validate({"schema": self.version, **parts})


def _count(limits: tuple[int, int], rng: np.random.Generator) -> int:
    return int(rng.integers(limits[0], limits[1] + 1))


def _segments(limits: RandomRoad, length_m: float, rng: np.random.Generator) -> Iterator[Segment]:
    """Random lines and bends, with and without clothoids, up to a length."""
    first = Line(kind="line", length_m=float(rng.uniform(*FIRST_LINE_M)))
    yield first
    laid_m, turned_rad = first.length_m, 0.0
    while laid_m < length_m:
        if rng.random() < 0.35:
            parts: list[Segment] = [Line(kind="line", length_m=float(rng.uniform(*LINE_M)))]
        else:
            parts, turn_rad = _bend(limits, turned_rad, rng)
            turned_rad += turn_rad
        yield from parts
        laid_m += sum(part.length_m for part in parts)


def _bend(limits: RandomRoad, turned_rad: float, rng: np.random.Generator) -> tuple[list[Segment], float]:
    """A random bend, half of them with clothoids, and its turn; the sign keeps the total turn bounded."""
    radius_m, arc_m = float(rng.uniform(*limits.radius_m)), float(rng.uniform(*ARC_M))
    clothoid_m = float(rng.uniform(*CLOTHOID_M)) if rng.random() < 0.5 else 0.0
    turn_rad = min((arc_m + clothoid_m) / radius_m, MOST_TURN_RAD)
    arc_m = max(turn_rad * radius_m - clothoid_m, 5.0)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    if abs(turned_rad + sign * turn_rad) > MOST_TURN_RAD:
        sign = -np.copysign(1.0, turned_rad)
    arc = Arc(kind="arc", length_m=arc_m, radius_m=sign * radius_m)
    if clothoid_m == 0.0:
        return [arc], sign * turn_rad
    into = Clothoid(kind="clothoid", length_m=clothoid_m, end_radius_m=sign * radius_m)
    return [into, arc, Clothoid(kind="clothoid", length_m=clothoid_m)], sign * turn_rad


def _objects(limits: RandomRoad, road: Road, ego: Ego, goal: Goal, rng: np.random.Generator) -> Iterator[ObjectSpec]:
    """Rows of obstacles, each with a gap that is reachable from the previous one."""
    longest_m = max(SIZES[kind].length_m for kind in limits.kinds)
    first_m, last_m = ego.s_m + limits.first_row_m + longest_m / 2.0, goal.s_m - LAST_ROW_M
    step_m = limits.row_spacing_m + longest_m
    fitting = 1 + int((last_m - first_m) // step_m) if last_m > first_m else 0
    count = min(_count(limits.rows, rng), fitting)
    slack_m = last_m - first_m - (count - 1) * step_m
    starts = np.sort(rng.uniform(0.0, max(slack_m, 0.0), count)) + first_m + step_m * np.arange(count)
    gap_m = road.lane_offset_m(ego.lane)
    for s_m in starts.tolist():
        gap_m = _next_gap(limits, road, gap_m, rng)
        yield from _row(limits, road, float(s_m), gap_m, rng)


def _next_gap(limits: RandomRoad, road: Road, last_m: float, rng: np.random.Generator) -> float:
    """m, middle of the next row's gap."""
    farthest = road.half_width_m - limits.free_gap_m / 2.0
    shift = limits.gap_shift_lanes * limits.lane_width_m
    return float(rng.uniform(max(last_m - shift, -farthest), min(last_m + shift, farthest)))


def _row(limits: RandomRoad, road: Road, s_m: float, gap_m: float, rng: np.random.Generator) -> Iterator[ObjectSpec]:
    """Obstacles side by side that leave the gap free."""
    taken = [LateralInterval(gap_m - limits.free_gap_m / 2.0, gap_m + limits.free_gap_m / 2.0)]
    for _ in range(int(rng.integers(limits.row_bodies[0], limits.row_bodies[1] + 1))):
        kind = limits.kinds[int(rng.integers(len(limits.kinds)))]
        half = SIZES[kind].width_m / 2.0
        for place in rng.uniform(-road.half_width_m + half, road.half_width_m - half, TRIES).tolist():
            if not any(LateralInterval(place - half, place + half).overlaps(other) for other in taken):
                taken.append(LateralInterval(place - half - SIDE_GAP_M, place + half + SIDE_GAP_M))
                lane = min(road.lanes, max(1, round(road.lanes / 2.0 - place / road.lane_width_m + 0.5)))
                yield ObjectSpec(kind=kind, s_m=s_m, lane=lane, lateral_m=place - road.lane_offset_m(lane))
                break
