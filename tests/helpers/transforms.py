"""Rotated, translated and mirrored scenarios, to test a driver for equivariance."""

from math import cos, fmod, radians, sin

from vpf_sim.scenarios.parts import LaneWidths, ObjectSpec, Road, Segment
from vpf_sim.scenarios.schema import Scenario

SIDEWAYS = ("lateral_m", "heading_deg")  # varied keys with opposite sign in the mirror image


def rotated(scenario: Scenario, degrees: float) -> Scenario:
    """The scenario rotated about the world's origin, clockwise from above."""
    (x, y), c, s = scenario.road.start_m, cos(radians(degrees)), sin(radians(degrees))
    heading = fmod(scenario.road.heading_deg + degrees, 360.0)
    return _with_road(scenario, {"start_m": (c * x - s * y, s * x + c * y), "heading_deg": heading})


def translated(scenario: Scenario, x_m: float, y_m: float) -> Scenario:
    """The scenario translated."""
    x, y = scenario.road.start_m
    return _with_road(scenario, {"start_m": (x + x_m, y + y_m)})


def mirrored(scenario: Scenario) -> Scenario:
    """The scenario mirrored in the X axis: the rightmost lane becomes the leftmost."""
    road = scenario.road
    vary = {
        key: (-high, -low) if key.split(".")[1] in SIDEWAYS else (low, high)
        for key, (low, high) in scenario.vary.items()
    }
    mirrored_road = {
        "start_m": (road.start_m[0], -road.start_m[1]),
        "heading_deg": -road.heading_deg,
        "widths": tuple(_mirrored_widths(one) for one in road.widths),
        "oncoming_lanes": 0,  # they are on the left in every file
        "segments": tuple(_mirrored_segment(segment) for segment in road.segments),
    }
    ego = scenario.ego.model_copy(
        update={
            "lane": _mirrored_lane(road, scenario.ego.lane),
            "lateral_m": -scenario.ego.lateral_m,
            "heading_deg": -scenario.ego.heading_deg,
        }
    )
    bodies = tuple(_mirrored_object(road, spec) for spec in scenario.bodies)
    return _with_road(scenario, mirrored_road).model_copy(update={"ego": ego, "bodies": bodies, "vary": vary})


def _mirrored_object(road: Road, spec: ObjectSpec) -> ObjectSpec:
    manoeuvres = tuple(
        one if one.lateral_m is None else one.model_copy(update={"lateral_m": -one.lateral_m})
        for one in spec.manoeuvres
    )
    lane = _mirrored_lane(road, spec.lane)
    return spec.model_copy(update={"lane": lane, "lateral_m": -spec.lateral_m, "manoeuvres": manoeuvres})


def _with_road(scenario: Scenario, road: dict[str, object]) -> Scenario:
    return scenario.model_copy(update={"road": scenario.road.model_copy(update=road)})


def _mirrored_widths(widths: LaneWidths) -> LaneWidths:
    left_m = None if widths.left_edge_m is None else -(widths.left_edge_m + sum(widths.lanes_m))
    return widths.model_copy(update={"lanes_m": widths.lanes_m[::-1], "left_edge_m": left_m})


def _mirrored_lane(road: Road, lane: int) -> int:
    return road.lanes + 1 - lane


def _mirrored_segment(segment: Segment) -> Segment:
    if segment.kind == "arc":
        return segment.model_copy(update={"radius_m": -segment.radius_m})
    if segment.kind == "clothoid" and segment.end_radius_m is not None:
        return segment.model_copy(update={"end_radius_m": -segment.end_radius_m})
    return segment
