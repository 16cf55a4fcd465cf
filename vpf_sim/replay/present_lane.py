"""The lane that a recorded car drives in: what of the road a driver on someone else's recording can be held to.

A driver keeps to the lane in which it began (`perception.road.edge_tracker`). The human on the recording changes lanes.
Of what the camera finds, only where the lines lie beside the car is used: the lane nearest to the car is the one to
keep to. Where no lane is found, nothing is decided: the model car keeps course and speed (`pilot`).
"""

from dataclasses import replace
from math import sin

import numpy as np

from vpf_sim.types import Floats, Obstacles, RoadEdges

LEAST_CONFIDENCE = 0.5  # of its lines, below which the lane is not believed
FASTEST_ACROSS_MPS = 1.0  # of a car in its lane or on its way to the next: more is a road that was mistaken
MOST_ACROSS_MPS2 = 5.0  # of a car in the bend ahead: no one drives into a tighter one so fast
BLIND_MPS = 2.0  # whoever is slower sees no body ahead by its flow,
BLIND_BEND_PER_M = 0.01  # and may take its outline for the lines of a bend as tight as this


def is_found(road: RoadEdges, speed_mps: float) -> bool:
    """Whether these lines can be those of the lane that the car drives in."""
    if road.lane_confidence < LEAST_CONFIDENCE or abs(speed_mps * sin(road.heading_rad)) > FASTEST_ACROSS_MPS:
        return False
    bend = abs(road.curvature_per_m)
    return bend <= (BLIND_BEND_PER_M if speed_mps < BLIND_MPS else MOST_ACROSS_MPS2 / speed_mps**2)


def present_lane(road: RoadEdges, found: bool) -> RoadEdges:
    """Edges whose own lane is the one nearest to the car, which lies between them.

    Their confidence is that of the lane. Where it was not found it is 0, and nothing of the edges is kept but how far
    they are apart: they lie about the car, straight ahead.
    """
    if not found:
        reach = 0.5 * (road.right_m - road.left_m)
        ahead = replace(road, left_m=-reach, right_m=reach, lane_m=0.0)
        return replace(ahead, heading_rad=0.0, curvature_per_m=0.0, confidence=0.0)
    half = 0.5 * road.lane_width_m
    middle = (road.lane_m + half) % road.lane_width_m - half
    left, right = min(road.left_m, middle - half), max(road.right_m, middle + half)
    return replace(road, lane_m=middle, left_m=left, right_m=right, confidence=road.lane_confidence)


def seen_from(road: RoadEdges, right_m: float, turn_rad: float) -> RoadEdges:
    """The edges from a vehicle `right_m` right of the pose and turned by `turn_rad`."""
    return replace(
        road,
        left_m=road.left_m - right_m,
        right_m=road.right_m - right_m,
        lane_m=road.lane_m - right_m,
        heading_rad=road.heading_rad - turn_rad,
    )


def bodies_seen_from(bodies: Obstacles, right_m: float, turn_rad: float) -> Obstacles:
    """The bodies from a vehicle `right_m` right of the pose and turned by `turn_rad`; their faces stay across."""

    def turned(forward: Floats, right: Floats) -> tuple[Floats, Floats]:
        cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
        return cosine * forward + sine * right, cosine * right - sine * forward

    middle, half = bodies.middle_m - right_m, 0.5 * bodies.width_m
    forward, across = turned(bodies.forward_m, middle)
    return replace(bodies, forward_m=forward, left_m=across - half, right_m=across + half)
