"""Registration with the first frame, on images that grow by a known factor, and what depths gain."""

from functools import partial

import cv2
import numpy as np
import pytest
from flow_between import flow_between
from tracked_points import CAMERA, Drive, body, road_points, tracker

from vpf_sim.geometry import project, undistort, vehicle_from_world
from vpf_sim.perception.egomotion.keyframes import KeyframeBuffer
from vpf_sim.perception.obstacles.track_refinement import refined
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow, Image, Integers

AHEAD_PX = np.array([CAMERA.cx_px, CAMERA.cy_px])  # what grows, grows about it
TEXTURE = cv2.GaussianBlur(stream(61, "texture").normal(0.0, 1.0, (960, 1280)), (0, 0), 4.0)


def picture(growth: float) -> Image:
    """The texture, in levels about 128, so many times as large as it is at first."""
    place = np.array([[0.5 * growth, 0.0, 0.0], [0.0, 0.5 * growth, 0.0]])
    place[:, 2] = AHEAD_PX - 0.5 * growth * 2.0 * AHEAD_PX
    seen = cv2.warpAffine(TEXTURE, place, (CAMERA.width_px, CAMERA.height_px), flags=cv2.INTER_AREA)
    return np.clip(128.0 + 160.0 * seen, 0, 255).astype(np.uint8)


def places(growth: float) -> tuple[Floats, Floats]:
    """(N, 2) px now, and where the same was at first."""
    first = AHEAD_PX + stream(62, "places").uniform(-90.0, 90.0, (40, 2))
    return AHEAD_PX + growth * (first - AHEAD_PX), first


def seen(frames: list[Image], camera: Camera = CAMERA, remembered: int = 8) -> KeyframeBuffer:
    buffer = KeyframeBuffer(camera, 11, remembered)
    for frame in frames:
        buffer.push(frame)
    return buffer


@pytest.mark.parametrize("growth", [1.0, 1.25, 1.7])
@pytest.mark.parametrize("error_px", [(0.0, 0.0), (0.8, -0.5), (-0.4, 1.0)])
def test_a_track_that_slipped_is_corrected(growth: float, error_px: tuple[float, float]) -> None:
    now, first = places(growth)
    buffer = seen([picture(1.0), np.zeros((480, 640), np.uint8), picture(growth)])
    flow = flow_between(now, first + error_px, age_frames=2)
    aside, found = buffer.register(flow, np.arange(40), np.full((40, 2), growth))
    assert found.mean() > 0.9
    assert np.median(np.hypot(*(aside[found] + error_px).T)) < 0.08


def test_other_content_is_not_found() -> None:
    now, first = places(1.2)
    other = np.ascontiguousarray(picture(1.0)[::-1])
    flow = flow_between(now, first, age_frames=1)
    _, found = seen([other, picture(1.2)]).register(flow, np.arange(40), np.full((40, 2), 1.2))
    assert found.mean() < 0.1


def test_points_older_than_the_buffer_are_not_found() -> None:
    now, first = places(1.0)
    buffer = seen([picture(1.0)] * 4, remembered=2)
    flow = flow_between(now, first, age_frames=3)
    flow.age_frames[::2] = 2
    _, found = buffer.register(flow, np.arange(40), np.ones((40, 2)))
    assert not found[1::2].any()
    assert found[::2].all()


@pytest.mark.parametrize("age", [30, 75, 83])
def test_more_frames_and_points_than_fit_into_one_image(age: int) -> None:
    now, first = places(1.2)
    blank = np.zeros((CAMERA.height_px, CAMERA.width_px), np.uint8)
    frames = [blank] * (83 - age) + [picture(1.0)] + [blank] * (age - 1) + [picture(1.2)]
    buffer, rows = seen(frames, remembered=84), np.tile(np.arange(40), 60)
    aside, found = buffer.register(flow_between(now, first, age_frames=age), rows, np.full((len(rows), 2), 1.2))
    assert found.mean() > 0.9
    assert np.abs(aside[found]).max() < 0.3


def test_corrections_are_undistorted() -> None:
    camera, error_px = Camera(k1=-0.12, k2=0.02), np.array([0.7, 0.0])
    now, first = places(1.0)
    flow = flow_between(undistort(camera, now), undistort(camera, first + error_px), age_frames=1)
    aside, found = seen([picture(1.0)] * 2, camera).register(flow, np.arange(40), np.ones((40, 2)))
    expected = undistort(camera, first) - undistort(camera, first + error_px)
    assert np.median(np.hypot(*(aside - expected)[found].T)) < 0.08


def test_depths_use_the_corrected_first_observations() -> None:
    """Every other point of a body is found where it truly was, and its depth is known the better."""
    drive, found = Drive(np.concatenate([body(40.0, 0.6, 1.6, 1.3, 30), road_points(60)]), noise_px=0.4), tracker()
    flow = None
    for frame in range(240):
        flow = drive.flow(frame)
    assert flow is not None
    depth_m, body_rows = 40.0 - flow.pose[0] - CAMERA.forward_m, flow.identity < 30
    exact = Drive(drive.scene, noise_px=0.0)
    truth = {int(i): px for i, px in zip(*_firsts(exact, flow), strict=True)}
    requested: list[Integers] = []

    def match(rows: Integers, growth: Floats) -> tuple[Floats, Bools]:
        requested.append(rows)
        way_m, once = np.hypot(*(flow.pose - flow.first_pose[rows])[:, :2].T), len(np.unique(rows))
        assert growth[:once] == pytest.approx(np.tile(1.0 + way_m[:once] / depth_m, (2, 1)).T, rel=0.4)
        assert growth[once:, 1] == pytest.approx(growth[once:, 0] ** 2), "as if they lay on the road"
        aside = np.array([truth[int(i)] for i in flow.identity[rows]]) - flow.first_px[rows]
        return aside, flow.identity[rows] % 2 == 0

    chained = found.triangulate(flow)
    matched = found.refined(flow, chained, drive.road, match, drive.speed_mps)
    even = body_rows & (flow.identity % 2 == 0) & np.isin(np.arange(len(flow)), requested[0])
    assert np.count_nonzero(even) > 8
    assert np.abs(matched.depth_m - depth_m)[even].mean() < 0.7 * np.abs(chained.depth_m - depth_m)[even].mean()
    assert np.all(matched.sigma_m[even] < chained.sigma_m[even])
    assert matched.depth_m[~even] == pytest.approx(chained.depth_m[~even], nan_ok=True)


def test_a_point_lies_on_the_road_by_the_better_of_its_tracks() -> None:
    """Tracks on the road that slipped by half a pixel; where each was first is found only as if it lay there."""
    drive, found = Drive(road_points(80), noise_px=0.5), tracker()
    for frame in range(180):
        flow = drive.flow(frame)
    truth, count = dict(zip(*_firsts(Drive(drive.scene, noise_px=0.0), flow), strict=True)), len(flow)

    def match(rows: Integers, growth: Floats) -> tuple[Floats, Bools]:
        aside = np.array([truth[int(i)] for i in flow.identity[rows]]) - flow.first_px[rows]
        return aside, np.arange(len(growth)) >= count

    chained, config = found.triangulate(flow), found.config.track_refinement
    again = partial(found.matched, flow)
    matched = refined(flow, chained, np.arange(count), match, config, again, CAMERA)
    assert np.array_equal(matched.depth_m, chained.depth_m, equal_nan=True), "no depth is of a match as lying"
    true_px = np.array([truth[int(i)] for i in flow.identity])
    exact = found.matched(flow, np.arange(count), true_px - flow.first_px).chi2_ground
    near = CAMERA.fy_px * CAMERA.height_m / (flow.points_px[:, 1] - CAMERA.cy_px) < config.road_m
    assert np.count_nonzero(exact[near] < chained.chi2_ground[near]) > 5
    better = np.minimum(exact, chained.chi2_ground)
    assert matched.chi2_ground == pytest.approx(np.where(near, better, chained.chi2_ground))


def _firsts(drive: Drive, flow: Flow) -> tuple[Integers, Floats]:
    """Identities of the flow's points, and where they truly were at their first sightings."""
    places_m = [
        vehicle_from_world(drive.scene[i, :2], pose) for i, pose in zip(flow.identity, flow.first_pose, strict=True)
    ]
    return flow.identity, project(CAMERA, np.column_stack([np.array(places_m), drive.scene[flow.identity, 2]]))
