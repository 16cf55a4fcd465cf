"""The place across of a body's face, from made-up points whose truth is known in closed form."""

import numpy as np
import pytest

from vpf_sim.perception.obstacles.moving.extent import Sides, TrackExtentConfig
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

CONFIG = TrackExtentConfig()
DEPTH_M, LOOK_S = 10.0, 0.05
FACE_M = np.linspace(-0.95, 0.95, 24)


def followed(
    points_m: Floats, odds: Floats | float, looks: int = 40, middle_m: float = 0.0, camera_m: float = 0.0
) -> tuple[float, Sides]:
    """m, the middle that points `points_m` (N,) right of the first middle lead to, with the belief after so many looks.

    The camera is `camera_m` right of the first middle too.
    """
    sides = Sides(CONFIG)
    for _ in range(looks):
        sides.predict(LOOK_S)
        across = points_m - middle_m
        middle_m += sides.look(across, np.broadcast_to(odds, across.shape), camera_m - middle_m, DEPTH_M, LOOK_S)
    return middle_m, sides


@pytest.mark.parametrize("true_m", [-0.8, 0.0, 0.5])
def test_points_all_over_a_face_tell_its_middle_and_width(true_m: float) -> None:
    middle, sides = followed(true_m + FACE_M, 4.0)
    assert middle == pytest.approx(true_m, abs=0.12)
    assert sides.half_m == pytest.approx(0.95, abs=0.12)
    assert sides.sigma_m < 0.25


def test_points_narrower_than_a_body_bound_its_place_and_do_not_draw_its_middle_to_them() -> None:
    """A cluster .08 m wide at .7 m lies in a body at 0: half a second's low-pass of .2 s would move it by .64 m."""
    sides, middle, cluster = Sides(CONFIG), 0.0, 0.7 + np.linspace(-0.04, 0.04, 12)
    for points in [FACE_M] * 20 + [cluster] * 10:
        sides.predict(LOOK_S)
        middle += sides.look(points - middle, np.full(len(points), 4.0), -middle, DEPTH_M, LOOK_S)
    assert abs(middle) < 0.1
    unknown, free = followed(cluster, 4.0)
    assert abs(unknown) < 0.7 - 0.15
    assert free.sigma_m > 0.3, "anywhere in an interval"


def test_points_beyond_a_side_move_the_body_until_they_lie_in_it() -> None:
    cluster = 1.6 + np.linspace(-0.04, 0.04, 12)
    middle, sides = followed(cluster, 4.0)
    assert 1.6 - sides.half_m - 0.3 < middle < 1.3


def test_a_known_place_is_kept_against_few_points_that_slip_beside_it() -> None:
    """Paint beside a body that is seen all over: its points are strays, however many of them share a window."""
    paint = 1.7 + np.linspace(-0.04, 0.04, 12)
    both = np.concatenate([FACE_M, paint])
    middle, _ = followed(both, 4.0)
    assert abs(middle) < 0.15


def test_what_stands_behind_and_is_seen_beside_bounds_a_body_from_outside() -> None:
    """Only the right half of a body at 0 has points; the wall behind it is seen up to its right side."""
    half = np.linspace(0.0, 0.95, 12)
    wall = np.linspace(1.05, 2.4, 14)
    odds = np.concatenate([np.full(12, 4.0), np.full(14, -4.0)])
    drawn, _ = followed(half, 4.0, middle_m=0.6)
    held, _ = followed(np.concatenate([half, wall]), odds, middle_m=0.6)
    assert abs(held) < 0.2
    assert drawn > 0.35


def test_points_of_neither_reading_say_nothing() -> None:
    rng = stream(91, "neither")
    middle, sides = followed(rng.uniform(0.5, 2.4, 40), 0.0, looks=4)
    fresh = Sides(CONFIG)
    for _ in range(4):
        fresh.predict(LOOK_S)
    assert middle == pytest.approx(0.0, abs=1e-9)
    assert sides.sigma_m == pytest.approx(fresh.sigma_m, rel=0.1)  # the grid ends


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_the_side_turned_to_us_is_not_taken_for_the_face(mirror: float) -> None:
    """A car 2 m wide and 4.5 m long to one side of us: the points of its side are seen beside its face.

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


def test_widths_are_in_order() -> None:
    with pytest.raises(ValueError, match=r"narrowest_m: expected 0 < it < widest_m = 2\.6, got 3\.0"):
        TrackExtentConfig(narrowest_m=3.0)
