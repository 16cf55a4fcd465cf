"""Middle and width of a vehicle's face, from synthetic points whose truth is known."""

import numpy as np
import pytest
from driver_settings import moving_obstacles

from vpf_sim.perception.obstacles.moving.extent import Sides
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

CONFIG = moving_obstacles().filter.extent
DEPTH_M, LOOK_S = 10.0, 0.05
FRESH = 0.1  # weight of an observation
FACE_M = np.linspace(-0.95, 0.95, 24)


def followed(
    points_m: Floats,
    odds: Floats | float,
    looks: int = 40,
    middle_m: float = 0.0,
    camera_m: float = 0.0,
) -> tuple[float, Sides]:
    """m, the middle by points `points_m` (N,) right of the first middle, and the filter after `looks` observations.

    The camera is `camera_m` right of the first middle.
    """
    sides = Sides(CONFIG)
    for _ in range(looks):
        sides.predict(LOOK_S)
        across = points_m - middle_m
        middle_m += sides.update(across, np.broadcast_to(odds, across.shape), camera_m - middle_m, DEPTH_M, FRESH)
    return middle_m, sides


@pytest.mark.parametrize("true_m", [-0.8, 0.0, 0.5])
def test_points_all_over_a_face_fix_its_middle_and_width(true_m: float) -> None:
    middle, sides = followed(true_m + FACE_M, 4.0)
    assert middle == pytest.approx(true_m, abs=0.12)
    assert sides.half_m == pytest.approx(0.95, abs=0.12)
    assert sides.sigma_m < 0.25


def test_a_narrow_cluster_bounds_a_vehicle_and_does_not_attract_its_middle() -> None:
    """A cluster .08 m wide at .7 m lies in a body at 0: half a second's low-pass of .2 s would move it by .64 m."""
    sides, middle, cluster = Sides(CONFIG), 0.0, 0.7 + np.linspace(-0.04, 0.04, 12)
    for points in [FACE_M] * 20 + [cluster] * 10:
        sides.predict(LOOK_S)
        middle += sides.update(points - middle, np.full(len(points), 4.0), -middle, DEPTH_M, FRESH)
    assert abs(middle) < 0.1
    unknown, free = followed(cluster, 4.0)
    assert abs(unknown) < 0.7 - 0.15
    assert free.sigma_m > 0.3, "anywhere in an interval"


def test_points_beyond_a_side_move_the_vehicle_until_they_lie_in_it() -> None:
    cluster = 1.6 + np.linspace(-0.04, 0.04, 12)
    middle, sides = followed(cluster, 4.0)
    assert 1.6 - sides.half_m - 0.3 < middle < 1.4


def test_the_background_beside_a_vehicle_bounds_it_from_outside() -> None:
    """Only the right half of a vehicle at 0 has points; the wall behind it is seen up to its right side."""
    half = np.linspace(0.0, 0.95, 12)
    wall = np.linspace(1.05, 2.4, 14)
    odds = np.concatenate([np.full(12, 4.0), np.full(14, -4.0)])
    drawn, _ = followed(half, 4.0, middle_m=0.6)
    held, _ = followed(np.concatenate([half, wall]), odds, middle_m=0.6)
    assert abs(held) < 0.2
    assert drawn > 0.35


def test_undecided_points_change_nothing() -> None:
    rng = stream(91, "neither")
    middle, sides = followed(rng.uniform(0.5, 2.4, 40), 0.0, looks=4)
    fresh = Sides(CONFIG)
    for _ in range(4):
        fresh.predict(LOOK_S)
    assert middle == pytest.approx(0.0, abs=1e-9)
    assert sides.sigma_m == pytest.approx(fresh.sigma_m, rel=0.1)  # the grid ends


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_the_flank_turned_to_the_camera_does_not_widen_the_face(mirror: float) -> None:
    """A car 2 m wide and 4.5 m long beside the camera: the points of its flank are seen beside its face.

    A point of the side at z behind the face is seen through the face's plane by the ray from the camera, at
    u = c + (s - c) depth / (depth + z) with s the side and c the camera; points grow rarer forward.
    """
    camera, side = -3.5, -1.0
    behind = 4.5 * (1.0 - np.sqrt(np.linspace(1.0, 0.02, 14)))
    seen = camera + (side - camera) * DEPTH_M / (DEPTH_M + behind)
    assert seen.min() < side - 0.4
    middle, _ = followed(mirror * np.concatenate([FACE_M, seen]), 4.0, camera_m=mirror * camera)
    assert mirror * middle == pytest.approx(0.0, abs=0.15)


def test_mirrored_points_give_the_mirrored_place() -> None:
    rng = stream(92, "mirrored")
    points, odds = rng.uniform(-1.8, 1.8, 30), rng.uniform(-4.0, 4.0, 30)
    right, _ = followed(points, odds, looks=5, camera_m=2.0)
    left, _ = followed(-points, odds, looks=5, camera_m=-2.0)
    assert right == pytest.approx(-left, abs=1e-9)
    assert right != 0.0
