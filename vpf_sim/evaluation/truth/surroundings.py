"""What the harness measures in the world beside a driver, at one moment of an episode. Drivers never see it."""

from collections.abc import Iterable
from math import atan2, cos, hypot, inf, pi, radians, sin
from types import SimpleNamespace
from typing import Any

import numpy as np

from vpf_sim.envs.rectangles import corners, distance, to_local
from vpf_sim.types import RoadEdges, VehicleModel

BEFORE_M, AFTER_M = 25.0, 15.0  # the part of a route that counts as passing a body
AHEAD_M = 10.0  # where the perceived edges are compared
LEAST_CLOSING_MPS = 1e-9
STANDING_MPS = 5e-3  # nuPlan's, of the ego in the time to collision
AHEAD_RAD, BEHIND_RAD = radians(30.0), radians(150.0)  # nuPlan's
REAR_AXLE_M = VehicleModel().l_r_m  # behind the pose


def is_passing(ego: Any, others: Iterable[Any]) -> bool:
    """Whether the ego is 25 m before to 15 m after the place of a body, along the road."""
    return any(-AFTER_M <= body.place[0] - ego.place[0] <= BEFORE_M for body in others)


def time_to_collision(ego: Any, others: Iterable[Any], in_lane: bool) -> float:
    """s until the ego's body touches another that nuPlan counts, if all keep their velocities; inf if never.

    Source: nuplan-devkit, evaluation_metrics/common/time_to_collision_within_bound.py. A body counts if it is ahead,
    less than 30 degrees off the heading as seen from the rear axle, and where the ego is not in one lane also if it is
    beside, up to 150 degrees. A standing ego collides with nobody. nuPlan looks 3 s ahead in steps of 0.1 s; this is
    exact and looks on.
    """
    if hypot(*ego.velocity.tolist()) <= STANDING_MPS:
        return inf
    widest = AHEAD_RAD if in_lane else BEHIND_RAD
    return min((contact_s(ego, body) for body in others if abs(bearing_rad(ego, body)) < widest), default=inf)


def contact_s(ego: Any, body: Any) -> float:
    """s until two rectangles touch if both keep their velocities and headings; inf if never.

    Two convex bodies overlap when their shadows do on each side's normal (separating axis). On each of the four they do
    so from the time when the gap is closed until it opens again; the bodies touch when they do on all of them.
    """
    away_x, away_y = (body.position - ego.position).tolist()
    moving_x, moving_y = (body.velocity - ego.velocity).tolist()
    start, end = 0.0, inf
    for normal in (ego.heading, ego.heading + 0.5 * pi, body.heading, body.heading + 0.5 * pi):
        x, y = cos(normal), sin(normal)
        reach = _half_shadow(ego, normal) + _half_shadow(body, normal)
        away, moving = x * away_x + y * away_y, x * moving_x + y * moving_y
        if abs(moving) < LEAST_CLOSING_MPS:
            if abs(away) >= reach:
                return inf
            continue
        first, last = sorted(((-reach - away) / moving, (reach - away) / moving))
        start, end = max(start, first), min(end, last)
    return start if start < end else inf


def _half_shadow(body: Any, direction: float) -> float:
    turned = direction - body.heading
    return float(0.5 * (body.LENGTH * abs(cos(turned)) + body.WIDTH * abs(sin(turned))))


def bearing_rad(ego: Any, body: Any) -> float:
    """Direction of a body's centre as seen from the ego's rear axle, off its heading; + is right."""
    ((forward, right),) = to_local(ego, [tuple(body.position.tolist())])
    return atan2(right, forward + REAR_AXLE_M)


def bumper_gap_m(ego: Any, body: Any) -> float:
    """m from the ego's front bumper, a line, to a body; 0 where they touch."""
    front = 0.5 * ego.LENGTH * np.array([cos(ego.heading), sin(ego.heading)])
    bumper = SimpleNamespace(position=ego.position + front, heading=ego.heading, LENGTH=0.0, WIDTH=ego.WIDTH)
    return distance(bumper, body)


def corner_laterals(ego: Any, network: Any) -> list[float]:
    """Where across the road the corners of the ego's body are, m right of the carriageway's centre."""
    return [network.centre.local_at(x, y)[1] for x, y in corners(ego)]


def is_outside(laterals_m: Iterable[float], network: Any) -> bool:
    """Whether a corner is beyond an edge of the carriageway."""
    return any(abs(lateral) > network.half_width_m for lateral in laterals_m)


def is_in_lane(laterals_m: Iterable[float], network: Any) -> bool:
    """Whether all corners are in one lane, as nuPlan asks of who is not to blame for what comes from the side."""
    laterals_m = list(laterals_m)
    return not is_outside(laterals_m, network) and len({network.lane_at(lateral) for lateral in laterals_m}) == 1


def true_edges(ego: Any, network: Any) -> tuple[float, float]:
    """(left, right) m across the road to the carriageway's edges from the point AHEAD_M ahead of the ego; left < 0."""
    x, y = ego.position.tolist()
    lateral = network.centre.local_at(x + AHEAD_M * cos(ego.heading), y + AHEAD_M * sin(ego.heading))[1]
    return -network.half_width_m - lateral, network.half_width_m - lateral


def true_lane(ego: Any, network: Any, offset_m: float) -> float:
    """m across the road from that point to the middle of the lane that lies `offset_m` right of the road's centre."""
    middle_m: float = true_edges(ego, network)[0] + network.half_width_m + offset_m
    return middle_m


def seen_edges(road: RoadEdges) -> tuple[float, float]:
    """The same as `true_edges`, perceived: what edges at the pose, heading and curvature of the road say."""
    shift = _shift_m(road)
    return road.left_m + shift, road.right_m + shift


def seen_lane(road: RoadEdges) -> float:
    """The same as `true_lane`, perceived: of the lane that the driver takes for its own."""
    return road.lane_m + _shift_m(road)


def _shift_m(road: RoadEdges) -> float:
    """How far the road goes to the right over AHEAD_M, in the axes of the vehicle."""
    shift: float = AHEAD_M * sin(road.heading_rad) + 0.5 * road.curvature_per_m * AHEAD_M**2
    return shift
