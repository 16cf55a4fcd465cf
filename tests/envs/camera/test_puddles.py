"""Puddles are fixed to the world and differ between seeds."""

from itertools import pairwise

import numpy as np
from highway_scenes import WIDTH_M, bent_road, straight_road
from numpy.typing import NDArray

from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.rain.puddles import CELL_M, CELLS, ROAD, HeightMap, Puddles, covered_table
from vpf_sim.types import Floats

SHAPES = lane_shapes(straight_road())


def height_map(puddles: Puddles, x: float, y: float = 5.0, yaw: float = 0.0) -> HeightMap:
    return puddles.height_map(x, y, yaw)


def sampled(laid: HeightMap, points: Floats) -> NDArray[np.int64]:
    """Depths of a raster at points (n, 2) of the world, to the nearest cell."""
    column, row = np.rint((points - laid.corner_m) / CELL_M).astype(int).T
    return laid.depths[row, column].astype(int)


def on_road(count: int, first: float, last: float) -> Floats:
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(first, last, count), rng.uniform(-1.5, 3.0 * WIDTH_M + 1.5, count)])


def test_puddles_stay_in_their_places_while_the_camera_moves() -> None:
    puddles = Puddles(SHAPES, 1)
    points = on_road(3000, 70.0, 120.0)
    before, after = height_map(puddles, 20.0), height_map(puddles, 47.0, y=8.0, yaw=0.3)
    assert not np.array_equal(before.corner_m, after.corner_m)
    assert np.array_equal(sampled(before, points), sampled(after, points))


def test_height_map_depends_on_the_place_alone() -> None:
    """It reaches from the camera's feet to where reflections matter, and is made once for near places."""
    puddles = Puddles(SHAPES, 1)
    for x in np.arange(20.0, 120.0, 7.0):
        laid = height_map(puddles, float(x), yaw=0.1 * x)
        assert np.array_equal(laid.depths, height_map(Puddles(SHAPES, 1), float(x), yaw=0.1 * x).depths)
        ahead = np.array([x, 5.0]) + np.outer([0.0, 110.0], [np.cos(0.1 * x), np.sin(0.1 * x)])
        assert np.all((ahead >= laid.corner_m) & (ahead <= laid.corner_m + CELLS * CELL_M))
    assert height_map(puddles, 20.0) is height_map(puddles, 22.0)


def test_seeds_have_their_own_puddles() -> None:
    one, again, other = (height_map(Puddles(SHAPES, seed), 20.0).depths for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    covered = covered_table(0.6)
    a, b = covered[one] > 128, covered[other] > 128
    assert (a & b).sum() < 0.5 * a.sum()


def test_more_deposits_cover_more_of_the_road_and_all_that_less_of_them_covered() -> None:
    depths = height_map(Puddles(SHAPES, 1), 20.0).depths
    on = depths > ROAD // 2
    covered = [covered_table(puddles)[depths] > 128 for puddles in (0.0, 0.3, 0.5, 0.6, 0.9)]
    shares = [float(mask[on].mean()) for mask in covered]
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert 0.05 < shares[2] < 0.25
    assert 0.25 < shares[4] < 0.6
    assert all(np.all(more[less]) for less, more in pairwise(covered))


def test_puddles_lie_in_the_wheel_tracks_and_not_on_the_grass() -> None:
    laid = height_map(Puddles(SHAPES, 1), 20.0)
    x = np.arange(40.0, 110.0, 0.2)
    covered = covered_table(0.5)

    def share(y: float) -> float:
        return float((covered[sampled(laid, np.column_stack([x, np.full(len(x), y)]))] > 128).mean())

    tracks = np.mean([share(lane * WIDTH_M + side * 0.78) for lane in range(4) for side in (-1, 1)])
    middles = np.mean([share(lane * WIDTH_M) for lane in range(4)])
    assert tracks > 3.0 * middles
    assert share(3.5 * WIDTH_M + 1.5) == 0.0


def test_puddles_follow_a_bend() -> None:
    laid = height_map(Puddles(lane_shapes(bent_road()), 1), 5.0, y=0.0)
    rows, columns = np.nonzero(covered_table(0.6)[laid.depths] > 128)
    x, y = laid.corner_m[0] + CELL_M * columns, laid.corner_m[1] + CELL_M * rows
    bend = (x > 5.0) & (x < 90.0) & (y < 95.0)
    radius = np.hypot(x[bend], y[bend] - 100.0)
    assert bend.sum() > 300
    assert np.all(np.abs(radius - 100.0) < 2.0 * WIDTH_M + 0.8)
    assert laid.depths.shape == (CELLS, CELLS)
