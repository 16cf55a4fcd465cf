"""Contacts of the objects on a road, as highway-env finds them, but asked only of pairs that are near each other."""

from collections.abc import Iterable, Sequence

from highway_env.road.road import Road
from highway_env.vehicle.objects import RoadObject

SPARE_M = 1e-6  # on the distance from which highway-env looks closer, against rounding


class ContactRoad(Road):  # type: ignore[misc]
    """highway-env's road: the same contacts in the same order, with fewer questions."""

    def step(self, dt: float) -> None:
        """Move all vehicles for dt seconds, and find contacts."""
        self.move(self.vehicles, dt)
        objects = [*self.vehicles, *self.objects]
        for one, other in near_pairs(objects, dt):
            if one < len(self.vehicles):
                objects[one].handle_collisions(objects[other], dt)

    def move(self, vehicles: Iterable[RoadObject], dt: float) -> None:
        """Move vehicles for dt seconds."""
        for vehicle in vehicles:
            vehicle.step(dt)


def near_pairs(objects: Sequence[RoadObject], dt: float) -> list[tuple[int, int]]:
    """Pairs of numbers, in order, of objects that may touch within dt seconds; those left out do not."""
    spans = sorted(_span(obj, number, dt) for number, obj in enumerate(objects))
    found: list[tuple[int, int]] = []
    open_spans: list[tuple[float, float, float, float, int]] = []
    for span in spans:
        low_x, _, low_y, high_y, number = span
        open_spans = [other for other in open_spans if other[1] >= low_x]
        found += [
            (number, other[4]) if number < other[4] else (other[4], number)
            for other in open_spans
            if other[3] >= low_y and other[2] <= high_y
        ]
        open_spans.append(span)
    return sorted(found)


def _span(obj: RoadObject, number: int, dt: float) -> tuple[float, float, float, float, int]:
    """Low and high x, low and high y, m, of what an object may reach; and its number."""
    x, y = obj.position.tolist()
    reach = float(obj.diagonal) / 2.0 + abs(float(obj.speed)) * dt + SPARE_M
    return x - reach, x + reach, y - reach, y + reach, number
