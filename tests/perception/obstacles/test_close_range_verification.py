"""Walking up to an obstacle that was reported: road in its place refutes it, a flat pallet or bare paint does not."""

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest
from driver_settings import section

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.obstacles.close_range_verification import CloseRangeVerifier
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image, Obstacles

CAMERA, CONFIG = Camera(), section("close_range_verification")
FACE_M, LEFT_M, RIGHT_M, PALLET_M = 10.0, -0.8, 0.8, 0.15  # in the world
GRAIN_M = 0.04


def _noise(name: str) -> Floats:
    """(600, 400) grey levels of a grain, on squares of GRAIN_M."""
    return np.asarray(128.0 + 20.0 * stream(3, name).standard_normal((600, 400)), np.float64)


ROAD, PALLET = _noise("road"), _noise("pallet")


def _rays() -> tuple[Floats, Floats]:
    """(H, W) tangents to the right and down of each pixel."""
    x, y = np.meshgrid(np.arange(CAMERA.width_px), np.arange(CAMERA.height_px))
    return (x - CAMERA.cx_px) / CAMERA.fx_px, (y - CAMERA.cy_px) / CAMERA.fy_px


def _sampled(grain: Floats, height_m: float, x_m: float) -> tuple[Floats, Floats, Floats]:
    """(H, W) what a level plane shows to the car at (x, 0), and where in the world it is met, ahead and across."""
    right, down = _rays()
    depth = (CAMERA.height_m - height_m) / np.maximum(down, 0.02)
    forward, across = x_m + CAMERA.forward_m + depth, depth * right
    column, row = (across / GRAIN_M + 200.0).astype(np.float32), (forward / GRAIN_M).astype(np.float32)
    return cv2.remap(grain, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP), forward, across


def empty(x_m: float) -> Image:
    return np.clip(_sampled(ROAD, 0.0, x_m)[0], 0.0, 255.0).astype(np.uint8)


def bare(x_m: float) -> Image:
    """Dark paint fills the view."""
    return np.full((CAMERA.height_px, CAMERA.width_px), round(40.0 + 0.0 * x_m), np.uint8)


def pallet(x_m: float, left_m: float = LEFT_M, right_m: float = RIGHT_M) -> Image:
    road = _sampled(ROAD, 0.0, x_m)[0]
    top, forward, across = _sampled(PALLET, PALLET_M, x_m)
    on = (forward > FACE_M) & (forward < FACE_M + 1.2) & (across > left_m) & (across < right_m)
    return np.clip(np.where(on, top, road), 0.0, 255.0).astype(np.uint8)


def reported(x_m: float, name: int, face_m: float = FACE_M, side_m: float = RIGHT_M) -> Obstacles:
    place = vehicle_from_world(np.array([[face_m, 0.0]]), np.array([x_m, 0.0, 0.0]))[0]
    one = [np.array([value]) for value in (place[0], -side_m, side_m, 0.3, np.inf)]
    return Obstacles(*one, identity=np.array([name]))


def walk(
    view: Callable[[float], Image], speed_mps: float = 1.0, face_m: float = FACE_M
) -> tuple[CloseRangeVerifier, int]:
    """Walk from 6 m before the face to 3.5 m; the verifier, and how many obstacles are left."""
    verifier, left = CloseRangeVerifier(CAMERA, CONFIG), 1
    for x in np.arange(FACE_M - 6.0, FACE_M - 3.5, 0.05):
        left = len(verifier.update(view(float(x)), np.array([x, 0.0, 0.0]), reported(float(x), 7, face_m), speed_mps))
    return verifier, left


def test_an_obstacle_on_visible_road_is_rejected() -> None:
    assert walk(empty)[1] == 0


@pytest.mark.parametrize("view", [pallet, bare])
def test_a_pallet_and_dark_paint_stay(view: Callable[[float], Image]) -> None:
    assert walk(view)[1] == 1


@pytest.mark.parametrize("side_m", [1.3, 1.8])
def test_an_obstacle_reported_too_wide_stays(side_m: float) -> None:
    verifier, left = CloseRangeVerifier(CAMERA, CONFIG), 1
    for x in np.arange(FACE_M - 6.0, FACE_M - 3.5, 0.05).tolist():
        reported_wide = reported(x, 7, side_m=side_m)
        left = len(verifier.update(pallet(x, 0.1, 0.6), np.array([x, 0.0, 0.0]), reported_wide, 1.0))
    assert left == 1


def test_each_part_of_an_obstacle_is_verified() -> None:
    verifier, left = CloseRangeVerifier(CAMERA, CONFIG), 2
    for x in np.arange(FACE_M - 6.0, FACE_M - 3.5, 0.05).tolist():
        near, far = reported(x, 7), reported(x, 7, FACE_M + 1.5)
        both = Obstacles(*(np.concatenate([getattr(near, name), getattr(far, name)]) for name in Obstacles.__slots__))
        left = len(verifier.update(empty(x), np.array([x, 0.0, 0.0]), both, 1.0))
    assert left == 0


@pytest.mark.parametrize("near_m", [0.6, 1.0])
def test_an_obstacle_reported_too_near_stays(near_m: float) -> None:
    """From afar its upper edge is seen farther back by another 0.6 m, and what is reported of it lies on the road."""
    verifier = CloseRangeVerifier(CAMERA, CONFIG)
    for x in np.arange(FACE_M - 7.0, FACE_M - 3.0, 0.05).tolist():
        assert len(verifier.update(pallet(x), np.array([x, 0.0, 0.0]), reported(x, 7, FACE_M - near_m), 1.0)) == 1


@pytest.mark.parametrize(("middle_m", "left"), [(1.0, 0), (-1.0, 0), (3.0, 1), (-3.0, 1)])
def test_far_aside_nothing_is_verified(middle_m: float, left: int) -> None:
    """There the place, away from the camera, leads past what stands: road says nothing."""
    verifier, there = CloseRangeVerifier(CAMERA, CONFIG), 1
    for x in np.arange(FACE_M - 6.0, FACE_M - 3.5, 0.05):
        one = reported(float(x), 7)
        one = replace(one, left_m=one.left_m + middle_m, right_m=one.right_m + middle_m)
        there = len(verifier.update(empty(float(x)), np.array([x, 0.0, 0.0]), one, 1.0))
    assert there == left


def test_at_speed_nothing_is_verified() -> None:
    assert walk(empty, speed_mps=CONFIG.slow_mps)[1] == 1


def test_a_rejected_obstacle_that_is_reported_elsewhere_is_another() -> None:
    verifier, _ = walk(empty)
    x, pose = FACE_M - 3.5, np.array([FACE_M - 3.5, 0.0, 0.0])
    assert len(verifier.update(empty(x), pose, reported(x, 7), 5.0)) == 0
    for speed_mps in (1.0, 5.0):
        assert (
            len(verifier.update(empty(x), pose, reported(x, 7), speed_mps, lambda obstacles: obstacles.identity == 7))
            == 1
        )
    assert len(verifier.update(empty(x), pose, reported(x, 8), 5.0)) == 1
    assert len(verifier.update(empty(x), pose, reported(x, 7, FACE_M + 2.0 * CONFIG.moved_m), 5.0)) == 1


def test_half_of_a_narrow_obstacle_is_verified() -> None:
    assert [CONFIG.across_m(width) for width in (0.15, 2.0)] == pytest.approx([0.075, 1.8])


POST_M, POST_WIDTH_M, POST_HEIGHT_M = -1.9, 0.35, 0.75  # its middle, beside our way


def post(x_m: float) -> Image:
    """A narrow obstacle that stands beside our way: road is seen past it on both sides."""
    road = _sampled(ROAD, 0.0, x_m)[0]
    right, down = _rays()
    depth = FACE_M - x_m - CAMERA.forward_m
    across, height = depth * right, CAMERA.height_m - depth * down
    on = (np.abs(across - POST_M) < 0.5 * POST_WIDTH_M) & (height > 0.0) & (height < POST_HEIGHT_M)
    column, row = (across / GRAIN_M + 200.0).astype(np.float32), (height / GRAIN_M).astype(np.float32)
    grain = cv2.remap(PALLET, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return np.clip(np.where(on, grain, road), 0.0, 255.0).astype(np.uint8)


def test_a_narrow_obstacle_beside_the_path_stays() -> None:
    verifier = CloseRangeVerifier(CAMERA, CONFIG)
    for x in np.arange(FACE_M - 7.0, FACE_M - 3.5, 0.05):
        ahead = np.array([FACE_M - float(x) + 0.1])
        sides = (np.array([POST_M - 0.1]), np.array([POST_M + 0.1]))
        obstacles = Obstacles(ahead, *sides, np.array([0.3]), np.array([np.inf]), identity=np.array([7]))
        assert len(verifier.update(post(float(x)), np.array([x, 0.0, 0.0]), obstacles, 1.0)) == 1


def plain(x_m: float, place_m: float, paint: Callable[[Floats, Floats], Floats]) -> Image:
    """A plain obstacle at `place_m`: `paint` gives its grey level by place across and height, nan beside it."""
    right, down = _rays()
    depth = FACE_M - x_m - CAMERA.forward_m
    across, height = depth * right - place_m, CAMERA.height_m - depth * down
    grey = np.where((height > 0.0) & (height < 0.75), paint(across, height), np.nan)
    return np.clip(np.where(np.isnan(grey), _sampled(ROAD, 0.0, x_m)[0], grey), 0.0, 255.0).astype(np.uint8)


def cone(across_m: Floats, height_m: Floats) -> Floats:
    """On a dark plate; past it, upwards more and more, the road is seen."""
    half = np.where(height_m < 0.05, 0.2, 0.15 - 0.16 * height_m)
    return np.where(np.abs(across_m) < half, np.where(height_m < 0.05, 30.0, 130.0), np.nan)


def leaning(across_m: Floats, height_m: Floats) -> Floats:
    """Two colours that meet in a line along which the camera comes nearer: it agrees with any shift."""
    return np.where(np.abs(across_m) < 0.4, np.where(across_m > height_m - 0.25, 200.0, 60.0), np.nan)


@pytest.mark.parametrize(("place_m", "half_m", "paint"), [(-1.9, 0.2, cone), (1.2, 0.2, cone), (-1.2, 0.4, leaning)])
def test_a_plain_obstacle_of_which_only_the_outline_is_visible_stays(
    place_m: float, half_m: float, paint: Callable[[Floats, Floats], Floats]
) -> None:
    verifier, one = CloseRangeVerifier(CAMERA, CONFIG), np.ones(1)
    for x in np.arange(FACE_M - 7.0, FACE_M - 2.8, 0.05).tolist():
        sides = (place_m - half_m) * one, (place_m + half_m) * one
        body = Obstacles((FACE_M - x) * one, *sides, 0.1 * one, one, np.array([7]))
        assert len(verifier.update(plain(x, place_m, paint), np.array([x, 0.0, 0.0]), body, 1.0)) == 1
