"""Plain highway-env roads with objects, for the camera's tests."""

import numpy as np
from highway_env.road.lane import CircularLane, LineType, StraightLane
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Obstacle

WIDTH_M = 3.5
SIZES_M = {"car": (5.0, 2.0, 1.5), "van": (5.5, 2.1, 2.3), "truck": (8.5, 2.5, 3.4), "cone": (0.4, 0.4, 0.75)}


def line_types(lane: int) -> tuple[int, int]:
    left = LineType.CONTINUOUS_LINE if lane == 0 else LineType.STRIPED
    return left, LineType.CONTINUOUS_LINE if lane == 3 else LineType.NONE


def straight_road() -> Road:
    """Four lanes along x; the middle of lane i lies at y = 3.5 i."""
    network = RoadNetwork()
    for i in range(4):
        lane = StraightLane([0.0, WIDTH_M * i], [300.0, WIDTH_M * i], width=WIDTH_M, line_types=line_types(i))
        network.add_lane("a", "b", lane)
    return Road(network, np_random=np.random.RandomState(0))


def bent_road(radius: float = 100.0) -> Road:
    """Four lanes from the origin, bending right; the origin is the middle of the carriageway."""
    network = RoadNetwork()
    for i in range(4):
        lane_radius = radius + 1.5 * WIDTH_M - WIDTH_M * i
        lane = CircularLane(
            [0.0, radius], lane_radius, -np.pi / 2, -np.pi / 2 + 2.2, width=WIDTH_M, line_types=line_types(i)
        )
        network.add_lane("a", "b", lane)
    return Road(network, np_random=np.random.RandomState(0))


def on_bend(s: float, right: float, radius: float = 100.0) -> tuple[list[float], float]:
    """Position and heading s m along the middle of `bent_road`, `right` m to its right."""
    angle = s / radius
    return [(radius - right) * np.sin(angle), radius - (radius - right) * np.cos(angle)], angle


def add_object(road: Road, kind: str, position: list[float], heading: float = 0.0) -> Obstacle:
    length, width, height = SIZES_M[kind]
    cls = type("Object", (Obstacle,), {"LENGTH": length, "WIDTH": width, "HEIGHT": height, "kind": kind})
    road.objects.append(cls(road, position, heading))
    return road.objects[-1]


def add_ego(road: Road, position: list[float], heading: float = 0.0) -> Vehicle:
    road.vehicles.append(Vehicle(road, position, heading, 5.55))
    return road.vehicles[-1]
