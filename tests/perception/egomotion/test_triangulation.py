"""Depth and height of simulated tracks, and how sure they are."""

from dataclasses import replace

import numpy as np
import pytest
from flow_between import flow_between
from tracked_points import CAMERA, RATE_HZ, Drive

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.egomotion.triangulation import information, triangulate
from vpf_sim.seeding import stream


def test_depth_and_height_are_exact_without_noise() -> None:
    drive = Drive(np.array([[30.0, 1.0, 0.7], [25.0, -2.0, 0.0], [28.0, 0.5, 2.0]]), 0.0, curvature_per_m=0.004)
    for frame in range(40):
        flow = drive.flow(frame)
    points = triangulate(flow, CAMERA, 11, flow.age_frames / RATE_HZ, NoiseModel())
    place = vehicle_from_world(drive.scene[:, :2], flow.pose)
    assert points.depth_m == pytest.approx(place[:, 0] - CAMERA.forward_m, abs=1e-6)
    assert points.right_m == pytest.approx(place[:, 1], abs=1e-6)
    assert points.height_m == pytest.approx(drive.scene[:, 2], abs=1e-6)
    assert points.chi2 == pytest.approx(0.0, abs=1e-6)
    assert points.chi2_ground[1] == pytest.approx(0.0, abs=1e-6)
    assert points.chi2_ground[0] > 5.0
    assert np.isinf(points.chi2_ground[2])  # above the horizon there is no road


def test_the_sigma_of_the_depth_is_that_of_the_errors() -> None:
    """chi2 and z-scores of many noisy points: the noise model is given the noise that was added."""
    rng = stream(24, "sigma")
    scene = np.column_stack([np.full(400, 20.0), rng.uniform(-6.0, 4.0, 400), rng.uniform(0.2, 1.0, 400)])
    drive = Drive(scene, noise_px=0.1)
    for frame in range(31):
        flow = drive.flow(frame)
    # Both sightings are noisy, the model speaks of their difference: floor^2 growth = 2 x 0.1^2.
    points = triangulate(flow, CAMERA, 11, np.zeros(len(flow)), NoiseModel(0.0, 0.1 * np.sqrt(2.0), pitch_rad=0.0))
    error = points.depth_m - (20.0 - flow.pose[0] - CAMERA.forward_m)
    assert np.std(error / points.sigma_m) == pytest.approx(1.0, abs=0.25)
    assert np.mean(points.chi2) == pytest.approx(1.0, abs=0.3)  # two equations, one unknown


def test_an_edge_gives_no_information_along_itself() -> None:
    direction, along = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    tensor = 400.0 * np.outer(direction, direction) + 0.1 * np.eye(2)
    one = replace(flow_between(np.zeros((1, 2)), np.zeros((1, 2))), structure=tensor[None])
    weight = information(one, 11, np.zeros(1), NoiseModel())[0]
    assert along @ weight @ along < 1e-2 * (direction @ weight @ direction)
