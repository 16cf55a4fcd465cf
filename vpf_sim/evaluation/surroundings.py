"""What the harness measures in the world beside a driver, at one moment of an episode. Drivers never see it."""

from collections.abc import Iterable
from math import cos, inf, sin
from typing import Any

from vpf_sim.envs.rectangles import corners, seen_from
from vpf_sim.types import RoadEdges

BEFORE_M, AFTER_M = 25.0, 15.0  # the part of a route that counts as passing a body
AHEAD_M = 10.0  # where the perceived edges are compared
LEAST_CLOSING_MPS = 1e-9


def is_passing(ego: Any, others: Iterable[Any]) -> bool:
    """Whether the ego is 25 m before to 15 m after the place of a body, along the road."""
    return any(-AFTER_M <= body.place[0] - ego.place[0] <= BEFORE_M for body in others)


def time_to_collision(ego: Any, others: Iterable[Any]) -> float:
    """s until the ego's body touches another if both keep their velocities; inf if never.

    Each other body is the rectangle about it along the ego's axes. On each axis the two overlap from the time when the
    gap between them is closed until it opens again; they touch when they do on both.
    """
    return min((_contact_s(ego, body) for body in others), default=inf)


def _contact_s(ego: Any, body: Any) -> float:
    outline = seen_from(ego, corners(body))
    cosine, sine = cos(ego.heading), sin(ego.heading)
    closing_x, closing_y = (ego.velocity - body.velocity).tolist()
    closing = (cosine * closing_x + sine * closing_y, cosine * closing_y - sine * closing_x)
    start, end = 0.0, inf
    for axis, half in ((0, ego.LENGTH / 2.0), (1, ego.WIDTH / 2.0)):
        low, high = min(point[axis] for point in outline) - half, max(point[axis] for point in outline) + half
        if abs(closing[axis]) < LEAST_CLOSING_MPS:
            if not low < 0.0 < high:
                return inf
            continue
        first, last = sorted((low / closing[axis], high / closing[axis]))
        start, end = max(start, first), min(end, last)
    return start if start < end else inf


def is_outside(ego: Any, network: Any) -> bool:
    """Whether a corner of the ego's body is beyond an edge of the carriageway."""
    return any(abs(network.centre.local_at(x, y)[1]) > network.half_width_m for x, y in corners(ego))


def true_edges(ego: Any, network: Any) -> tuple[float, float]:
    """(left, right) m across the road to the carriageway's edges from the point AHEAD_M ahead of the ego; left < 0."""
    x, y = ego.position.tolist()
    lateral = network.centre.local_at(x + AHEAD_M * cos(ego.heading), y + AHEAD_M * sin(ego.heading))[1]
    return -network.half_width_m - lateral, network.half_width_m - lateral


def seen_edges(road: RoadEdges) -> tuple[float, float]:
    """The same as perceived: what edges at the pose, heading and curvature of the road say of that point."""
    shift = AHEAD_M * sin(road.heading_rad) + 0.5 * road.curvature_per_m * AHEAD_M**2
    return road.left_m + shift, road.right_m + shift
