"""Consistency checks across the sections of a scenario; one line per fault."""

from collections.abc import Iterator, Sequence

from vpf_sim.scenarios.kinds import EGO_SIZE, MOVING, SIZES, Size
from vpf_sim.scenarios.parts import FASTEST_MPS, MOST_ROAD_M, Ego, Goal, ObjectSpec, Road, Vary

BESIDE_M = 6.0  # beside the carriageway, where actors may wait and go


def faults(road: Road, ego: Ego, goal: Goal, bodies: Sequence[ObjectSpec], vary: Vary) -> Iterator[str]:
    """Every fault, for any seed: a scenario that passes is valid for all seeds."""
    yield from road_faults(road)
    if [*_width_faults(road)]:  # nothing can be placed
        return
    yield from _vary_faults(ego, bodies, vary)
    yield from _goal_faults(road, ego, goal, vary)
    yield from _place_faults("ego", road, ego, EGO_SIZE, vary)
    for i, spec in enumerate(bodies):
        yield from _place_faults(f"bodies[{i}]", road, spec, SIZES[spec.kind], vary)
        if spec.speed_mps > 0.0 and spec.kind not in MOVING:
            yield f"bodies[{i}].speed_mps: expected 0 for a {spec.kind}, which cannot move, got {spec.speed_mps:g}"
        yield from _manoeuvre_faults(f"bodies[{i}]", road, spec)


def road_faults(road: Road) -> Iterator[str]:
    """Every fault of a road alone."""
    found = [*_width_faults(road)]
    yield from found or _shape_faults(road)


def _shape_faults(road: Road) -> Iterator[str]:
    """In a bend tighter than the carriageway inside it, lanes would cross."""
    if road.oncoming_lanes >= road.lanes:
        yield f"road.oncoming_lanes: expected fewer than the {road.lanes} lanes, got {road.oncoming_lanes}"
    if road.length_m > MOST_ROAD_M:
        yield f"road.segments: expected at most {MOST_ROAD_M:g} m in all, got {road.length_m:g}"
    end_m = 0.0
    for i, segment in enumerate(road.segments):
        begin_m, end_m = end_m, end_m + segment.length_m
        name = {"arc": "radius_m", "clothoid": "end_radius_m"}.get(segment.kind, "")
        radius = getattr(segment, name, None)
        if radius is not None and abs(radius) <= (reach_m := road.reach_within(begin_m, end_m)[radius > 0.0]):
            yield (
                f"road.segments[{i}].{name}: expected more than half the carriageway, {reach_m:g} m, "
                f"to either side, got {radius:g}"
            )


def _width_faults(road: Road) -> Iterator[str]:
    for i, one in enumerate(road.widths):
        if len(one.lanes_m) != road.lanes:
            yield f"road.widths[{i}].lanes_m: expected {road.lanes} widths, one for each lane, got {len(one.lanes_m)}"
        if i > 0 and one.s_m <= road.widths[i - 1].s_m:
            yield f"road.widths[{i}].s_m: expected more than {road.widths[i - 1].s_m:g}, as before, got {one.s_m:g}"


def _manoeuvre_faults(key: str, road: Road, spec: ObjectSpec) -> Iterator[str]:
    if spec.manoeuvres and spec.kind not in MOVING:
        yield f"{key}.manoeuvres: expected none for a {spec.kind}, which cannot move"
    farthest_m = road.half_width_m + BESIDE_M
    for i, manoeuvre in enumerate(spec.manoeuvres):
        where = f"{key}.manoeuvres[{i}]"
        if (manoeuvre.after_s is None) == (manoeuvre.within_m is None):
            got = "neither" if manoeuvre.after_s is None else "both"
            yield f"{where}: expected either after_s or within_m, got {got}"
        if manoeuvre.speed_mps is None and manoeuvre.lateral_m is None:
            yield f"{where}: expected speed_mps, lateral_m or both, got neither"
        middle_m = road.lane_offset_m(spec.lane, spec.s_m)
        if manoeuvre.lateral_m is not None and abs(middle_m + manoeuvre.lateral_m) > farthest_m:
            yield (
                f"{where}.lateral_m: expected a place within {farthest_m:g} m of the carriageway's centre, "
                f"got {middle_m + manoeuvre.lateral_m:g}"
            )


def _vary_faults(ego: Ego, bodies: Sequence[ObjectSpec], vary: Vary) -> Iterator[str]:
    for key, (low, high) in vary.items():
        if low > high:
            yield f'vary."{key}": expected [low, high] with low <= high, got [{low:g}, {high:g}]'
        group, field = key.split(".")
        parts: Sequence[Ego | ObjectSpec] = [ego] if group == "ego" else bodies
        if field == "speed_mps" and any(part.speed_mps + low < 0.0 for part in parts):
            yield f'vary."{key}": expected speeds that stay at or above 0, got a change of {low:g}'
        if field == "speed_mps" and any(part.speed_mps + high > FASTEST_MPS for part in parts):
            yield f'vary."{key}": expected speeds that stay at or below {FASTEST_MPS:g}, got a change of {high:g}'
        if field == "heading_deg" and max(-low, high) > 360.0:
            yield f'vary."{key}": expected degrees from -360 to 360, got [{low:g}, {high:g}]'


def _goal_faults(road: Road, ego: Ego, goal: Goal, vary: Vary) -> Iterator[str]:
    start = ego.s_m + _change(vary, "ego.s_m")[1]
    if not start < goal.s_m <= road.length_m:
        yield (
            f"goal.s_m: expected a place ahead of the ego and on the road, after {start:g} and up to "
            f"{road.length_m:g} m, got {goal.s_m:g}"
        )


def _place_faults(key: str, road: Road, part: Ego | ObjectSpec, size: Size, vary: Vary) -> Iterator[str]:
    """An object must be completely on the carriageway and within the road's length."""
    lanes = road.lanes - road.oncoming_lanes if isinstance(part, Ego) else road.lanes
    if part.lane > lanes:
        yield f"{key}.lane: expected 1 to {lanes}, counted from the right, got {part.lane}"
        return
    noun, group = ("ego", "ego") if isinstance(part, Ego) else ("obstacle", "bodies")
    centre_m = road.lane_offset_m(part.lane, part.s_m) + part.lateral_m
    low, high = _extent(part.s_m, size.length_m, _change(vary, f"{group}.s_m"))
    if low < 0.0 or high > road.length_m:
        yield (
            f"{key}.s_m: {noun} off the road: expected the whole object between 0 and {road.length_m:g} m along the "
            f"road, got {low:g} to {high:g} m"
        )
    left_m, right_m = road.edges_m(low, high)
    low, high = _extent(centre_m, size.width_m, _change(vary, f"{group}.lateral_m"))
    beside_m = BESIDE_M if isinstance(part, ObjectSpec) and part.manoeuvres else 0.0
    left_m, right_m = left_m - beside_m, right_m + beside_m
    if low < left_m or high > right_m:
        yield (
            f"{key}.lateral_m: {noun} off the road: expected the whole object between {left_m:g} and "
            f"{right_m:g} m from the carriageway's centre, got {low:g} to {high:g} m"
        )


def _extent(centre_m: float, size_m: float, change: tuple[float, float]) -> tuple[float, float]:
    """Least and largest coordinate of an object in one direction."""
    return centre_m + change[0] - size_m / 2.0, centre_m + change[1] + size_m / 2.0


def _change(vary: Vary, key: str) -> tuple[float, float]:
    """The interval that the seed may add to a value."""
    return next((change for name, change in vary.items() if name == key), (0.0, 0.0))
