"""highway-env's road, faster: the same decisions and states to the last bit.

highway-env searches all cars for each query of each car, and moves them one by one. Here an index by lane and place
is made once a tick, and cars that move and decide as highway-env's own classes say do so all at once; others do it by
themselves. A road gets these methods by `speed_up`; highway-env's classes, and with them the roads of others, stay.
"""

from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np
from highway_env.road.regulation import RegulatedRoad
from highway_env.road.road import LaneIndex, Road
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import RoadObject

from vpf_sim.envs.contacts import ContactRoad
from vpf_sim.envs.highway.idm_control import Controls, is_idm
from vpf_sim.envs.highway.lane_table import LaneTable
from vpf_sim.envs.highway.neighbours import Neighbours

FEW = 4  # fewer cars are faster one by one


class IndexedRoad(ContactRoad):
    """A road whose cars find their neighbours in an index."""

    _table: LaneTable | None = None
    _neighbours: Neighbours | None = None  # while cars decide, and nothing moves

    def act(self) -> None:
        """Decide the actions of all cars."""
        if len(self.vehicles) < FEW:
            super().act()
            return
        table = self._lanes()
        here = self._neighbours = Neighbours(self, table)
        try:
            cars = [car for car in self.vehicles if self._chooses_lane(car, table, here)]
            if cars:
                Controls(cars, table, here).apply()
        finally:
            self._neighbours = None

    def neighbour_vehicles(
        self, vehicle: Vehicle, lane_index: LaneIndex | None = None
    ) -> tuple[RoadObject | None, RoadObject | None]:
        """The preceding and the following vehicle; from the index while cars decide."""
        here, lane_index = self._neighbours, lane_index or vehicle.lane_index
        number = None if here is None else here.number.get(id(vehicle))
        if here is None or number is None or lane_index not in self._lanes().number:
            return super().neighbour_vehicles(vehicle, lane_index)  # type: ignore[no-any-return]
        ahead, behind = here.around(number, lane_index)
        return here.objects[ahead] if ahead >= 0 else None, here.objects[behind] if behind >= 0 else None

    def move(self, vehicles: Iterable[Vehicle], dt: float) -> None:
        """Move vehicles for dt seconds."""
        alone = self.record_history or len(self.vehicles) < FEW
        together = [] if alone else [vehicle for vehicle in vehicles if _moves_plainly(vehicle)]
        moved = set(map(id, together))
        super().move([vehicle for vehicle in vehicles if id(vehicle) not in moved], dt)
        if together:
            self._move_together(together, dt)

    def _lanes(self) -> LaneTable:
        if self._table is None or self._table.network is not self.network:
            self._table = LaneTable(self.network)
        return self._table

    def _chooses_lane(self, car: IDMVehicle, table: LaneTable, here: Neighbours) -> bool:
        """Whether a car has chosen a lane, and gets its action from `Controls`; any other acts as a whole."""
        if not is_idm(car) or car.target_lane_index not in table.number:
            car.act()
            return False
        if car.crashed:
            return False
        target = table.number[car.target_lane_index]
        lane = table.lanes[target]
        if here.s_m[target, here.number[id(car)]] > lane.length - lane.VEHICLE_LENGTH / 2:
            car.follow_road()
        changing = car.lane_index != car.target_lane_index
        if car.enable_lane_change and (changing or car.timer > car.LANE_CHANGE_DELAY):
            car.change_lane_policy()
        return True

    def _move_together(self, cars: Sequence[Vehicle], dt: float) -> None:
        """`Vehicle.step` of cars: a kinematic bicycle."""
        for car in cars:
            if isinstance(car, IDMVehicle):
                car.timer += dt
            car.clip_actions()
        state = [(car.heading, car.speed, car.action["steering"], car.LENGTH) for car in cars]
        heading, speed, steering, length = np.array(state, float).T.copy()
        slip = np.arctan(1 / 2 * np.tan(steering))
        course = heading + slip
        position = np.array([car.position for car in cars])
        position += speed[:, None] * np.stack([np.cos(course), np.sin(course)], axis=-1) * dt
        for number, car in enumerate(cars):
            if car.impact is not None:
                position[number] += car.impact
                car.crashed, car.impact = True, None
        heading += speed * np.sin(slip) / (length / 2) * dt
        table = self._lanes()
        nearest = table.nearest(position, heading).tolist()
        for car, place, direction, lane in zip(cars, position, heading, nearest, strict=True):
            car.position[:] = place
            car.heading = direction
            car.speed += car.action["acceleration"] * dt
            car.lane_index, car.lane = table.indexes[lane], table.lanes[lane]


class IndexedRegulatedRoad(RegulatedRoad, IndexedRoad):  # type: ignore[misc]
    """The same for a road with rules of priority."""


FASTER = {Road: IndexedRoad, RegulatedRoad: IndexedRegulatedRoad}


def speed_up(road: Road) -> None:
    """Make a road faster, if it is of one of highway-env's classes."""
    road.__class__ = FASTER.get(type(road), type(road))


def _moves_plainly(vehicle: Vehicle) -> bool:
    return _is_plain(type(vehicle))  # type: ignore[arg-type]  # a class is hashable


@cache
def _is_plain(kind: type) -> bool:
    """Whether cars of a class move as `Vehicle` does."""
    plain = kind.step in (Vehicle.step, IDMVehicle.step)  # type: ignore[attr-defined]
    return plain and all(getattr(kind, name) is getattr(Vehicle, name) for name in ("clip_actions", "on_state_update"))
