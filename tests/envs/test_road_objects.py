"""Objects on the road: sizes by kind, placement, and traffic that keeps lane, speed and distance."""

from math import hypot

import numpy as np
import pytest
from highway_env.road.road import Road

from vpf_sim import scenarios
from vpf_sim.envs.actor import ACTORS, STATIC_OBSTACLES, place_objects
from vpf_sim.envs.road import build_road
from vpf_sim.scenarios import SIZES, Scenario

BEND = """
schema = 1
[road]
segments = [{kind = "arc", length_m = 400, radius_m = 80}]
[goal]
s_m = 300.0
"""


def object_table(**keys: object) -> str:
    lines = "\n".join(f"{key} = {value!r}" for key, value in keys.items())
    return f"\n[[bodies]]\n{lines}\n"


def populated(*objects: str) -> tuple[Scenario, Road]:
    scenario = scenarios.parse(BEND + "".join(objects), "bend.toml")
    road = build_road(scenario, np.random.default_rng(0))
    place_objects(road, scenario)
    return scenario, road


def run(road: Road, seconds: float) -> None:
    for _ in range(round(seconds * 60.0)):
        road.act()
        road.step(1.0 / 60.0)


@pytest.mark.parametrize("classes", [STATIC_OBSTACLES, ACTORS])
def test_each_kind_has_a_class_with_its_size(classes: dict[str, type]) -> None:
    for kind, made in classes.items():
        size = SIZES[kind]
        assert (made.LENGTH, made.WIDTH, made.HEIGHT, made.kind) == (*size, kind)


def test_every_kind_is_placed_along_its_lane() -> None:
    objects = [object_table(kind=kind, s_m=20.0 + 10.0 * i, lane=3, lateral_m=-0.25) for i, kind in enumerate(SIZES)]
    scenario, road = populated(*objects)
    assert [obj.kind for obj in road.objects] == list(SIZES)
    assert road.vehicles == []
    for planned, obj in zip(scenario.bodies, road.objects, strict=True):
        lane = road.network.get_lane(("start", "end", 1))
        assert lane.local_coordinates(obj.position) == pytest.approx((planned.s_m, -0.25), abs=1e-9)
        assert obj.heading == pytest.approx(planned.s_m / 80.0)
        assert obj.diagonal == pytest.approx(hypot(*SIZES[planned.kind][:2]))


def test_actor_keeps_speed_and_lane_in_a_bend() -> None:
    _, road = populated(object_table(kind="car", s_m=20.0, lane=1, lateral_m=0.3, speed_mps=8.0))
    (car,) = road.vehicles
    start = car.position
    run(road, 10.0)
    radius = 80.0 - 5.25 - 0.3
    assert car.speed == 8.0
    assert hypot(car.position[0], car.position[1] - 80.0) == pytest.approx(radius)
    turn = car.heading - 20.0 / 80.0
    assert turn * radius == pytest.approx(8.0 * 10.0, rel=1e-9)
    assert hypot(*(car.position - start)) == pytest.approx(2.0 * radius * np.sin(turn / 2.0), rel=1e-9)


def test_actor_stops_behind_a_static_obstacle_without_reversing() -> None:
    _, road = populated(
        object_table(kind="car", s_m=20.0, lane=2, speed_mps=8.0),
        object_table(kind="barrier", s_m=120.0, lane=2, lateral_m=0.5),
    )
    (car,) = road.vehicles
    speeds = []
    for _ in range(60):
        run(road, 1.0)
        speeds.append(car.speed)
    assert min(speeds) >= 0.0
    assert speeds[-1] < 0.05
    gap = 120.0 - car.place[0] - (5.0 + 0.5) / 2.0
    assert 1.5 < gap < 3.0
    assert not car.crashed


def test_actor_follows_a_slower_leader_and_passes_objects_beside() -> None:
    _, road = populated(
        object_table(kind="van", s_m=30.0, lane=2, speed_mps=8.0),
        object_table(kind="truck", s_m=60.0, lane=2, speed_mps=4.0),
        object_table(kind="car", s_m=90.0, lane=1),
    )
    van, truck = road.vehicles
    run(road, 40.0)
    assert truck.speed == pytest.approx(4.0)
    assert van.speed == pytest.approx(4.0, abs=0.05)
    gap = truck.place[0] - van.place[0] - (SIZES["van"].length_m + SIZES["truck"].length_m) / 2.0
    wanted = (2.0 + 1.5 * 4.0) / np.sqrt(1.0 - (4.0 / 8.0) ** 4)  # where the model neither gains nor brakes
    assert gap * (1.0 - 1.75 / 80.0) == pytest.approx(wanted, abs=0.3)
    assert van.place[0] > 90.0
    assert not van.crashed
    assert not truck.crashed


def test_crashed_actor_brakes_to_standstill() -> None:
    _, road = populated(object_table(kind="car", s_m=20.0, lane=1, speed_mps=6.0))
    (car,) = road.vehicles
    car.crashed = True
    run(road, 1.1)
    assert car.speed == 0.0
    assert (car.place[0] - 20.0) * (1.0 - 5.25 / 80.0) == pytest.approx(6.0**2 / 12.0, abs=0.06)
