"""Frames, angles and projection against closed forms."""

from math import atan, pi, radians, tan

import numpy as np
import pytest

from vpf_sim import geometry
from vpf_sim.types import Camera

TILTED = Camera(width_px=800, fx_px=500.0, fy_px=480.0, cx_px=400.0, cy_px=200.0, height_m=1.7, pitch_rad=0.05)


@pytest.mark.parametrize(("angle", "expected"), [(radians(358), radians(-2)), (pi, -pi), (-pi, -pi), (0.3, 0.3)])
def test_wrap_angle(angle: float, expected: float) -> None:
    assert geometry.wrap_angle(angle) == pytest.approx(expected)


def test_a_point_to_the_right_is_to_the_right_at_any_yaw() -> None:
    for yaw in np.linspace(-3.0, 3.0, 7):
        pose = np.array([12.0, -7.0, yaw])
        world = pose[:2] + 5.0 * np.array([np.cos(yaw), np.sin(yaw)]) + 2.0 * np.array([-np.sin(yaw), np.cos(yaw)])
        assert geometry.vehicle_from_world(world, pose) == pytest.approx([5.0, 2.0])
        assert geometry.world_from_vehicle(np.array([5.0, 2.0]), pose) == pytest.approx(world)


def test_projection_of_a_level_camera_is_similar_triangles() -> None:
    camera = Camera()
    image = geometry.project(camera, np.array([camera.forward_m + 10.0, 2.0, 0.0]))
    assert image == pytest.approx([camera.cx_px + 32.0 * 2.0, camera.cy_px + 32.0 * 1.4])


def test_pitch_moves_the_horizon_up_by_its_tangent() -> None:
    far = geometry.project(TILTED, np.array([1e9, 0.0, 0.0]))
    assert far[1] == pytest.approx(TILTED.cy_px - TILTED.fy_px * tan(0.05), abs=1e-4)


@pytest.mark.parametrize("camera", [Camera(), TILTED])
def test_ground_from_pixels_inverts_the_projection(camera: Camera) -> None:
    ground = np.array([[4.0, -1.0], [12.0, 3.0], [40.0, -8.0]])
    pixels = geometry.project(camera, np.column_stack([ground, np.zeros(3)]))
    assert geometry.ground_from_pixels(camera, pixels) == pytest.approx(ground)


def test_no_ground_above_the_horizon_and_no_image_behind_the_camera() -> None:
    assert np.isnan(geometry.ground_from_pixels(Camera(), np.array([320.0, 100.0]))).all()
    assert np.isnan(geometry.project(Camera(), np.array([-3.0, 0.0, 0.0]))).all()


def test_rotation_flow_is_the_image_of_far_points_under_a_turn() -> None:
    """Points a million kilometres away move by the turn alone: project them before and after it."""
    camera, turn = Camera(), 0.07
    before = np.array([[9e8, -4e8, 1e8], [9e8, 2e8, -3e8], [9e8, 0.0, 0.0]])
    after = np.column_stack([before[:, :2] @ geometry.rotation(turn), before[:, 2]])
    start, end = geometry.project(camera, before), geometry.project(camera, after)
    assert geometry.rotation_flow(camera, end, np.full(3, turn)) == pytest.approx(end - start, abs=1e-4)


def test_turning_right_moves_the_picture_left() -> None:
    centre = np.array([[Camera().cx_px, Camera().cy_px]])
    flow = geometry.rotation_flow(Camera(), centre, np.array([atan(0.1)]))
    assert flow[0] == pytest.approx([-32.0, 0.0])
