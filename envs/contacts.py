"""Contacts of the objects on a road, checked only for pairs near each other, and exact distances of rectangles."""

from collections.abc import Iterable, Sequence
from math import cos, hypot, inf, sin
from operator import itemgetter

from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Landmark

from vpf_sim.envs.network import OnRoad, Outline, Point

SPARE_M = 1e-6  # on the distance from which highway-env checks further, against rounding


class ContactRoad(Road):  # type: ignore[misc]
    """highway-env's road: the same contacts in the same order, with fewer checks."""

    def step(self, dt: float) -> None:
        """Move all vehicles for dt seconds, and find contacts."""
        self.move(self.vehicles, dt)
        objects = [*self.vehicles, *self.objects]
        for one, other in near_pairs(objects, dt):
            if one < len(self.vehicles):
                objects[one].handle_collisions(objects[other], dt)

    def move(self, vehicles: Iterable[Vehicle], dt: float) -> None:
        """Move vehicles for dt seconds."""
        for vehicle in vehicles:
            vehicle.step(dt)


def near_pairs(objects: Sequence[OnRoad], dt: float) -> list[tuple[int, int]]:
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


def _span(obj: OnRoad, number: int, dt: float) -> tuple[float, float, float, float, int]:
    """Low and high x, low and high y, m, of what an object may reach; and its number."""
    x, y = obj.position.tolist()
    reach = float(obj.diagonal) / 2.0 + abs(float(obj.speed)) * dt + SPARE_M
    return x - reach, x + reach, y - reach, y + reach, number


def corners(obj: Outline) -> list[Point]:
    """The four corners in the world, in order around the rectangle."""
    x, y = obj.position.tolist()
    cosine, sine = cos(obj.heading), sin(obj.heading)
    a, b = obj.LENGTH / 2.0, obj.WIDTH / 2.0
    own = ((a, -b), (a, b), (-a, b), (-a, -b))
    return [(x + cosine * along - sine * right, y + sine * along + cosine * right) for along, right in own]


def to_local(obj: Outline, points: Iterable[Point]) -> list[Point]:
    """World points in an object's frame: metres forward and right of its centre."""
    x, y = obj.position.tolist()
    cosine, sine = cos(obj.heading), sin(obj.heading)
    return [(cosine * (px - x) + sine * (py - y), cosine * (py - y) - sine * (px - x)) for px, py in points]


def distance(a: Outline, b: Outline) -> float:
    """m between the nearest points of two objects; 0 where they touch or overlap.

    For two separate convex shapes, one of the nearest points is a corner, so the corners of each are measured against
    the other. They are separate if all corners of one lie beyond one side of the other (separating axis).
    """
    b_from_a, a_from_b = to_local(a, corners(b)), to_local(b, corners(a))
    if not (_beyond_a_side(a, b_from_a) or _beyond_a_side(b, a_from_b)):
        return 0.0
    return min(_from_corners(a, b_from_a), _from_corners(b, a_from_b))


def _beyond_a_side(obj: Outline, points: list[Point]) -> bool:
    a, b = obj.LENGTH / 2.0, obj.WIDTH / 2.0
    along, across = [point[0] for point in points], [point[1] for point in points]
    return bool(min(along) > a or max(along) < -a or min(across) > b or max(across) < -b)


def _from_corners(obj: Outline, points: list[Point]) -> float:
    half_length, half_width = obj.LENGTH / 2.0, obj.WIDTH / 2.0
    return min(hypot(max(abs(x) - half_length, 0.0), max(abs(y) - half_width, 0.0)) for x, y in points)


def solid_objects(ego: OnRoad) -> list[OnRoad]:
    """All objects on the ego's road that it can collide with."""
    road = ego.road
    others = [other for other in road.vehicles if other is not ego]
    return others + [obj for obj in road.objects if not isinstance(obj, Landmark)]


def nearest(ego: OnRoad) -> tuple[float, OnRoad | None]:
    """m from the ego to the nearest object, and that object; inf and None without objects."""
    x, y = ego.position.tolist()
    bounds = []
    for other in solid_objects(ego):
        other_x, other_y = other.position.tolist()
        bounds.append((hypot(other_x - x, other_y - y) - (ego.diagonal + other.diagonal) / 2.0, other))
    nearest_m, obj = inf, None
    for bound_m, other in sorted(bounds, key=itemgetter(0)):
        if bound_m > nearest_m:
            break
        if (gap_m := distance(ego, other)) < nearest_m:
            nearest_m, obj = gap_m, other
    return nearest_m, obj


def free_ahead(ego: OnRoad) -> float:
    """m from the front bumper to the first object in the strip straight ahead; inf without one."""
    faces = (_first_in_strip(to_local(ego, corners(other)), ego.WIDTH / 2.0) for other in solid_objects(ego))
    return float(min((face for face in faces if face > 0.0), default=inf) - ego.LENGTH / 2.0)


def _first_in_strip(points: list[Point], half_width: float) -> float:
    """Least distance ahead at which a convex outline is in the strip |right| <= half_width; inf if nowhere."""
    ahead = [x for x, right in points if abs(right) <= half_width]
    edges = list(zip(points, points[1:] + points[:1], strict=True))
    for side in (-half_width, half_width):
        crossing = [edge for edge in edges if (edge[0][1] - side) * (edge[1][1] - side) < 0.0]
        ahead += [x0 + (x1 - x0) * (side - y0) / (y1 - y0) for (x0, y0), (x1, y1) in crossing]
    return min(ahead, default=inf)
