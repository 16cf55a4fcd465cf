"""The scene as the simulator knows it, for privileged drivers and for comparisons with what a camera finds."""

from collections.abc import Iterable, Iterator
from math import atan, cos, hypot, nan, pi, sin, tan
from typing import Any, Protocol

import numpy as np
from highway_env.vehicle.objects import Landmark

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.geometry import unwrapped, wrap_angle
from vpf_sim.scene.lanes import LanePlace
from vpf_sim.scene.planned_lanes import PlannedLanes
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.scene.tracks import Tracks
from vpf_sim.types import Floats

STEP_M = 0.5  # between the stations of the tables
SECTION_M = 2.0  # between the cross-sections that are read from the lanes
BEFORE_M, BEYOND_M = 60.0, 200.0  # of the reference line's ends
JUNCTION_HALF_M = 2.0  # where the road has no edges, the route is this wide to either side
CENTRE_ON_LANE_M = 0.6  # highway-env asks for the car's centre on a lane, so its corners may be beyond
PARALLEL_RAD = pi / 9.0  # lanes at a smaller angle share a cross-section
SPEED_SIGMA_MPS = (0.15, 0.05)  # along, across: what traffic may decide otherwise in the next seconds
STANDING_MPS = 0.2
AHEAD_S = 8.0  # objects that cannot be near within this time are left out
NEAR_M = 5.0
BEHIND_M = 60.0
MOST = 14  # tracks, the nearest in time


class Line(Protocol):
    """A road's reference line, extended straight beyond both ends."""

    length_m: float

    def position(self, s_m: Floats) -> Floats: ...

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]: ...

    def heading(self, s_m: Floats) -> Floats: ...

    def heading_at(self, s_m: float) -> float: ...

    def curvature(self, s_m: Floats) -> Floats: ...


class Network(Protocol):
    """A highway-env lane network with places and edges."""

    centre: Line

    def place_at(self, x_m: float, y_m: float, near_s_m: float | None = None) -> tuple[float, float]: ...

    def edges_at(self, x_m: float, y_m: float, heading_rad: float) -> tuple[float, float]: ...

    def lanes_list(self) -> list[Any]: ...


class TrueScene:
    """Reads the scene of one episode."""

    def __init__(self, setup: DriverSetup) -> None:
        if setup.world is None or setup.route is None:
            raise ValueError("scene: expected a setup with the world and the route, got one without")
        self._world = setup.world
        self._speed_mps = setup.speed_reference_mps
        self._network: Network = setup.world.network
        start = setup.route[0].tolist()
        self.road = road_of(self._network, self._network.place_at(*start, 0.0)[1])
        self._lanes = PlannedLanes(setup.world.network)
        self._ego: Any = None
        self._last_s_m = 0.0

    def at(self, observation: Observation) -> Scene:
        """The scene at an observation's time."""
        place = (observation.x_m, observation.y_m)
        if self._ego is None:  # it joins the road's vehicles before the first step
            self._ego = min(self._world.vehicles, key=lambda other: hypot(*(other.position - place)))
        s, d = self.place(observation)
        ego = EgoState(*place, observation.yaw_rad, observation.speed_mps, observation.yaw_rate_radps, s, d)
        objects = self._near(ego)
        lanes = tuple(map(self._lanes.place_of, objects))
        return Scene(observation.time_s, ego, self.road, _tracks(objects, lanes), self._speed_mps)

    def place(self, observation: Observation) -> tuple[float, float]:
        """s and d of the car, m."""
        s, d = self._network.place_at(observation.x_m, observation.y_m, self._last_s_m)
        self._last_s_m = s
        return s, d

    def _near(self, ego: EgoState) -> list[Any]:
        """Solid objects that could be near the car soon, the nearest in time first."""
        found = []
        for index, obj in enumerate((*self._world.vehicles, *self._world.objects)):
            if obj is self._ego or isinstance(obj, Landmark):
                continue
            dx, dy = obj.position[0] - ego.x_m, obj.position[1] - ego.y_m
            away_m = hypot(dx, dy)
            closing_mps = max(ego.speed_mps, 0.5 * self._speed_mps) + abs(float(obj.speed)) + 1.0
            ahead_m = cos(ego.yaw_rad) * dx + sin(ego.yaw_rad) * dy
            if (away_m - NEAR_M) / closing_mps < AHEAD_S and ahead_m > -BEHIND_M:
                found.append((away_m / closing_mps, index, obj))
        return [obj for _, _, obj in sorted(found, key=lambda one: one[:2])[:MOST]]


def road_of(network: Network, route_m: float) -> Road:
    """The road along the network's reference line; `route_m` is d of the route."""
    line = network.centre
    station = np.arange(-BEFORE_M, line.length_m + BEYOND_M, STEP_M)
    every = np.arange(-BEFORE_M, line.length_m + BEYOND_M + SECTION_M, SECTION_M)
    sections = [_section(network, s) for s in np.clip(every, 0.0, line.length_m).tolist()]
    left, right, own_left = (np.interp(station, every, column) for column in np.array([one[:3] for one in sections]).T)
    middles = [one[3] for one in sections]
    most = max(1, *map(len, middles))
    table = np.array([[*lanes, *[nan] * (most - len(lanes))] for lanes in middles]).T
    nearest = np.clip(np.rint((station - every[0]) / SECTION_M).astype(np.intp), 0, len(every) - 1)
    x, y = line.position(station).T
    heading = unwrapped(line.heading(station))
    widths = [width for one in sections for width in one[4]]
    return Road(
        station, x, y, heading, line.curvature(station), left, right, own_left,
        lanes_m=table[:, nearest],
        lane_width_m=float(np.median(widths)) if widths else 2.0 * JUNCTION_HALF_M,
        route_m=route_m,
        overhang_m=0.0 if hasattr(network, "half_width_m") else CENTRE_ON_LANE_M,
    )  # fmt: skip


def _section(network: Network, s_m: float) -> tuple[float, float, float, list[float], list[float]]:
    """d of the left edge, the right edge and the own lanes' left side; the own lanes' middles and widths."""
    (x, y), heading = network.centre.position_at(s_m, 0.0), network.centre.heading_at(s_m)
    left, right = network.edges_at(x, y, heading)
    if not left < 0.0 < right:  # nan in a junction
        left, right = -JUNCTION_HALF_M, JUNCTION_HALF_M
    lanes = [one for one in _lanes(network, x, y, heading) if left - 0.5 < one[0] < right + 0.5]
    own_left = max((middle + 0.5 * width for middle, width, own in lanes if not own and middle < 0.0), default=left)
    owned = [(middle, width) for middle, width, own in lanes if own]
    return left, right, min(max(own_left, left), right), [one[0] for one in owned], [one[1] for one in owned]


def _lanes(network: Network, x_m: float, y_m: float, heading_rad: float) -> Iterator[tuple[float, float, bool]]:
    """d of the middle, width, and whether it is of our direction, for each lane parallel to the road at a point."""
    point = np.array([x_m, y_m])
    for lane in network.lanes_list():
        along, lateral = lane.local_coordinates(point)
        if not 0.0 <= along <= lane.length:
            continue
        turn = wrap_angle(lane.heading_at(along) - heading_rad)
        if min(abs(turn), pi - abs(turn)) < PARALLEL_RAD:
            own = cos(turn) > 0.0 and not getattr(lane, "oncoming", False)
            yield (-lateral if cos(turn) > 0.0 else lateral), float(lane.width_at(along)), own


def _tracks(objects: Iterable[Any], lanes: tuple[LanePlace | None, ...]) -> Tracks:
    rows = [
        (*obj.position, obj.heading, obj.speed, _yaw_rate(obj), obj.LENGTH, obj.WIDTH, *obj.place) for obj in objects
    ]
    x, y, heading, speed, yaw_rate, length, width, s, d = np.array(rows, float).reshape(-1, 9).T
    moving = np.abs(speed) > STANDING_MPS
    covariance = np.zeros((len(lanes), 4, 4))
    for axis, sigma in enumerate(SPEED_SIGMA_MPS):
        covariance[:, axis + 2, axis + 2] = np.where(moving, sigma**2, 0.0)
    return Tracks(x, y, heading, speed, yaw_rate, length, width, s, d, covariance, lanes)


def _yaw_rate(obj: Any) -> float:
    """rad/s of a car of highway-env, from its steering angle; 0 of what has none."""
    steering = float((getattr(obj, "action", None) or {}).get("steering", 0.0))
    if not steering or abs(float(obj.speed)) < STANDING_MPS:
        return 0.0
    return float(obj.speed) * sin(atan(0.5 * tan(steering))) / (0.5 * float(obj.LENGTH))
