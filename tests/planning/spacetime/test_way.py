"""Where a path ends at something that stands."""

from math import cos, inf, pi, sqrt, tan

import numpy as np
import pytest
from made_scene import LANE_M, driven, planner, road, scene, tracks

from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.motions import AHEAD_M, motions
from vpf_sim.planning.spacetime.way import EVERY_M, way_m
from vpf_sim.types import VehicleModel

CAR = VehicleModel()
WALL_M = 14.0  # from the rear axle


def straight(*sides_m: float) -> Paths:
    """Paths at constant distances to the right of the reference line."""
    count = len(sides_m)
    coefficients = np.zeros((count, 6))
    coefficients[:, 0] = sides_m
    return Paths(np.zeros(count), np.ones(count), coefficients)


def ways_m(*objects: tuple[float, ...], sides_m: tuple[float, ...] = (0.0,), farthest_m: float = 0.0) -> list[float]:
    on, start = road(), PathState(0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    considered = motions(
        on, start, straight(*sides_m), Profiles(np.array([[0.0, farthest_m]]), *np.zeros((2, 1, 2))), CAR
    )
    found: list[float] = way_m(scene(on, tracks(on, *objects)), start, considered, CAR, 1.28).tolist()
    return found


@pytest.mark.parametrize("farthest_m", [0.0, 150.0, 600.0])
def test_a_path_ends_where_the_front_meets_what_stands(farthest_m: float) -> None:
    front_m = CAR.l_r_m + 0.5 * CAR.length_m
    (way,) = ways_m((WALL_M + 0.5, 0.0, 0.0, 0.0, 1.0, 3.0), farthest_m=farthest_m)
    assert WALL_M - front_m <= way < WALL_M - front_m + EVERY_M


@pytest.mark.parametrize(
    "thing",
    [
        pytest.param((WALL_M, 0.0, 0.0, 2.0, 4.0, 2.0), id="drives"),
        pytest.param((WALL_M, 0.5 * (CAR.width_m + 3.0) + 0.05, 0.0, 0.0, 1.0, 3.0), id="is-beside"),
        pytest.param((0.5, 0.5 * (CAR.width_m + 3.0) - 0.05, 0.0, 0.0, 1.0, 3.0), id="touches-it-now"),
        pytest.param((AHEAD_M + 10.0, 0.0, 0.0, 0.0, 1.0, 3.0), id="is-far"),
    ],
)
def test_a_path_leads_on_past_what(thing: tuple[float, ...]) -> None:
    assert ways_m(thing) == [inf]


def test_each_path_has_its_own_end() -> None:
    near, far = (8.0, -LANE_M, 0.0, 0.0, 1.0, 3.0), (12.0, 0.0, 0.0, 0.0, 1.0, 3.0)
    left, middle, right = ways_m(near, far, sides_m=(-LANE_M, 0.0, LANE_M))
    assert (middle - left, right) == (4.0, inf)


def test_a_turned_object_begins_at_its_nearest_corner() -> None:
    """A square on its corner is longer along the road, by its diagonal."""
    (straight_m,), (turned_m,) = (ways_m((WALL_M, 0.0, heading, 0.0, 2.0, 2.0)) for heading in (0.0, pi / 4.0))
    assert straight_m - turned_m == pytest.approx(sqrt(2.0) - 1.0)


def test_what_begins_beside_the_car_ends_the_way_where_they_meet() -> None:
    """A lorry beside the car leans into its path, so that they touch some metres farther on."""
    lean_rad, half_width_m = 0.14, 1.25
    (way,) = ways_m((6.5, 2.2, -lean_rad, 0.0, 12.0, 2.0 * half_width_m))
    from_middle_m = (2.2 - half_width_m / cos(lean_rad) - 0.5 * CAR.width_m) / tan(lean_rad)  # where the sides cross
    front_m = CAR.l_r_m + 0.5 * CAR.length_m
    assert 6.5 + from_middle_m - front_m <= way < 6.5 + from_middle_m - front_m + EVERY_M


@pytest.mark.parametrize("d_m", [-0.7, 0.7])
@pytest.mark.parametrize("speed_mps", [1.0, 5.5])
def test_before_a_wall_across_the_road_the_car_stops_straight(d_m: float, speed_mps: float) -> None:
    """It does not drive along the wall, past whose end no car fits, in search of a gap, and does not creep for long."""
    on = road()
    begin = scene(on, tracks(on, (WALL_M, d_m, 0.0, 0.0, 0.5, 9.0)), speed_mps=speed_mps)
    egos = [now.ego for now in driven(begin, planner(), 150)]
    assert egos[-1].speed_mps < 0.05
    assert max(abs(ego.yaw_rad) for ego in egos) < 0.1
    assert 0.1 * sum(0.05 < ego.speed_mps < 0.4 for ego in egos) < 4.0
    assert 2.7 < WALL_M - 0.25 - 0.5 * CAR.length_m - egos[-1].s_m < 3.5


def test_a_car_without_reference_speed_stands() -> None:
    """A blind car's reference is 0: it rolls no farther, however slow it is."""
    on = road()
    *_, last = driven(scene(on, tracks(on), speed_mps=0.39, reference_mps=0.0), planner(), 20)
    assert last.ego.speed_mps < 0.01
