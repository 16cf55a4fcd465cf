"""highway-env's lane network with places along a route, and edges where the road has some."""

from collections.abc import Iterator, Sequence
from math import cos, nan, pi
from types import SimpleNamespace

import numpy as np
from highway_env.road.lane import AbstractLane
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.envs.camera.layout import lane_shapes, lines
from vpf_sim.envs.highway.lanes import SplineLine
from vpf_sim.envs.network import LaneUse, OnRoad, Place, Point, RoadLines
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

PARALLEL_RAD = pi / 9.0  # lanes at a smaller angle, in either direction, share a cross-section
ROUTE_HALF_M = 2.0  # half a lane; where two roads do not meet exactly, the route between them is road as well
TOUCHING_M = 0.3  # lanes that are nearer to each other lie side by side


class LaneGraph(RoadNetwork):  # type: ignore[misc]
    """The lanes of a highway-env network; places are measured along the centre of the ego's route.

    `route_lanes` are the lanes of the route for highway-env's cars: the lane number is None where any lane will do.
    """

    def __init__(self, network: RoadNetwork, centre: SplineLine, route_lanes: Sequence[LaneIndex]) -> None:
        super().__init__()
        self.graph = network.graph
        self.centre = centre
        self.route_lanes = tuple(route_lanes)

    def place_at(self, x_m: float, y_m: float, near_s_m: float | None = None) -> Place:
        """(s, lateral) of a world point on the route, looked for near `near_s_m`."""
        return self.centre.local_at(x_m, y_m, near_s_m)

    def lane_of(self, ego: OnRoad) -> LaneIndex:
        """highway-env's lane of a car: the nearest, by position and heading."""
        return self.get_closest_lane_index(ego.position, ego.heading)

    def is_off_road(self, ego: OnRoad) -> bool:
        """Whether the ego's centre is on no lane, as in highway-env, and beside the route."""
        return not (abs(ego.place[1]) <= ROUTE_HALF_M or any(lane.on_lane(ego.position) for lane in self.lanes_list()))

    def lane_use(self, corners: Sequence[Point], near_s_m: float) -> LaneUse:
        """How the corners of a car lie on the lanes."""
        points = [np.array(corner) for corner in corners]
        on_lanes = [[bool(lane.on_lane(point)) for point in points] for lane in self.lanes_list()]
        on_route = [abs(self.centre.local_at(*corner, near_s_m)[1]) <= ROUTE_HALF_M for corner in corners]
        is_outside = not all(map(any, zip(on_route, *on_lanes, strict=True)))
        return LaneUse(is_outside, any(map(all, on_lanes)))

    def edges_at(self, x_m: float, y_m: float, heading_rad: float) -> tuple[float, float]:
        """(left, right) m, offsets from a point to the edges of the carriageway, left < 0.

        The carriageway are the lanes side by side, in both directions. At a junction, where lanes cross it at an angle,
        and off the lanes both are nan.
        """
        point = np.array([x_m, y_m])
        index = self.get_closest_lane_index(point, heading_rad)
        across = list(self._across(point, self.get_lane(index)))
        left, right = nan, nan
        for low, high, _ in sorted(across):
            if low <= 0.0 <= high:
                left, right = (low, high) if left != left else (min(left, low), max(right, high))
        for low, high, _ in sorted(across, key=lambda lane: abs(lane[0] + lane[1])):
            if high >= left - TOUCHING_M and low <= right + TOUCHING_M:
                left, right = min(left, low), max(right, high)
        if any(not parallel and high > left and low < right for low, high, parallel in across):
            return nan, nan
        return left, right

    def _across(self, point: Floats, here: AbstractLane) -> Iterator[tuple[float, float, bool]]:
        """The left and right sides of every lane at a point, m right of it, and whether it is parallel to `here`."""
        heading = here.heading_at(here.local_coordinates(point)[0])
        for lane in self.lanes_list():
            along, lateral = lane.local_coordinates(point)
            if 0.0 <= along <= lane.length:
                turn = wrap_angle(lane.heading_at(along) - heading)
                half, middle = 0.5 * lane.width_at(along), -lateral if cos(turn) > 0.0 else lateral
                yield middle - half, middle + half, min(abs(turn), pi - abs(turn)) < PARALLEL_RAD

    def lines(self) -> RoadLines:
        """The road from above: its lanes, and its markings as the camera sees them."""
        shapes = lane_shapes(SimpleNamespace(network=self))
        markings = lines(shapes)
        return RoadLines(
            tuple((shape.left_m, shape.right_m) for shape in shapes),
            tuple(line.points_m for line in markings if not line.striped),
            tuple(line.points_m for line in markings if line.striped),
        )
