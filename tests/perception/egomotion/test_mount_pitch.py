"""Where the camera looks, told by the road's lines: roads drawn by a camera that is mounted a known angle askew."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from driver_settings import ROBUST
from flow_between import flow_between
from road_picture import RoadPicture

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.paper_pipeline import FrameTrackers
from vpf_sim.drivers.perceiver import Perceiver
from vpf_sim.geometry import project
from vpf_sim.perception.egomotion.camera_pitch import PitchEstimator
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.egomotion.mount_pitch import MountPitch
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.model import PITCH as PITCH_STATE
from vpf_sim.perception.road.model import seen_lines, seen_places
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow, RoadEdges, VehicleModel

CAMERA = Camera()
assert ROBUST.camera_pitch is not None
PITCH, MOUNTING = ROBUST.camera_pitch, ROBUST.camera_pitch.mounting
SPEED_MPS, RATE_HZ = 5.55, 20.0
BEND = np.array([1.2, 0.1, 0.004, 0.006, 0.008, 0.01, 3.5, 0.006, 0.0, 0.0])


def drive(down_deg: float, curvature: float, frames: int = 10) -> tuple[RoadEdgeTracker, float, RoadEdges]:
    """The tracker after some frames, the mounting that is believed, and the edges."""
    picture = RoadPicture(replace(CAMERA, pitch_rad=radians(down_deg)), curvature)
    tracker, mounting = RoadEdgeTracker(CAMERA, ROBUST.road_edges, RATE_HZ), MountPitch(MOUNTING)
    for i in range(frames):
        pose = picture.pose(i * SPEED_MPS / RATE_HZ, 1.3, 0.0)
        frame = picture.draw(pose, i)
        edges = tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
        if tracker.pitch is not None:
            mounting.update(*tracker.pitch, i / RATE_HZ)
    return tracker, mounting.pitch_rad, edges


@pytest.mark.parametrize("pitch_rad", [-0.008, 0.0, 0.011])
def test_lines_are_seen_where_an_askew_camera_shows_them(pitch_rad: float) -> None:
    """Places of the lines, projected by the camera as it is, and read off by the camera as it is believed to be."""
    forward, numbers = np.arange(4.0, 28.0, 3.0), np.array([-2.0, 0.0, 1.5])
    state, level = BEND.copy(), BEND.copy()
    state[PITCH_STATE], level[PITCH_STATE] = pitch_rad, 0.0
    right, _, reached = seen_lines(state, numbers, forward, CAMERA)
    assert reached.all()
    row_px = project(CAMERA, np.stack([forward, 0.0 * forward, 0.0 * forward], axis=-1))[:, 1]
    ahead: Floats = np.linspace(3.0, 45.0, 4000)
    for seen, place in zip(right, seen_places(level, numbers, ahead, CAMERA)[0], strict=True):
        pixels = project(replace(CAMERA, pitch_rad=pitch_rad), np.stack([ahead, place, 0.0 * ahead], axis=-1))
        column_px = np.interp(-row_px, -pixels[:, 1], pixels[:, 0])
        expected = (column_px - CAMERA.cx_px) / CAMERA.fx_px * (forward - CAMERA.forward_m)
        assert np.abs(seen - expected).max() < 5e-3


@pytest.mark.parametrize(("down_deg", "curvature"), [(-0.6, 0.01), (-0.2, 0.0), (0.3, 0.01), (0.8, 0.0)])
def test_the_road_tells_where_the_camera_looks(down_deg: float, curvature: float) -> None:
    tracker, mounted, edges = drive(down_deg, curvature)
    assert tracker.pitch is not None
    found, sigma = tracker.pitch
    assert np.degrees(found) == pytest.approx(down_deg, abs=0.04)
    assert np.degrees(sigma) < 0.03
    assert np.degrees(mounted) == pytest.approx(down_deg, abs=0.05)
    assert edges.right_m == pytest.approx(5.7, abs=0.06)
    assert edges.left_m == pytest.approx(-8.3, abs=0.06)


def test_a_camera_that_looks_where_it_should_is_left_alone() -> None:
    _, mounted, _ = drive(0.0, 0.008)
    assert mounted == 0.0


def test_a_road_without_lines_does_not_tell() -> None:
    tracker = RoadEdgeTracker(CAMERA, ROBUST.road_edges, RATE_HZ)
    grain = stream(4, "grain").integers(60, 140, (CAMERA.height_px, CAMERA.width_px), np.uint8)
    frame = np.repeat(grain[..., None], 3, axis=2)
    for i in range(4):
        tracker.update(frame, grain, np.array([0.3 * i, 0.0, 0.0]), SPEED_MPS, 0.0, None)
        assert tracker.pitch is None


def test_looks_are_averaged_and_believed_in_steps() -> None:
    random, pitch = stream(5, "looks"), MountPitch(MOUNTING)
    believed = [0.0]
    for i in range(400):
        pitch.update(0.007 + 0.0015 * float(random.standard_normal()), 0.0002, 0.05 * i)
        believed.append(pitch.pitch_rad)
    assert pitch.pitch_rad == pytest.approx(0.007, abs=0.0008)
    steps = np.abs(np.diff(believed))
    assert np.count_nonzero(steps) < 40
    assert steps[steps > 0.0].min() >= MOUNTING.step_rad


def test_next_to_nothing_is_not_believed() -> None:
    random, pitch = stream(6, "looks"), MountPitch(MOUNTING)
    for i in range(200):
        pitch.update(0.0002 + 0.0002 * float(random.standard_normal()), 0.0002, 0.05 * i)
        assert pitch.pitch_rad == 0.0
    for i in range(200, 500):
        pitch.update(0.002 if i < 300 else 0.0, 0.0002, 0.05 * i)
        assert i != 299 or pitch.pitch_rad > 0.001
    assert pitch.pitch_rad == 0.0


def test_the_flow_becomes_that_of_a_camera_that_looks_where_it_should() -> None:
    random, count = stream(6, "points"), 60
    place = np.column_stack([random.uniform(5, 40, count), random.uniform(-6, 6, count), random.uniform(0, 2, count)])
    later = place - [0.5, 0.0, 0.0]

    def flow(camera: Camera) -> Flow:
        return flow_between(project(camera, later), project(camera, place), pose=[0.5, 0.0, 0.0])

    estimator = PitchEstimator(CAMERA, PITCH, 60.0)
    for i in range(40):
        estimator.update_mount_pitch(0.006, 1e-4, 0.05 * i)
    foe = Expansion(CAMERA.cx_px, CAMERA.cy_px - 0.006 * CAMERA.fy_px, np.eye(2), np.empty(0, np.bool_), 1.0)
    steady, ideal = estimator.update(flow(replace(CAMERA, pitch_rad=0.006)), foe), flow(CAMERA)
    assert estimator.mounted_rad == pytest.approx(0.006, abs=5e-4)
    for found, true in ((steady.points_px, ideal.points_px), (steady.first_px, ideal.first_px)):
        assert np.abs(found - true).max() < 0.25
    assert np.abs(steady.displacement_px - ideal.displacement_px).max() < 0.05


def test_the_planner_takes_it_out_of_what_it_sees() -> None:
    picture = RoadPicture(replace(CAMERA, pitch_rad=radians(0.6)))
    setup = DriverSetup(CAMERA, VehicleModel(), 20.0, SPEED_MPS, (200.0, 0.0), 1)
    trackers = FrameTrackers.create(setup, ROBUST, 20.0)
    perceiver = Perceiver(setup, ROBUST, trackers)
    for i in range(4):
        pose = picture.pose(i * SPEED_MPS / 20.0, 1.3, 0.0)
        x, y, yaw = pose.tolist()
        seen = perceiver.perceive(Observation(picture.draw(pose, i), i / 20.0, x, y, yaw, SPEED_MPS, 0.0, (200.0, 0.0)))
    assert trackers.pitch is not None
    assert np.degrees(trackers.pitch.mounted_rad) == pytest.approx(0.6, abs=0.05)
    assert seen.road.right_m == pytest.approx(5.7, abs=0.06)
    assert len(seen.obstacles) == 0
