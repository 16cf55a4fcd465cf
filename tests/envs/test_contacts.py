"""Contacts of a scenario's road are highway-env's."""

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Obstacle

from vpf_sim.envs.contacts import ContactRoad

DT = 1.0 / 60.0


def crowd(kind: type[Road], seed: int) -> Road:
    """Cars and obstacles close together, without lanes."""
    draw = np.random.default_rng(seed)
    road = kind()
    for _ in range(12):
        car = Vehicle(None, draw.uniform(0.0, 25.0, 2), draw.uniform(-4.0, 4.0), draw.uniform(-5.0, 20.0))
        car.check_collisions = bool(draw.random() < 0.8)
        road.vehicles.append(car)
    for _ in range(4):
        road.objects.append(Obstacle(None, draw.uniform(0.0, 25.0, 2)))
    return road


def test_contacts_and_what_they_do_are_highway_envs() -> None:
    crashed = 0
    for seed in range(10):
        ours, theirs = crowd(ContactRoad, seed), crowd(Road, seed)
        for _ in range(30):
            ours.step(DT)
            theirs.step(DT)
        for one, other in zip([*ours.vehicles, *ours.objects], [*theirs.vehicles, *theirs.objects], strict=True):
            assert one.position.tolist() == other.position.tolist()
            assert (one.crashed, one.speed) == (other.crashed, other.speed)
            crashed += one.crashed
    assert 0 < crashed < 160


def test_only_near_pairs_are_asked() -> None:
    requested = []

    class Counting(Vehicle):  # type: ignore[misc]
        def handle_collisions(self, other: object, dt: float = 0) -> None:  # noqa: ARG002
            requested.append((self, other))

    road = ContactRoad()
    road.vehicles = [Counting(None, (20.0 * number, 0.0), speed=10.0) for number in range(40)]
    road.vehicles.append(Counting(None, (20.0, 3.0)))
    road.step(DT)
    assert requested == [(road.vehicles[1], road.vehicles[40])]
