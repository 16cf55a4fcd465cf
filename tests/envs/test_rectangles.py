"""Distances between objects: closed forms, and dense sampling of both outlines."""

from itertools import pairwise
from math import cos, hypot, inf, pi, sin, sqrt

import numpy as np
import pytest
from highway_env.road.road import Road
from highway_env.vehicle.objects import Landmark

from vpf_sim.envs.actor import STATIC_OBSTACLES
from vpf_sim.envs.contacts import corners, distance, free_ahead, nearest
from vpf_sim.envs.ego import Ego
from vpf_sim.envs.road import build_road
from vpf_sim.scenarios import load
from vpf_sim.scenarios.kinds import SIZES, ObjectKind


def straight() -> Road:
    return build_road(load("straight"), np.random.default_rng(0))


def scene(*objects: tuple[ObjectKind, float, float, float], heading: float = 0.0) -> Ego:
    """An ego car at (20, 0) and objects (kind, x, y, heading)."""
    road = straight()
    for kind, x, y, angle in objects:
        obj = STATIC_OBSTACLES[kind](road, (x, y))
        obj.heading = angle
        road.objects.append(obj)
    ego = Ego(road, np.array([20.0, 0.0]), heading, 5.0)
    road.vehicles.append(ego)
    return ego


def test_distance_bumper_to_bumper_side_to_side_and_corner_to_corner() -> None:
    assert nearest(scene(("car", 30.0, 0.0, 0.0)))[0] == pytest.approx(10.0 - 2.25 - 2.5)
    assert nearest(scene(("car", 20.0, 3.0, 0.0)))[0] == pytest.approx(3.0 - 0.95 - 1.0)
    corner = hypot(10.0 - 2.25 - 2.5, 4.0 - 0.95 - 1.0)
    assert nearest(scene(("car", 30.0, 4.0, 0.0)))[0] == pytest.approx(corner)
    diamond = 10.0 - 2.25 - 0.2 * sqrt(2.0)  # a cone turned by 45 degrees shows a corner
    assert nearest(scene(("cone", 30.0, 0.0, pi / 4.0)))[0] == pytest.approx(diamond)


def test_overlap_without_inside_corners_has_zero_distance() -> None:
    assert nearest(scene(("barrier", 20.0, 0.0, 0.0)))[0] == 0.0
    assert nearest(scene(("cone", 20.5, 0.2, 0.3)))[0] == 0.0
    assert nearest(scene(("car", 24.7, 0.0, 0.0)))[0] == 0.0


def test_the_nearest_of_several_counts_and_landmarks_do_not() -> None:
    ego = scene(("truck", 60.0, 0.0, 0.0), ("cone", 20.0, -4.0, 0.0), ("car", 35.0, 1.0, 0.0))
    ego.road.objects.append(Landmark(ego.road, [20.0, 0.0]))
    assert nearest(ego)[0] == pytest.approx(4.0 - 0.95 - 0.2)
    assert nearest(scene())[0] == inf


def test_rectangle_distance_matches_sampled_outlines() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        x, y, angle, heading = 20.0 + rng.uniform(-9, 9), rng.uniform(-7, 7), rng.uniform(-3, 3), rng.uniform(-3, 3)
        ego = scene(("van", x, y, angle), heading=heading)
        obj = ego.road.objects[0]
        sampled = np.array([_outline(ego), _outline(obj)])
        nearest = np.hypot(*np.moveaxis(sampled[0][:, None] - sampled[1][None], -1, 0)).min()
        if distance(ego, obj) > 0.0:
            assert nearest - 0.03 <= distance(ego, obj) <= nearest + 1e-12
        else:
            assert nearest < 0.03 or hypot(x - 20.0, y) < 2.0
        assert distance(ego, obj) == pytest.approx(distance(obj, ego), abs=1e-12)


def _outline(obj: Ego) -> np.ndarray:
    """(400, 2) points along the four sides."""
    ends = np.array([*corners(obj), corners(obj)[0]])
    share = np.linspace(0.0, 1.0, 100, endpoint=False)[:, None]
    return np.concatenate([a + share * (b - a) for a, b in pairwise(ends)])


def test_corners_are_half_the_sizes_away_along_and_across_the_heading() -> None:
    ego = scene(heading=0.7)
    forward, right = np.array([cos(0.7), sin(0.7)]), np.array([-sin(0.7), cos(0.7)])
    relative = np.array(corners(ego)) - ego.position
    assert relative @ forward == pytest.approx([2.25, 2.25, -2.25, -2.25])
    assert relative @ right == pytest.approx([-0.95, 0.95, 0.95, -0.95])


def test_free_distance_ends_at_the_first_object_in_the_strip() -> None:
    behind_and_beside = [("car", 10.0, 0.0, 0.0), ("car", 30.0, 2.0, 0.0)]
    assert free_ahead(scene(*behind_and_beside)) == inf
    assert free_ahead(scene(*behind_and_beside, ("barrier", 33.0, 2.0, 0.0))) == pytest.approx(13.0 - 0.25 - 2.25)
    turned = scene(("car", 20.0, 12.0, 0.0), heading=pi / 2.0)
    assert free_ahead(turned) == pytest.approx(12.0 - SIZES["car"].width_m / 2.0 - 2.25)


def test_wide_object_across_the_strip_counts_with_corners_outside() -> None:
    assert free_ahead(scene(("barrier", 30.0, 0.0, 0.0))) == pytest.approx(10.0 - 0.25 - 2.25)
    slanted = scene(("barrier", 30.0, 0.0, 0.3))  # its near side x cos + y sin = -0.25 leaves the strip at y = 0.95
    assert free_ahead(slanted) == pytest.approx(10.0 - (0.25 + 0.95 * sin(0.3)) / cos(0.3) - 2.25)
