"""The lane that the recorded car drives in.

A driver keeps to the lane in which it began (`perception.road.edge_tracker`); the human on a recording changes lanes.
So only the lines beside the car are used: the lane nearest to the car is the one to keep. Without a lane the model
car holds course and speed (`open_loop_driver`).
"""

from dataclasses import replace
from math import sin

import numpy as np

from vpf_sim.types import Floats, Obstacles, RoadEdges

LEAST_CONFIDENCE = 0.5  # of its lines, below which the lane is rejected
FASTEST_ACROSS_MPS = 1.0  # lateral speed, above which the lines are wrong
MOST_ACROSS_MPS2 = 5.0  # lateral acceleration in the bend ahead
SLOW_MPS = 2.0  # below this the flow shows no obstacle ahead,
SLOW_BEND_PER_M = 0.01  # and its outline may look like lines of a bend this tight


def is_found(road: RoadEdges, speed_mps: float) -> bool:
    """Whether these lines can be those of the lane that the car drives in."""
    if road.lane_confidence < LEAST_CONFIDENCE or abs(speed_mps * sin(road.heading_rad)) > FASTEST_ACROSS_MPS:
        return False
    bend = abs(road.curvature_per_m)
    return bend <= (SLOW_BEND_PER_M if speed_mps < SLOW_MPS else MOST_ACROSS_MPS2 / speed_mps**2)


def present_lane(road: RoadEdges, found: bool) -> RoadEdges:
    """Road edges whose own lane is the one nearest to the car.

    Their confidence is that of the lane. Without a lane it is 0, and the edges lie straight ahead at their distance
    apart.
    """
    if not found:
        reach = 0.5 * (road.right_m - road.left_m)
        ahead = replace(road, left_m=-reach, right_m=reach, lane_m=0.0, oncoming_m=0.0)
        return replace(ahead, heading_rad=0.0, curvature_per_m=0.0, confidence=0.0)
    half = 0.5 * road.lane_width_m
    middle = (road.lane_m + half) % road.lane_width_m - half
    left, right = min(road.left_m, middle - half), max(road.right_m, middle + half)
    beyond = max(road.oncoming_m + left - road.left_m, 0.0)
    return replace(road, lane_m=middle, left_m=left, right_m=right, oncoming_m=beyond, confidence=road.lane_confidence)


def road_in_vehicle_frame(road: RoadEdges, right_m: float, turn_rad: float) -> RoadEdges:
    """The edges from a vehicle `right_m` right of the pose and rotated by `turn_rad`."""
    return replace(
        road,
        left_m=road.left_m - right_m,
        right_m=road.right_m - right_m,
        lane_m=road.lane_m - right_m,
        heading_rad=road.heading_rad - turn_rad,
    )


def obstacles_in_vehicle_frame(obstacles: Obstacles, right_m: float, turn_rad: float) -> Obstacles:
    """The obstacles from the same vehicle; their faces stay perpendicular to its axis."""

    def turned(forward: Floats, right: Floats) -> tuple[Floats, Floats]:
        cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
        return cosine * forward + sine * right, cosine * right - sine * forward

    middle, half = obstacles.middle_m - right_m, 0.5 * obstacles.width_m
    forward, across = turned(obstacles.forward_m, middle)
    return replace(obstacles, forward_m=forward, left_m=across - half, right_m=across + half)
