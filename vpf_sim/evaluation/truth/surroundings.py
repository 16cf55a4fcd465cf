"""Ground truth of the ego's surroundings at one step: lane, edges, time to collision. Hidden from drivers."""

from collections.abc import Iterable
from math import atan2, cos, hypot, inf, nan, pi, radians, sin
from types import SimpleNamespace

import numpy as np

from vpf_sim.envs.contacts import distance, to_local
from vpf_sim.envs.network import Network, OnRoad, Outline
from vpf_sim.types import RoadEdges, VehicleModel

BEFORE_M, AFTER_M = 25.0, 15.0  # the part of a route that counts as passing an obstacle
BLOCKED_M = 12.0  # ahead of the bumper
AHEAD_M = 10.0  # distance at which perceived edges are scored
LEAST_CLOSING_MPS = 1e-9
STATIONARY_MPS = 5e-3  # nuPlan's bound for the ego in the time to collision
AHEAD_RAD, BEHIND_RAD = radians(30.0), radians(150.0)  # nuPlan's
REAR_AXLE_M = VehicleModel().l_r_m  # behind the pose


def is_passing(ego: OnRoad, others: Iterable[OnRoad]) -> bool:
    """Whether the ego is between 25 m before and 15 m after an object along the road."""
    return any(-AFTER_M <= obj.place[0] - ego.place[0] <= BEFORE_M for obj in others)


def time_to_collision(ego: OnRoad, others: Iterable[OnRoad], in_lane: bool) -> float:
    """Time, s, until the ego touches an object that nuPlan counts, at constant velocities; inf if never.

    Source: nuplan-devkit, evaluation_metrics/common/time_to_collision_within_bound.py. An object counts if its bearing
    from the rear axle is below 30 degrees, or below 150 degrees while the ego is not within one lane. A stationary ego
    has no time to collision. nuPlan samples 3 s ahead in steps of 0.1 s; this is exact and has no horizon.
    """
    if hypot(*ego.velocity.tolist()) <= STATIONARY_MPS:
        return inf
    widest = AHEAD_RAD if in_lane else BEHIND_RAD
    return min((contact_s(ego, obj) for obj in others if abs(bearing_rad(ego, obj)) < widest), default=inf)


def contact_s(ego: OnRoad, obj: OnRoad) -> float:
    """Time, s, until two rectangles touch at constant velocities and headings; inf if never.

    Separating axes: two rectangles overlap if their projections overlap on each of the four side normals. On each
    normal this holds for one time interval; contact begins when all four intervals overlap.
    """
    away_x, away_y = (obj.position - ego.position).tolist()
    moving_x, moving_y = (obj.velocity - ego.velocity).tolist()
    start, end = 0.0, inf
    for normal in (ego.heading, ego.heading + 0.5 * pi, obj.heading, obj.heading + 0.5 * pi):
        x, y = cos(normal), sin(normal)
        reach = _half_projection(ego, normal) + _half_projection(obj, normal)
        away, moving = x * away_x + y * away_y, x * moving_x + y * moving_y
        if abs(moving) < LEAST_CLOSING_MPS:
            if abs(away) >= reach:
                return inf
            continue
        first, last = sorted(((-reach - away) / moving, (reach - away) / moving))
        start, end = max(start, first), min(end, last)
    return start if start < end else inf


def _half_projection(obj: Outline, direction: float) -> float:
    turned = direction - obj.heading
    return float(0.5 * (obj.LENGTH * abs(cos(turned)) + obj.WIDTH * abs(sin(turned))))


def bearing_rad(ego: OnRoad, obj: OnRoad) -> float:
    """Bearing of an object's centre from the ego's rear axle, relative to its heading; + is right."""
    ((forward, right),) = to_local(ego, [tuple(obj.position.tolist())])
    return atan2(right, forward + REAR_AXLE_M)


def bumper_gap_m(ego: OnRoad, obj: OnRoad) -> float:
    """Distance, m, from the ego's front bumper, a line, to an object."""
    front = 0.5 * ego.LENGTH * np.array([cos(ego.heading), sin(ego.heading)])
    bumper = SimpleNamespace(position=ego.position + front, heading=ego.heading, LENGTH=0.0, WIDTH=ego.WIDTH)
    return distance(bumper, obj)


def free_width_m(ego: OnRoad, others: Iterable[OnRoad], network: Network) -> float:
    """Widest gap, m, between objects within BLOCKED_M ahead of the bumper, across the carriageway at the ego.

    nan where the road has no edges, as at a junction.
    """
    x, y = ego.position.tolist()
    left, right = network.edges_at(x, y, ego.heading)
    taken = []
    for obj in others:
        turn = obj.heading - ego.heading
        half_along, half_across = (
            0.5 * (obj.LENGTH * abs(along(turn)) + obj.WIDTH * abs(across(turn)))
            for along, across in ((cos, sin), (sin, cos))
        )
        gap_m = obj.place[0] - ego.place[0] - 0.5 * ego.LENGTH
        if -half_along < gap_m < BLOCKED_M + half_along:
            middle = obj.place[1] - ego.place[1]
            taken.append((middle - half_across, middle + half_across))
    widest, free_from = 0.0, left
    for start, end in (*sorted(taken), (right, right)):
        widest, free_from = max(widest, min(start, right) - free_from), max(free_from, end)
    return widest if left < right else nan


def true_edges(ego: OnRoad, network: Network) -> tuple[float, float]:
    """(left, right) offsets, m, of the carriageway's edges from the point AHEAD_M ahead of the ego; left < 0.

    nan where the road has no edge there, as at a junction.
    """
    return network.edges_at(*_ahead(ego), ego.heading)


def true_lane(ego: OnRoad, network: Network, offset_m: float) -> float:
    """Offset, m, from that point to the centre of the lane that lies `offset_m` right of the reference line."""
    return offset_m - network.place_at(*_ahead(ego), ego.place[0] + AHEAD_M)[1]


def _ahead(ego: OnRoad) -> tuple[float, float]:
    """m, the point AHEAD_M ahead of the ego."""
    x, y = ego.position.tolist()
    return x + AHEAD_M * cos(ego.heading), y + AHEAD_M * sin(ego.heading)


def perceived_edges(road: RoadEdges) -> tuple[float, float]:
    """The perceived counterpart of `true_edges`, extrapolated by the road's heading and curvature.

    The carriageway includes the lanes of oncoming traffic.
    """
    shift = _shift_m(road)
    return road.left_m - road.oncoming_m + shift, road.right_m + shift


def perceived_lane(road: RoadEdges) -> float:
    """The perceived counterpart of `true_lane`, for the lane that the driver takes for its own."""
    return road.lane_m + _shift_m(road)


def _shift_m(road: RoadEdges) -> float:
    """Lateral shift of the road over AHEAD_M in vehicle axes, m; + is right."""
    shift: float = AHEAD_M * sin(road.heading_rad) + 0.5 * road.curvature_per_m * AHEAD_M**2
    return shift
