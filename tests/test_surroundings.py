"""What the harness measures in the world, on layouts with a closed form."""

from math import cos, inf, pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vpf_sim.evaluation import surroundings
from vpf_sim.types import RoadEdges


def body(x: float, y: float, heading: float = 0.0, speed: float = 0.0, length: float = 4.0, width: float = 2.0) -> Any:
    return SimpleNamespace(
        position=np.array([x, y]),
        heading=heading,
        velocity=speed * np.array([cos(heading), sin(heading)]),
        LENGTH=length,
        WIDTH=width,
        place=(x, y),
    )


@pytest.mark.parametrize("turn", [0.0, 0.7, -2.0])
@pytest.mark.parametrize(
    ("ego_speed", "x", "y", "speed", "expected_s"),
    [
        (5.0, 24.0, 0.0, 0.0, 4.0),  # 20 m between the bumpers
        (5.0, 24.0, 1.99, 0.0, 4.0),  # it would be grazed
        (5.0, 24.0, 2.01, 0.0, inf),  # it would be missed
        (5.0, 24.0, 0.0, 3.0, 10.0),  # it drives on, more slowly
        (5.0, 24.0, 0.0, 6.0, inf),  # it drives away
        (5.0, -24.0, 0.0, 0.0, inf),  # it is behind
        (5.0, -24.0, 0.0, 9.0, 5.0),  # it is behind and faster
        (0.0, 24.0, 0.0, 0.0, inf),
        (5.0, 3.0, 0.5, 0.0, 0.0),  # they overlap
    ],
)
def test_time_to_collision(ego_speed: float, x: float, y: float, speed: float, expected_s: float, turn: float) -> None:
    ahead = np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]]) @ (x, y)
    ego, other = body(0.0, 0.0, turn, ego_speed), body(*ahead, turn, speed)
    assert surroundings.time_to_collision(ego, [other]) == pytest.approx(expected_s, abs=1e-9)


def test_a_car_from_the_side_hits_only_if_both_are_there_at_the_same_time() -> None:
    ego = body(0.0, 0.0, speed=5.0)
    assert surroundings.time_to_collision(ego, [body(20.0, -20.0, pi / 2.0, speed=5.0)]) == pytest.approx(17.0 / 5.0)
    assert surroundings.time_to_collision(ego, [body(20.0, -60.0, pi / 2.0, speed=5.0)]) == inf


def test_passing_is_25_m_before_to_15_m_after() -> None:
    bodies = [body(100.0, 5.0)]
    places = [74.9, 75.0, 100.0, 115.0, 115.1]
    assert [surroundings.is_passing(body(s, 0.0), bodies) for s in places] == [False, True, True, True, False]
    assert not surroundings.is_passing(body(0.0, 0.0), [])


@pytest.fixture
def bend() -> Any:
    """A road of four lanes to the right about (0, 100), in the scenario's own geometry."""
    from vpf_sim.envs.road import Carriageway
    from vpf_sim.scenarios.parts import Road

    return Carriageway(Road.model_validate({"segments": [{"kind": "arc", "length_m": 100.0, "radius_m": 100.0}]}))


def test_edges_as_seen_are_the_true_ones_where_perception_is_right(bend: Any) -> None:
    """A point 10 m ahead in a bend of R 100 m: to second order both say the same, 3 mm apart."""
    s, lateral, yaw_error = 30.0, 1.5, 0.05
    position = np.array(bend.centre.position_at(s, lateral))
    ego = SimpleNamespace(position=position, heading=bend.centre.heading_at(s) + yaw_error)
    road = RoadEdges(-7.0 - lateral, 7.0 - lateral, -yaw_error, 1.0 / 100.0, 0.0, 1.0)
    assert surroundings.seen_edges(road) == pytest.approx(surroundings.true_edges(ego, bend), abs=0.02)


def test_outside_is_a_corner_beyond_the_edge(bend: Any) -> None:
    for lateral, outside in ((5.9, False), (6.2, True), (-5.9, False), (-6.2, True)):
        s = 50.0
        ego = body(*bend.centre.position_at(s, lateral), bend.centre.heading_at(s), length=4.5, width=1.9)
        assert surroundings.is_outside(ego, bend) is outside
