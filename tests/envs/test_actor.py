"""Traffic actors: oncoming traffic, and manoeuvres that begin by time or by distance."""

from math import pi

import numpy as np
import pytest
from highway_env.road.lane import LineType

from vpf_sim import scenarios
from vpf_sim.envs.actor import Actor
from vpf_sim.envs.contacts import distance
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError
from vpf_sim.scenarios.random_events import EVENTS

ROAD = """
schema = 1
[road]
lanes = 3
oncoming_lanes = 1
segments = [{kind = "line", length_m = 400}]
[ego]
lane = 1
s_m = 5.0
[goal]
s_m = 300.0
"""
STAY = np.zeros(2)
BRAKE = np.array([-1.0, 0.0])


def world(*actors: str) -> tuple[FourLane, list[Actor]]:
    """The road with actors, each a TOML table's lines, after its reset."""
    text = ROAD + "".join(f"[[bodies]]\n{actor}\n" for actor in actors)
    env = FourLane(scenarios.parse(text, "road.toml"), frames=False)
    env.reset(seed=0)
    return env, [vehicle for vehicle in env.road.vehicles if isinstance(vehicle, Actor)]


def drive(env: FourLane, seconds: float, action: np.ndarray = STAY) -> None:
    for _ in range(round(60.0 * seconds)):
        env.step(action)


def test_oncoming_traffic_faces_the_ego_and_comes_nearer() -> None:
    env, (car,) = world('kind = "car"\ns_m = 200.0\nlane = 3\nspeed_mps = 8.0\noncoming = true')
    assert car.heading == pytest.approx(pi)
    drive(env, 3.0)
    assert car.place == pytest.approx((176.0, -3.5))
    assert car.velocity == pytest.approx([-8.0, 0.0])


def test_oncoming_traffic_stops_before_what_stands_in_its_way() -> None:
    barrier = 'kind = "barrier"\ns_m = 150.0\nlane = 3'
    env, (car,) = world('kind = "car"\ns_m = 200.0\nlane = 3\nspeed_mps = 8.0\noncoming = true', barrier)
    drive(env, 20.0, BRAKE)
    assert not car.crashed
    assert 0.5 < car.place[0] - 150.0 - 2.75 < 3.0


def test_a_standing_object_may_face_the_ego() -> None:
    env, _ = world('kind = "van"\ns_m = 50.0\nlane = 2\noncoming = true')
    (van,) = env.road.objects
    assert van.heading == pytest.approx(pi)


def test_a_solid_line_parts_the_directions_and_their_lanes_are_closed_to_lane_changes() -> None:
    env, _ = world()
    lanes = [env.road.network.get_lane(("start", "end", index)) for index in range(3)]
    assert [lane.line_types for lane in lanes] == [
        [LineType.CONTINUOUS_LINE, LineType.CONTINUOUS_LINE],
        [LineType.CONTINUOUS_LINE, LineType.STRIPED],
        [LineType.STRIPED, LineType.CONTINUOUS_LINE],
    ]
    assert [lane.forbidden for lane in lanes] == [True, False, False]


def test_a_car_brakes_at_its_time_with_its_rate_and_goes_on() -> None:
    stop = "{after_s = 2.0, speed_mps = 0.0, rate_mps2 = 4.0}"
    go = "{after_s = 5.0, speed_mps = 3.0}"
    env, (car,) = world(f'kind = "car"\ns_m = 60.0\nlane = 2\nspeed_mps = 8.0\nmanoeuvres = [{stop}, {go}]')
    drive(env, 2.0)
    assert car.speed == 8.0
    drive(env, 1.0)
    assert car.speed == pytest.approx(4.0, abs=0.1)
    drive(env, 3.0)
    assert car.speed == 0.0
    assert car.place[0] == pytest.approx(60.0 + 16.0 + 8.0, abs=0.2)  # 2 s at 8 m/s, then 8^2 / (2 x 4) m
    drive(env, 3.5)
    assert car.speed == pytest.approx(3.0)


def test_a_pedestrian_crosses_when_the_ego_comes_near() -> None:
    crossing = "{within_m = 20.0, lateral_m = -8.0, lateral_mps = 2.0}"
    env, (walker,) = world(f'kind = "pedestrian"\ns_m = 60.0\nlane = 1\nlateral_m = 3.0\nmanoeuvres = [{crossing}]')
    began_m: float | None = None
    while env.ego.place[0] < 50.0:
        before = walker.place[1]
        env.step(STAY)
        if began_m is None and walker.place[1] != before:
            began_m = 60.0 - env.ego.place[0] - (walker.LENGTH + env.ego.LENGTH) / 2.0
    assert began_m == pytest.approx(20.0, abs=0.2)
    assert walker.velocity == pytest.approx([0.0, -2.0], abs=1e-9)
    drive(env, 1.0, BRAKE)
    drive(env, 6.0, BRAKE)
    assert walker.place == pytest.approx((60.0, 3.5 - 8.0))
    assert walker.speed == 0.0


def test_a_car_that_cuts_in_ends_in_the_egos_lane() -> None:
    enters = "{within_m = 35.0, lateral_m = -3.5, lateral_mps = 1.0}"
    env, (car,) = world(f'kind = "car"\ns_m = 40.0\nlane = 1\nspeed_mps = 6.0\nmanoeuvres = [{enters}]')
    drive(env, 1.0)
    assert car.heading == pytest.approx(np.arctan2(-1.0, 6.0))
    drive(env, 4.0)
    assert car.place[1] == pytest.approx(0.0)
    assert car.heading == pytest.approx(0.0)


def test_what_cannot_move_has_no_manoeuvres() -> None:
    with pytest.raises(InputError, match="expected none for a cone, which cannot move"):
        world('kind = "cone"\ns_m = 60.0\nlane = 2\nmanoeuvres = [{after_s = 1.0, speed_mps = 1.0}]')


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("lane = 1", "lane = 3", "ego.lane: expected 1 to 2"),
        ("oncoming_lanes = 1", "oncoming_lanes = 3", "road.oncoming_lanes: expected fewer than the 3 lanes, got 3"),
    ],
)
def test_the_ego_drives_on_its_own_side(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        scenarios.parse(ROAD.replace(old, new), "road.toml")


def test_random_events_come_in_every_kind_and_do_not_change_the_rest() -> None:
    base = scenarios.load("random")
    text = 'base = "random"\n[random]\nevents = [3, 3]\n'
    eventful = scenarios.parse(text, "eventful.toml")
    seen = set()
    for seed in range(20):
        plain, drawn = base.draw(seed), eventful.draw(seed)
        assert drawn.road == plain.road
        assert drawn.bodies[: len(plain.bodies)] == plain.bodies
        actors = [body for body in drawn.bodies[len(plain.bodies) :] if body.is_actor]
        assert len(actors) == 3
        for actor in actors:
            crossing, braking = actor.speed_mps == 0.0, actor.manoeuvres[0].lateral_m is None
            door = actor.kind == "door"
            seen.add("door" if door else "crossing" if crossing else "hard-brake" if braking else "cut-in")
    assert seen == set(EVENTS)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_door_opens_away_from_its_car(side: float) -> None:
    car = f'kind = "car"\ns_m = 60.0\nlane = {1.5 - 0.5 * side:.0f}'
    opens = f"manoeuvres = [{{within_m = 30.0, lateral_m = {side * 1.45}, lateral_mps = 1.5}}]"
    env, (door,) = world(
        car, f'kind = "door"\ns_m = 60.5\nlane = {1.5 - 0.5 * side:.0f}\nlateral_m = {side * 1.06}\n{opens}'
    )
    (parked,) = env.road.objects
    assert door.heading == pytest.approx(0.0)
    assert distance(parked, door) < 0.01
    drive(env, 7.0)
    assert abs(np.sin(door.heading)) == pytest.approx(1.0)
    reach_m = side * (door.place[1] - parked.place[1]) + 0.5 * door.LENGTH
    assert reach_m == pytest.approx(1.95, abs=0.01)
    assert not parked.crashed


def test_a_door_in_the_way_is_a_collision() -> None:
    opens = "manoeuvres = [{within_m = 10.0, lateral_m = 0.0, lateral_mps = 3.0}]"
    env, _ = world(f'kind = "door"\ns_m = 40.0\nlane = 1\nlateral_m = 1.5\n{opens}')
    for _ in range(600):
        *_, info = env.step(STAY)
        if info["status"] != "running":
            break
    assert info["status"] == "collision"


def test_a_short_route_has_fewer_oncoming_vehicles() -> None:
    text = 'base = "random"\n[random]\nlength_m = [50.0, 130.0]\nrows = [0, 0]\noncoming = [3, 3]\n'
    counts = {len(scenarios.parse(text, "short.toml").draw(seed).bodies) for seed in range(20)}
    assert counts == {0, 1}


def test_doors_open_where_no_row_stands() -> None:
    text = 'base = "random"\n[random]\nrows = [3, 3]\nevents = [4, 4]\nevent_kinds = ["door"]\n'
    doors = 0
    for seed in range(30):
        bodies = scenarios.parse(text, "doors.toml").draw(seed).bodies
        first = next((k for k, body in enumerate(bodies) if body.is_actor), len(bodies)) - 1
        rows_m = [body.s_m for body in bodies[:first]]
        places = [body.s_m for body in bodies if body.kind == "door"]
        doors += len(places)
        assert all(abs(place - row_m) > 11.0 for place in places for row_m in rows_m)
    assert doors > 10


def test_random_oncoming_traffic_comes_on_a_lane_of_its_own_and_does_not_change_the_rest() -> None:
    base = scenarios.load("random")
    busy = scenarios.parse('base = "random"\n[random]\noncoming = [2, 4]\n', "busy.toml")
    for seed in range(20):
        plain, drawn = base.draw(seed), busy.draw(seed)
        assert (drawn.road.lanes, drawn.road.oncoming_lanes) == (plain.road.lanes + 1, 1)
        assert drawn.road.segments == plain.road.segments
        assert drawn.bodies[: len(plain.bodies)] == plain.bodies
        coming = drawn.bodies[len(plain.bodies) :]
        assert 2 <= len(coming) <= 4
        places = [body.s_m for body in coming]
        assert places[0] >= drawn.ego.s_m + 80.0
        assert min(np.diff(places)) > 10.0
        assert all(body.oncoming and body.lane == drawn.road.lanes and body.speed_mps > 0.0 for body in coming)
