"""The obstacle map: simulated road and box, and the smoothing in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import ROBUST
from flow_between import flow_between

from vpf_sim.perception.egomotion.ground_plane import ground_flow, past_image
from vpf_sim.perception.paper.obstacle_map import (
    cluster_labels,
    detect,
    on_obstacle,
    otsu,
    rasterise,
    smoothed_gradient,
)
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow

CAMERA = Camera()
MAP = replace(ROBUST.obstacle_map, sigma_px=80.0)
WINDOW_M = 0.555  # six frames at 5.55 m/s and 60 Hz


def drive_towards(distance_m: float | None, noise_px: float = 0.1) -> tuple[Flow, Bools]:
    """A road of 200 points, and a box of 60 at `distance_m` unless None; and which points are the box's."""
    rng = stream(5, f"road {distance_m}")
    # Even in the image, as corners are.
    road_px = np.column_stack([rng.uniform(0, 639, 200), rng.uniform(250, 479, 200)])
    depth = CAMERA.fy_px * CAMERA.height_m / (road_px[:, 1] - CAMERA.cy_px)
    right = depth * (road_px[:, 0] - CAMERA.cx_px) / CAMERA.fx_px
    scene = np.column_stack([CAMERA.forward_m + depth, right, np.zeros(200)])
    if distance_m is not None:
        box = np.column_stack(
            [np.full(60, distance_m + CAMERA.forward_m), rng.uniform(-0.9, 0.9, 60), rng.uniform(0.0, 1.5, 60)]
        )
        scene = np.concatenate([scene, box])
    count = len(scene)
    past = np.tile([-WINDOW_M, 0.0, 0.0], (count, 1))
    now = past_image(CAMERA, scene, np.zeros((count, 3)), np.zeros(3))
    before = past_image(CAMERA, scene, past, np.zeros(3)) + rng.normal(0.0, noise_px, (count, 2))
    return flow_between(now, before, past[0]), np.arange(count) >= 200


def f1(marked: Bools, truth: Bools) -> float:
    hits = np.count_nonzero(marked & truth)
    return 2.0 * hits / max(1, np.count_nonzero(marked) + np.count_nonzero(truth))


def test_straight_ahead_the_road_s_flow_has_the_known_form() -> None:
    """(p - p_FOE) d / (Z + d), Z = f h / (y - y_h)."""
    points = np.array([[100.0, 300.0], [500.0, 420.0]])
    depth = CAMERA.fy_px * CAMERA.height_m / (points[:, 1] - CAMERA.cy_px)
    foe = np.array([CAMERA.cx_px, CAMERA.cy_px])
    expected = (points - foe) * (WINDOW_M / (depth + WINDOW_M))[:, None]
    past = np.tile([-WINDOW_M, 0.0, 0.0], (2, 1))
    assert ground_flow(CAMERA, points, past, np.zeros(3)) == pytest.approx(expected, abs=1e-9)


def test_above_the_horizon_only_the_turn_moves_the_background() -> None:
    points = np.array([[200.0, 100.0], [400.0, 239.0]])
    straight = np.tile([-WINDOW_M, 0.0, 0.0], (2, 1))
    assert np.abs(ground_flow(CAMERA, points, straight, np.zeros(3))).max() < 0.12
    turned = np.tile([0.0, 0.0, -0.02], (2, 1))
    assert ground_flow(CAMERA, points, turned, np.zeros(3))[:, 0] == pytest.approx(-6.4, rel=0.2)


def test_the_road_s_flow_allows_for_a_pitched_camera() -> None:
    camera = Camera(pitch_rad=0.05)
    road = np.array([[6.0, 1.0, 0.0], [15.0, -2.0, 0.0]])
    past = np.tile([-0.5, 0.1, 0.01], (2, 1))
    now = past_image(camera, road, np.zeros((2, 3)), np.zeros(3))
    before = past_image(camera, road, past, np.zeros(3))
    assert ground_flow(camera, now, past, np.zeros(3)) == pytest.approx(now - before, abs=1e-9)


def test_otsu_splits_two_heaps_between_them() -> None:
    values = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(8.0, 9.0, 20)])
    assert otsu(values) == pytest.approx(4.5)
    assert otsu(np.empty(0)) == np.inf


def test_otsu_on_the_flow_takes_the_near_road_for_the_obstacle() -> None:
    flow, box = drive_towards(12.0)
    assert f1(on_obstacle(flow, CAMERA, replace(MAP, method="otsu_flow")), box) == 0.0


@pytest.mark.parametrize("distance_m", [6.0, 9.0])
def test_otsu_on_the_residual_finds_a_near_box(distance_m: float) -> None:
    flow, box = drive_towards(distance_m)
    assert f1(on_obstacle(flow, CAMERA, replace(MAP, method="otsu_residual")), box) > 0.8


@pytest.mark.parametrize(("distance_m", "recall"), [(6.0, 0.8), (9.0, 0.7), (12.0, 0.5)])
def test_the_absolute_test_finds_the_box_and_nothing_else(distance_m: float, recall: float) -> None:
    flow, box = drive_towards(distance_m)
    marked = on_obstacle(flow, CAMERA, replace(MAP, method="absolute"))
    assert np.count_nonzero(marked & ~box) <= 4
    assert np.count_nonzero(marked & box) > recall * np.count_nonzero(box)


def test_on_an_empty_road_only_the_absolute_test_finds_nothing() -> None:
    flow, _ = drive_towards(None)
    shares = {
        method: float(np.mean(on_obstacle(flow, CAMERA, replace(MAP, method=method))))  # type: ignore[arg-type]
        for method in ("otsu_flow", "otsu_residual", "absolute")
    }
    assert shares["absolute"] < 0.02
    assert min(shares["otsu_flow"], shares["otsu_residual"]) > 0.1


def test_a_point_marks_a_disc_of_its_cell() -> None:
    config = replace(MAP, disc_px=16.0)
    plane = rasterise(np.array([[320.0, 240.0]]), CAMERA, config)
    assert plane.shape == (60, 80)
    assert np.argwhere(plane).mean(axis=0) == pytest.approx([30.0, 40.0])
    assert plane.sum() == 13.0


def full_convolution(plane: Floats, sigma_cells: float) -> Floats:
    """G * O by its definition, O = 0 outside."""
    row, column = np.indices(plane.shape)
    smooth = np.zeros(plane.shape)
    for y, x in np.argwhere(plane):
        smooth += np.exp(-((row - y) ** 2 + (column - x) ** 2) / (2 * sigma_cells**2)) / (2 * np.pi * sigma_cells**2)
    return smooth


@pytest.mark.parametrize("sigma_px", [80.0, 320.0])
def test_the_gradient_is_that_of_the_smoothed_plane(sigma_px: float) -> None:
    config = replace(MAP, sigma_px=sigma_px)
    plane = np.zeros((60, 80))
    plane[25:33, 60:66] = 1.0
    smooth = full_convolution(plane, sigma_px / 8)
    gradient = smoothed_gradient(plane, config)
    differences = np.stack([np.gradient(smooth, axis=1), np.gradient(smooth, axis=0)]) / 8.0
    inner = np.s_[:, 1:-1, 1:-1]
    assert np.abs(gradient - differences)[inner].max() < 0.01 * np.abs(gradient).max()
    assert gradient[0, 30, 20] > 0.0 > gradient[0, 30, 78]  # it points to the obstacle


def test_the_printed_gaussian_is_sigma_times_the_proper_one() -> None:
    plane = np.zeros((60, 80))
    plane[30, 20] = 1.0
    printed = smoothed_gradient(plane, replace(MAP, sigma_px=320.0, normalisation="as_printed"))
    proper = smoothed_gradient(plane, replace(MAP, sigma_px=320.0))
    assert printed == pytest.approx(320.0 * proper)


def test_clusters_are_the_connected_parts_of_the_plane() -> None:
    flow, _ = drive_towards(9.0, noise_px=0.0)
    found = detect(flow, CAMERA, MAP)
    labels = cluster_labels(found, flow)
    assert np.array_equal(labels >= 0, found.on_obstacle)
    assert set(labels[found.on_obstacle]) == {0}


def test_lone_points_can_be_set_aside() -> None:
    lone, _ = drive_towards(9.0)
    lone.displacement_px[0] += 30.0
    assert detect(lone, CAMERA, replace(MAP, min_points=1)).on_obstacle[0]
    strict = detect(lone, CAMERA, replace(MAP, min_points=4))
    assert not strict.on_obstacle[0]
    assert strict.on_obstacle.any()


def test_an_empty_flow_gives_an_empty_map() -> None:
    flow, _ = drive_towards(None)
    empty = flow.select(np.arange(0))
    for method in ("otsu_flow", "otsu_residual", "absolute"):
        found = detect(empty, CAMERA, replace(MAP, method=method))  # type: ignore[arg-type]
        assert not found.plane.any()
        assert not found.gradient.any()
