"""Steering and acceleration of all of highway-env's IDM cars at once, with its own arithmetic.

The formulas are those of `IDMVehicle.act` after its choice of a lane, operation by operation, so that the results are
equal to the last bit.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from highway_env.utils import wrap_to_pi
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.highway.lane_table import LaneTable
from vpf_sim.envs.highway.neighbours import Neighbours
from vpf_sim.types import Floats

LAW = ("act", "follow_road", "steering_control", "acceleration", "desired_gap", "lane_distance_to")
LEAST = 1e-2  # of `highway_env.utils.not_zero`
PARAMETERS = (
    "speed",
    "heading",
    "target_speed",
    "LENGTH",
    "KP_LATERAL",
    "KP_HEADING",
    "TAU_PURSUIT",
    "MAX_STEERING_ANGLE",
    "ACC_MAX",
    "COMFORT_ACC_MAX",
    "COMFORT_ACC_MIN",
    "DISTANCE_WANTED",
    "TIME_WANTED",
    "DELTA",
)


def is_idm(car: RoadObject) -> bool:
    """Whether a car follows highway-env's own IDM law and steering."""
    return _has_law(type(car))  # type: ignore[arg-type]  # a class is hashable


@cache
def _has_law(kind: type) -> bool:
    return all(getattr(kind, name, None) is getattr(IDMVehicle, name) for name in LAW)


class Controls:
    """Cars that follow the law, on their lanes and among all objects."""

    def __init__(self, cars: Sequence[IDMVehicle], table: LaneTable, neighbours: Neighbours) -> None:
        self._cars, self._table, self._neighbours = cars, table, neighbours
        self._number = np.array([neighbours.number[id(car)] for car in cars])
        self._lane = np.array([table.number[car.lane_index] for car in cars])
        self._target = np.array([table.number[car.target_lane_index] for car in cars])
        columns = np.array([[getattr(car, name) for name in PARAMETERS] for car in cars], float).T.copy()
        self._of: dict[str, Floats] = dict(zip(PARAMETERS, columns, strict=True))

    def apply(self) -> None:
        """Give each car its action."""
        steering, acceleration = self._steering(), self._acceleration()
        for car, angle, along in zip(self._cars, steering.tolist(), acceleration.tolist(), strict=True):
            car.action = {"steering": angle, "acceleration": along}

    def _steering(self) -> Floats:
        """(N,) rad towards the target lanes."""
        of, speed = self._of, _not_zero(self._of["speed"])
        s, lateral = (
            values[self._target, self._number] for values in (self._neighbours.s_m, self._neighbours.lateral_m)
        )
        ahead = self._table.headings_on(self._target, s + of["speed"] * of["TAU_PURSUIT"])
        heading_command = np.arcsin(np.clip(-of["KP_LATERAL"] * lateral / speed, -1, 1))
        wanted = ahead + np.clip(heading_command, -np.pi / 4, np.pi / 4)
        rate = of["KP_HEADING"] * wrap_to_pi(wanted - of["heading"])
        slip = np.arcsin(np.clip(of["LENGTH"] / 2 / speed * rate, -1, 1))
        most = of["MAX_STEERING_ANGLE"]
        return np.asarray(np.clip(np.arctan(2 * np.tan(slip)), -most, most))

    def _acceleration(self) -> Floats:
        """(N,) m/s2; of cars that change lane the lower of those for both lanes."""
        of, around = self._of, self._neighbours.around
        limits = (self._table.lanes[lane].speed_limit for lane in self._lane.tolist())
        limit = np.array([np.inf if one is None else one for one in limits])
        bounded = np.where(np.isinf(limit), of["target_speed"], np.clip(of["target_speed"], 0, limit))
        share = np.maximum(of["speed"], 0) / np.abs(_not_zero(bounded))
        free = of["COMFORT_ACC_MAX"] * (1 - np.power(share, of["DELTA"]))
        motion = self._neighbours_motion()
        numbers = self._number.tolist()
        leaders = [around(number, car.lane_index)[0] for number, car in zip(numbers, self._cars, strict=True)]
        found = self._behind(free, leaders, motion)
        changing = np.flatnonzero(self._lane != self._target).tolist()
        if changing:
            for place in changing:
                leaders[place] = around(numbers[place], self._cars[place].target_lane_index)[0]
            other = self._behind(free, leaders, motion)
            found[changing] = np.minimum(found[changing], other[changing])
        return np.clip(found, -of["ACC_MAX"], of["ACC_MAX"])

    def _neighbours_motion(self) -> tuple[Floats, Floats]:
        """(M, 2) velocities and directions of all objects."""
        objects = self._neighbours.objects
        speed, heading = np.array([(obj.speed, obj.heading) for obj in objects], float).T.copy()
        direction = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        velocity = speed[:, None] * direction
        for number, obj in enumerate(objects):
            if not _goes_where_it_points(type(obj)):  # type: ignore[arg-type]
                velocity[number] = obj.velocity
        return velocity, direction

    def _behind(self, free: Floats, leaders: Sequence[int], motion: tuple[Floats, Floats]) -> Floats:
        """(N,) m/s2 behind leaders, by their numbers; -1 where the road is free."""
        of, (velocity, direction) = self._of, motion
        front: NDArray[np.intp] = np.array(leaders)
        s = self._neighbours.s_m
        gap = _not_zero(s[self._lane, front] - s[self._lane, self._number])
        closing = np.vecdot(velocity[self._number] - velocity[front], direction[self._number])
        comfort = 2 * np.sqrt(-of["COMFORT_ACC_MAX"] * of["COMFORT_ACC_MIN"])
        wanted = of["DISTANCE_WANTED"] + of["speed"] * of["TIME_WANTED"] + of["speed"] * closing / comfort
        followed = free - of["COMFORT_ACC_MAX"] * np.power(wanted / gap, 2)
        return np.where(front >= 0, followed, free)


@cache
def _goes_where_it_points(kind: type) -> bool:
    return kind.velocity in (Vehicle.velocity, RoadObject.velocity)  # type: ignore[attr-defined]


def _not_zero(values: Floats) -> Floats:
    """`highway_env.utils.not_zero` of an array."""
    return np.where(np.abs(values) > LEAST, values, np.where(values >= 0, LEAST, -LEAST))
