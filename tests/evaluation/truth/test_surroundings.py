"""Ground truth of the ego's surroundings, on layouts with a closed form."""

from math import cos, inf, pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vpf_sim.envs.contacts import corners
from vpf_sim.evaluation.truth import surroundings
from vpf_sim.types import RoadEdges


def box(x: float, y: float, heading: float = 0.0, speed: float = 0.0, length: float = 4.0, width: float = 2.0) -> Any:
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
def test_time_to_contact(ego_speed: float, x: float, y: float, speed: float, expected_s: float, turn: float) -> None:
    ahead = np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]]) @ (x, y)
    ego, other = box(0.0, 0.0, turn, ego_speed), box(*ahead, turn, speed)
    assert surroundings.contact_s(ego, other) == pytest.approx(expected_s, abs=1e-9)


def test_a_car_from_the_side_hits_only_if_both_are_there_at_the_same_time() -> None:
    ego = box(0.0, 0.0, speed=5.0)
    assert surroundings.contact_s(ego, box(20.0, -20.0, pi / 2.0, speed=5.0)) == pytest.approx(17.0 / 5.0)
    assert surroundings.contact_s(ego, box(20.0, -60.0, pi / 2.0, speed=5.0)) == inf


def test_a_rotated_object_is_touched_at_its_corner() -> None:
    """A square of 2 m on its point: the corner is sqrt 2 m from its centre, and from there its side recedes."""
    ego = box(0.0, 0.0, speed=5.0)
    for right, met_m in ((0.0, 20.0 - 2.0**0.5), (1.5, 20.0 - 2.0**0.5 + 0.5), (2.0**0.5 + 0.99, 20.0 - 0.01)):
        square = box(20.0, right, pi / 4.0, length=2.0)
        assert surroundings.contact_s(ego, square) == pytest.approx((met_m - 2.0) / 5.0, abs=0.01)
    assert surroundings.contact_s(ego, box(20.0, 2.0**0.5 + 1.01, pi / 4.0, length=2.0)) == inf


def test_the_time_to_collision_counts_the_objects_of_nuplan() -> None:
    ego = box(0.0, 0.0, speed=5.0)
    ahead, behind = box(24.0, 0.0), box(-24.0, 0.0, speed=9.0)
    beside = box(10.0, -10.0, pi / 2.0, speed=5.0)  # 41 degrees off the heading, seen from 1.35 m behind
    for in_lane, expected_s in ((True, inf), (False, 7.0 / 5.0)):  # then its front is at the ego's side
        assert surroundings.time_to_collision(ego, [beside], in_lane) == pytest.approx(expected_s)
        assert surroundings.time_to_collision(ego, [behind], in_lane) == inf
        assert surroundings.time_to_collision(ego, [ahead, behind], in_lane) == pytest.approx(4.0)
    assert surroundings.time_to_collision(box(0.0, 0.0), [box(24.0, 0.0, pi, speed=5.0)], True) == inf, "it stands"
    assert surroundings.time_to_collision(ego, [], True) == inf


def test_the_gap_to_the_front_bumper_and_the_bearing() -> None:
    ego = box(0.0, 0.0, pi / 2.0)  # it looks along y, its front at y = 2
    assert surroundings.bumper_gap_m(ego, box(0.0, 10.0)) == pytest.approx(10.0 - 2.0 - 1.0)
    assert surroundings.bumper_gap_m(ego, box(-3.0, 0.0, pi / 2.0)) == pytest.approx(1.0), "beside, to its front corner"
    assert surroundings.bumper_gap_m(ego, box(-3.0, -5.0, pi / 2.0)) == pytest.approx((1.0 + 5.0**2) ** 0.5)
    assert surroundings.bumper_gap_m(ego, box(0.0, 2.5)) == 0.0
    assert surroundings.bearing_rad(ego, box(-5.0, -1.35)) == pytest.approx(pi / 2.0), "on the right of the rear axle"


def test_passing_is_25_m_before_to_15_m_after() -> None:
    objects = [box(100.0, 5.0)]
    places = [74.9, 75.0, 100.0, 115.0, 115.1]
    assert [surroundings.is_passing(box(s, 0.0), objects) for s in places] == [False, True, True, True, False]
    assert not surroundings.is_passing(box(0.0, 0.0), [])


@pytest.fixture
def bend() -> Any:
    """A road of four lanes to the right about (0, 100), in the scenario's own geometry."""
    from vpf_sim.envs.road import Carriageway
    from vpf_sim.scenarios.parts import Road

    return Carriageway(Road.model_validate({"segments": [{"kind": "arc", "length_m": 100.0, "radius_m": 100.0}]}))


def test_perceived_edges_equal_the_true_ones_for_exact_perception(bend: Any) -> None:
    """A point 10 m ahead in a bend of R 100 m: to second order both say the same, 3 mm apart."""
    s, lateral, yaw_error = 30.0, 1.5, 0.05
    position = np.array(bend.centre.position_at(s, lateral))
    ego = SimpleNamespace(position=position, heading=bend.centre.heading_at(s) + yaw_error)
    road = RoadEdges(-7.0 - lateral, 7.0 - lateral, -yaw_error, 1.0 / 100.0, 0.0, 1.0, 1.75 - lateral, 3.5)
    assert surroundings.perceived_edges(road) == pytest.approx(surroundings.true_edges(ego, bend), abs=0.02)


@pytest.mark.parametrize(
    ("lateral", "outside", "in_lane"),
    [
        (5.9, False, True),
        (6.2, True, False),
        (-5.9, False, True),
        (-6.2, True, False),
        (1.75, False, True),
        (0.5, False, False),
    ],
)
def test_outside_is_a_corner_beyond_the_edge_and_a_lane_holds_all_four(
    bend: Any, lateral: float, outside: bool, in_lane: bool
) -> None:
    s = 50.0
    ego = box(*bend.centre.position_at(s, lateral), bend.centre.heading_at(s), length=4.5, width=1.9)
    assert bend.lane_use(corners(ego), s) == (outside, in_lane)
