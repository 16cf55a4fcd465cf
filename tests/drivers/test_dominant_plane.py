"""The driver by the dominant plane: which points are on it, where it steers, that it stops and passes."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.dominant_plane import AGREEMENT_PX, DominantPlaneDriver, PlaneDetector, plane_motion, potential
from vpf_sim.evaluation.episode import episode
from vpf_sim.geometry import ground_from_pixels, project
from vpf_sim.types import Bools, Camera, Floats, Image, VehicleModel

CAMERA = Camera()
STEP_M = 0.28  # in a frame at 20 km/h and 20 Hz
NEAR_M, ASIDE_M, HIGH_M = 8.0, 1.2, 1.3  # of the box: its face in the last frame, half its width, its height


def grid() -> Floats:
    """(N, 2) px on the road ahead."""
    return np.stack(np.meshgrid(np.arange(10.0, 640.0, 20.0), np.arange(260.0, 470.0, 10.0)), axis=-1).reshape(-1, 2)


def in_box(points_px: Floats) -> Bools:
    """Which points of the last frame show the face of the box."""
    corners = project(CAMERA, np.array([(NEAR_M, -ASIDE_M, HIGH_M), (NEAR_M, ASIDE_M, 0.0)]))
    inside: Bools = np.all((points_px > corners[0]) & (points_px < corners[1]), axis=1)
    return inside


def before(points_px: Floats, back_m: float, boxed: bool = True) -> Floats:
    """Where the points of a flat road, with a box on it, were from a camera that was so much farther back."""
    ground_m = ground_from_pixels(CAMERA, points_px)
    scene = np.column_stack([ground_m, np.zeros(len(points_px))])
    box, depth_m = in_box(points_px) & boxed, NEAR_M - CAMERA.forward_m
    offset = (points_px - (CAMERA.cx_px, CAMERA.cy_px)) * depth_m / CAMERA.fx_px
    scene[box] = np.column_stack([np.full(len(offset), NEAR_M), offset[:, 0], CAMERA.height_m - offset[:, 1]])[box]
    return project(CAMERA, scene + np.array([back_m, 0.0, 0.0]))


def test_the_plane_is_the_road_and_the_box_is_not_on_it() -> None:
    points_px = grid()
    found = plane_motion(points_px, before(points_px, 4.0 * STEP_M))
    assert found is not None
    motion, members = found
    box = in_box(points_px)
    assert 0.02 < box.mean() < 0.5, "there is a box, and the road is larger"
    road_px = before(points_px, 4.0 * STEP_M)[~box]
    moved = cv2.perspectiveTransform(points_px[~box].reshape(-1, 1, 2), motion).reshape(-1, 2)
    assert np.abs(moved - road_px).max() < 0.05
    assert members[~box].all()
    off_px = np.linalg.norm(before(points_px, 4.0 * STEP_M) - before(points_px, 4.0 * STEP_M, boxed=False), axis=1)
    assert not members[off_px > AGREEMENT_PX + 0.1].any()
    assert 0.5 < (off_px[box] > AGREEMENT_PX + 0.1).mean() < 1.0, "the foot of the box moves as the road does"


@pytest.mark.parametrize("count", [3, 400])
def test_random_flow_has_no_dominant_plane(count: int) -> None:
    random = np.random.default_rng(0)
    points_px = random.uniform(0.0, 480.0, (count, 2))
    assert plane_motion(points_px, points_px + random.uniform(-30.0, 30.0, (count, 2))) is None


def test_the_gradient_leads_away_from_an_obstacle() -> None:
    plane = np.ones((12, 32))
    plane[4:8, 10:14] = 0.0
    right = potential(plane).right
    assert right[6, 15] > 0.1, "right of the obstacle to the right"
    assert right[6, 8] < -0.1
    assert np.abs(right[6, 25:]).max() < 0.01
    assert np.abs(potential(plane).right + potential(plane[:, ::-1]).right[:, ::-1]).max() < 1e-9, "mirrored"


def test_unknown_cells_are_filled_by_their_neighbours() -> None:
    plane = np.ones((12, 32))
    plane[:, :16] = 0.0
    plane[5:7, 3:6] = plane[5:7, 25:28] = np.nan
    level = potential(plane).level
    assert level[5:7, 3:6].max() < 0.01
    assert level[5:7, 25:28].min() > 0.99
    assert potential(np.full((12, 32), np.nan)).level.min() == 1.0


def road_images(count: int) -> list[Image]:
    """(480, 640) grey frames of a textured road with a box, which the camera nears; the last has the box at NEAR_M."""
    random = np.random.default_rng(1)
    texture = cv2.GaussianBlur(random.integers(0, 255, (2400, 1200)).astype(np.float32), (0, 0), 1.5)
    texture = cv2.normalize(texture, None, 20.0, 235.0, cv2.NORM_MINMAX)  # 50 px/m of road
    face = cv2.GaussianBlur(random.integers(0, 255, (130, 240)).astype(np.float32), (0, 0), 2.0)
    face = cv2.normalize(face, None, 20.0, 235.0, cv2.NORM_MINMAX)
    images = []
    for back_m in STEP_M * np.arange(count - 1, -1, -1):
        corners_m = np.array([(2.5, -12.0), (2.5, 12.0), (48.0, -12.0), (48.0, 12.0)]) + np.array([back_m, 0.0])
        seen_px = project(CAMERA, np.column_stack([corners_m, np.zeros(4)]))
        on_texture = np.array([(0.0, 125.0), (1200.0, 125.0), (0.0, 2400.0), (1200.0, 2400.0)])
        road = cv2.getPerspectiveTransform(on_texture.astype(np.float32), seen_px.astype(np.float32))
        image = cv2.warpPerspective(texture, road, (640, 480), flags=cv2.INTER_AREA, borderValue=(128.0,))
        ends = project(CAMERA, np.array([(NEAR_M + back_m, -ASIDE_M, HIGH_M), (NEAR_M + back_m, ASIDE_M, 0.0)]))
        scale, shift = (ends[1] - ends[0]) / (240.0, 130.0), ends[0]
        placed = np.array([[scale[0], 0.0, shift[0]], [0.0, scale[1], shift[1]]])
        box = cv2.warpAffine(face, placed, (640, 480), flags=cv2.INTER_LINEAR, borderValue=(-1.0,))
        images.append(np.where(box > 0.0, box, image).astype(np.uint8))
    return images


def test_the_detector_finds_the_box_on_a_drawn_road() -> None:
    detector = PlaneDetector(CAMERA)
    for image in road_images(8):
        detector.update(image)
    plane, points_px = detector.plane.ravel(), detector.points_px
    ground_m = ground_from_pixels(CAMERA, points_px)
    aside = np.array([12.0, 0.0])
    box = in_box(points_px) & in_box(points_px + aside) & in_box(points_px - aside)
    upper = box & (points_px[:, 1] < CAMERA.cy_px + 35.0)  # of the box; its foot moves as the road does
    road = ~in_box(points_px) & (ground_m[:, 0] > 5.0) & (ground_m[:, 0] < 20.0) & (np.abs(ground_m[:, 1]) > 2.5)
    road &= np.abs(ground_m[:, 1]) < 8.0
    assert np.nanmean(plane[upper]) < 0.2
    assert np.nanmean(plane[road]) > 0.8


def test_a_car_that_stands_keeps_what_it_found() -> None:
    detector = PlaneDetector(CAMERA)
    images = road_images(8)
    for image in images:
        detector.update(image)
    found = detector.plane.copy()
    for _ in range(8):
        detector.update(images[-1])
    assert np.array_equal(detector.plane, found, equal_nan=True)


@pytest.mark.parametrize("camera", [Camera(640, 16), Camera(16, 480), Camera(640, 480, pitch_rad=-0.9)])
def test_a_camera_that_does_not_show_the_road_is_no_fault(camera: Camera) -> None:
    driver = DominantPlaneDriver()
    driver.reset(DriverSetup(camera, VehicleModel(), 20.0, 5.55, (100.0, 0.0), seed=0))
    image = np.random.default_rng(0).integers(0, 255, (camera.height_px, camera.width_px, 3), np.uint8)
    for step in range(4):
        command = driver.act(Observation(image, step / 20.0, 0.0, 0.0, 0.0, 5.55, 0.0, (100.0, 0.0)))
        assert (command.throttle, command.steering) == (0.0, 0.0), "straight to the goal"


def test_it_arrives_on_a_straight_road(tmp_path: Path) -> None:
    path = tmp_path / "short.toml"
    path.write_text('schema = 1\nbase = "straight"\n[goal]\ns_m = 35.0\n')
    found = episode.run(str(path), "clear", "dominant-plane", 0)
    assert found.record.succeeded
    assert found.record.scores["max_lane_offset_m"] < 1.0
