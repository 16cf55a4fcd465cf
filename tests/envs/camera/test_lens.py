"""Lens distortion against OpenCV, ground truth against frames, and optical flow through the lens."""

from collections.abc import Callable
from math import inf, nan

import cv2
import numpy as np
import pytest
from driver_settings import FULL_FRAME
from highway_env.road.road import Road
from highway_scenes import add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.lens import Lens
from vpf_sim.errors import InputError
from vpf_sim.geometry import distort, ground_from_pixels, project, undistort
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.perception.egomotion.ground_plane import ground_flow
from vpf_sim.types import Camera, Floats

BARREL = Camera(k1=-0.184, k2=0.031)  # the lens of RADIATE's left camera
PINCUSHION = Camera(k1=0.08, k2=0.0)
LENSES = {"barrel": BARREL, "pincushion": PINCUSHION, "odd": Camera(800, 600, 600.0, 590.0, 380.0, 310.0, k1=-0.2)}
ALL = ("depth", "flow", "foe", "ttc", "instance")


def grid(camera: Camera, step: int = 40) -> Floats:
    """(n, 2) px, a grid over the image."""
    x, y = np.meshgrid(np.arange(5, camera.width_px - 5, step), np.arange(5, camera.height_px - 5, step))
    return np.stack([x.ravel(), y.ravel()], axis=-1).astype(float)


@pytest.mark.parametrize("camera", LENSES.values(), ids=LENSES)
def test_undistortion_is_the_inverse_and_matches_opencv(camera: Camera) -> None:
    pixels = grid(camera)
    flat = undistort(camera, pixels)
    assert distort(camera, flat) == pytest.approx(pixels, abs=1e-8)
    matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
    terms = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-10)
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    opencv = cv2.undistortPoints(pixels[:, None], matrix, lens, P=matrix, criteria=terms)[:, 0]
    assert flat == pytest.approx(opencv, abs=1e-3)


def test_undistorted_lens_changes_nothing() -> None:
    lens, pixels = Lens(Camera()), grid(Camera())
    frame = np.zeros((480, 640, 3), np.uint8)
    assert lens.distorted(frame) is frame
    assert lens.pinhole == Camera()
    assert undistort(Camera(), pixels) is pixels


@pytest.mark.parametrize("camera", LENSES.values(), ids=LENSES)
def test_lens_moves_points_as_the_model_says(camera: Camera) -> None:
    lens = Lens(camera)
    for point in grid(camera, 130)[1:-1:2]:
        place = undistort(camera, point) - (camera.cx_px, camera.cy_px) + (lens.pinhole.cx_px, lens.pinhole.cy_px)
        frame = np.zeros((lens.pinhole.height_px, lens.pinhole.width_px, 3), np.uint8)
        y, x = np.mgrid[: frame.shape[0], : frame.shape[1]]
        frame[:] = (250.0 * np.exp(-((x - place[0]) ** 2 + (y - place[1]) ** 2) / 18.0))[..., None]
        seen = lens.distorted(frame)[..., 0].astype(float)
        y, x = np.mgrid[: seen.shape[0], : seen.shape[1]]
        bright = np.where(seen > 60.0, seen, 0.0)
        middle = np.array([(bright * x).sum(), (bright * y).sum()]) / bright.sum()
        assert middle == pytest.approx(point, abs=0.25)


@pytest.mark.parametrize("camera", LENSES.values(), ids=LENSES)
def test_no_border_is_empty(camera: Camera) -> None:
    lens = Lens(camera)
    white = np.full((lens.pinhole.height_px, lens.pinhole.width_px, 3), 255, np.uint8)
    assert lens.distorted(white).min() == 255
    assert lens.distorted(white).shape == (camera.height_px, camera.width_px, 3)


@pytest.mark.parametrize(
    ("k1", "k2", "expected"),
    [
        (
            -0.3,
            0.0,
            "k1, k2: expected a distortion that is invertible within the image, to 1.25 off the axis, got -0.3, 0",
        ),
        (-0.1, -0.1, "k1, k2: expected a distortion that is invertible within the image"),
        (-2.0, 0.5, "k1, k2: expected a distortion that is invertible within the image"),
        (inf, 0.0, "k1: expected a finite number, got inf"),
        (0.0, nan, "k2: expected a finite number, got nan"),
    ],
)
def test_distortion_that_folds_within_the_image_is_rejected(k1: float, k2: float, expected: str) -> None:
    with pytest.raises(InputError, match=f"camera: {expected}"):
        Rig(Camera(k1=k1, k2=k2))


def scene(camera: Camera) -> tuple[Road, Renderer, Callable[[], None]]:
    """A road with objects, a renderer without noise, and a function that advances the ego."""
    road = straight_road()
    add_object(road, "van", [36.0, 10.6])
    add_object(road, "car", [34.0, 3.6])
    ego = add_ego(road, [20.0, 7.0], heading=0.02)

    def advance() -> None:
        ego.position = ego.position + 5.55 / 60.0 * np.array([np.cos(0.02), np.sin(0.02)])

    return road, Renderer(road, Rig(camera, noise_sd=0.0), weather.load("clear"), 4), advance


def test_truth_matches_the_distorted_image() -> None:
    road, renderer, advance = scene(BARREL)
    ego = road.vehicles[0]
    renderer.render(ego, 0.0)
    advance()
    frame = renderer.render(ego, 1.0 / 60.0)
    truth = renderer.truth(ALL)
    assert frame.shape == (480, 640, 3)
    assert truth["depth"].shape == truth["instance"].shape == (480, 640)
    assert truth["foe"] == pytest.approx([319.5, 239.5], abs=1e-6)  # straight ahead, where the lens bends nothing
    ground = (truth["instance"] == 0) & (truth["depth"] < 40.0)
    rows, columns = np.nonzero(ground)
    pixels = np.stack([columns, rows], axis=-1)[::53].astype(float)
    place = ground_from_pixels(BARREL, undistort(BARREL, pixels))
    assert truth["depth"][ground][::53] == pytest.approx(place[:, 0] - BARREL.forward_m, rel=1e-5)
    before = np.column_stack([place[:, 0] + 5.55 / 60.0, place[:, 1], np.zeros(len(place))])
    expected = pixels - distort(BARREL, project(BARREL, before))
    assert truth["flow"][ground][::53] == pytest.approx(expected, abs=1e-3)


def test_object_silhouette_is_equal_in_truth_and_image() -> None:
    road, renderer, _ = scene(BARREL)
    frame = renderer.render(road.vehicles[0], 0.0)
    mask = renderer.truth(("instance",))["instance"] > 0
    objects = list(road.objects)
    road.objects.clear()
    empty = Renderer(road, Rig(BARREL, noise_sd=0.0), weather.load("clear"), 4).render(road.vehicles[0], 0.0)
    changed = cv2.absdiff(frame, empty).max(axis=2) > 2
    above = np.zeros_like(mask)
    above[:238] = True  # below the horizon there are shadows too
    assert mask[above].sum() > 500
    assert np.mean(changed[mask & above]) > 0.97
    assert np.mean(mask[changed & above]) > 0.9
    assert len(objects) == 2


def test_lucas_kanade_through_the_lens_agrees_with_the_truth() -> None:
    road, renderer, advance = scene(BARREL)
    ego = road.vehicles[0]
    previous = grey(renderer.render(ego, 0.0))
    errors = []
    for k in range(1, 6):
        advance()
        picture = grey(renderer.render(ego, k / 60.0))
        truth = renderer.truth(("depth", "flow", "instance"))
        wanted = (truth["instance"] == 0) & (truth["depth"] > 5.0) & (truth["depth"] < 40.0)
        wanted &= cv2.dilate((truth["instance"] != 0).astype(np.uint8), np.ones((25, 25))) == 0
        corners = cv2.goodFeaturesToTrack(picture, 300, 0.01, 8, mask=wanted.astype(np.uint8) * 255)
        back, status, _ = cv2.calcOpticalFlowPyrLK(picture, previous, corners, None, winSize=(25, 25), maxLevel=2)
        kept = status[:, 0] == 1
        at = np.rint(corners[kept, 0]).astype(int)
        errors.append(np.hypot(*(corners[kept, 0] - back[kept, 0] - truth["flow"][at[:, 1], at[:, 0]]).T))
        previous = picture
    everything = np.concatenate(errors)
    assert len(everything) > 150
    assert np.median(everything) < 0.15


def test_the_tracker_reports_the_flow_of_a_pinhole() -> None:
    road, renderer, advance = scene(BARREL)
    ego, residuals = road.vehicles[0], []
    trackers = [FlowTracker(camera, FULL_FRAME.flow, 60.0) for camera in (BARREL, Camera())]
    for k in range(13):
        picture, pose = grey(renderer.render(ego, k / 60.0)), np.array([*ego.position, ego.heading])
        flows = [tracker.update(picture, pose) for tracker in trackers]
        advance()
    for flow in flows:
        road_flow = ground_flow(Camera(), flow.points_px, flow.past_pose, flow.pose)
        near = (flow.points_px[:, 1] > 270.0) & (flow.gap_s > 0.05)
        assert near.sum() > 25
        residuals.append(np.median(np.hypot(*(flow.displacement_px - road_flow)[near].T)))
    assert residuals[0] < 0.8
    assert residuals[1] > 1.8 * residuals[0]  # what comes out where the distortion is left in
