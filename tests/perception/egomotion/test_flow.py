"""Flow of pictures that were moved by a known amount."""

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest
from driver_settings import FULL_FRAME
from driver_settings import ROBUST as VARIANT

from vpf_sim.perception.egomotion.corners import structure_tensor
from vpf_sim.perception.egomotion.egomotion_settings import FlowConfig
from vpf_sim.perception.egomotion.flow import FlowTracker
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Flow, Image

CAMERA = Camera()
PAPER = FULL_FRAME.flow
ROBUST = replace(VARIANT.flow, points=300, forward_backward_px=None, wiper=None, keyframe_s=None)


def texture(name: str) -> Image:
    """A random picture larger than the frame, band-limited, so that it can be moved by parts of a pixel."""
    noise = stream(11, name).normal(0.0, 1.0, (700, 900))
    smooth = cv2.GaussianBlur(noise, (0, 0), 2.5)
    return np.clip(128.0 + 40.0 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def moved(picture: Image, x_px: float, y_px: float) -> Image:
    """(480, 640) the picture, its content moved right by x and down by y."""
    matrix = np.array([[1.0, 0.0, x_px - 100.0], [0.0, 1.0, y_px - 100.0]])
    return cv2.warpAffine(picture, matrix, (640, 480), flags=cv2.INTER_LINEAR).astype(np.uint8)


def follow(tracker: FlowTracker, picture: Image, step: tuple[float, float], frames: int) -> list[Flow]:
    return [
        tracker.update(moved(picture, step[0] * k, step[1] * k), np.array([0.1 * k, 0.0, 0.0])) for k in range(frames)
    ]


@pytest.mark.parametrize("config", [PAPER, ROBUST], ids=["paper", "robust"])
@pytest.mark.parametrize("step", [(0.40625, 0.1875), (-2.3125, 1.09375)])  # multiples of 1/32 px, as warpAffine works
def test_points_move_as_the_picture_does(config: FlowConfig, step: tuple[float, float]) -> None:
    flow = follow(FlowTracker(CAMERA, config, 60.0), texture("moving"), step, 8)[-1]
    assert len(flow) > 100
    expected = np.outer(flow.gap_s * 60.0, step)
    error = np.hypot(*(flow.displacement_px - expected).T)
    assert np.median(error) < 0.05
    assert np.percentile(error, 95) < 0.3


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_stripes_are_followed_through_a_turn_of_more_than_half_their_distance(side: float) -> None:
    period_px, step_px = 14, 10.0 * side
    row, column = np.mgrid[:700, :900]
    stripes = np.where((column + row // 2) % period_px < period_px // 2, 220, 40)
    picture = np.where(np.abs(row - 340) < 30, stripes, 120).astype(np.uint8)
    tracker = FlowTracker(CAMERA, ROBUST, 20.0)
    for k in range(3):
        yaw_rad = -step_px * k / CAMERA.fx_px  # of a camera that sees the picture far away
        flow = tracker.update(moved(picture, step_px * k, 0.0), np.array([0.0, 0.0, yaw_rad]))
    middle = np.abs(flow.points_px[:, 0] - CAMERA.cx_px) < 150.0
    assert np.count_nonzero(middle) > 30
    error = np.abs(flow.displacement_px[middle, 0] / (flow.gap_s[middle] * 20.0) - step_px)
    assert np.mean(error < 1.0) > 0.9


def test_the_window_is_in_seconds_and_shorter_for_young_points() -> None:
    for rate_hz, frames in ((60.0, 6), (20.0, 2), (10.0, 1)):
        flow = follow(FlowTracker(CAMERA, replace(PAPER, window_s=0.1), rate_hz), texture("window"), (0.5, 0.0), 9)[-1]
        assert flow.gap_s.max() == pytest.approx(frames / rate_hz)
        assert flow.gap_s == pytest.approx(np.minimum(flow.age_frames, frames) / rate_hz)


def test_the_pose_of_the_past_and_of_the_first_sighting_are_kept() -> None:
    flow = follow(FlowTracker(CAMERA, PAPER, 60.0), texture("poses"), (0.5, 0.0), 12)[-1]
    assert flow.past_pose[:, 0] == pytest.approx(1.1 - 0.1 * np.rint(flow.gap_s * 60.0))
    assert flow.first_pose[:, 0] == pytest.approx(1.1 - 0.1 * flow.age_frames)
    travelled = flow.points_px - flow.first_px
    assert travelled[:, 0] == pytest.approx(0.5 * flow.age_frames, abs=0.6)


def test_identity_stays_with_a_point_and_ascends() -> None:
    flows = follow(FlowTracker(CAMERA, PAPER, 60.0), texture("identity"), (1.0, 0.5), 15)
    for before, after in pairwise(flows[1:]):
        assert np.all(np.diff(after.identity) > 0)
        _, i, j = np.intersect1d(before.identity, after.identity, return_indices=True)
        assert len(i) > 0.8 * len(before)
        assert after.points_px[j] - before.points_px[i] == pytest.approx(np.tile([1.0, 0.5], (len(i), 1)), abs=0.5)


def test_corners_are_topped_up_where_the_picture_brings_new_ones() -> None:
    flows = follow(FlowTracker(CAMERA, replace(PAPER, points=200), 60.0), texture("new"), (4.0, 0.0), 40)
    counts = [len(flow) for flow in flows[1:]]
    assert min(counts) > 140
    assert max(counts) <= 200
    assert np.count_nonzero(flows[-1].points_px[:, 0] < 100.0) > 10


def test_points_keep_their_distance_from_new_ones() -> None:
    config = replace(PAPER, min_distance_px=8.0)
    flow = follow(FlowTracker(CAMERA, config, 60.0), texture("distance"), (0.3, 0.0), 10)[-1]
    gap = np.hypot(*(flow.points_px[:, None] - flow.points_px[None]).transpose(2, 0, 1))
    np.fill_diagonal(gap, np.inf)
    assert np.percentile(gap.min(axis=1), 1) > 5.0


def test_a_bright_body_does_not_starve_the_far_road() -> None:
    picture = (128.0 + 0.1 * (texture("dim").astype(np.float64) - 128.0)).astype(np.uint8)
    picture[440:560, 200:800] = texture("bright")[440:560, 200:800]  # rows 340 to 460 of the frame, near
    count = {}
    for name, config in (
        ("whole", replace(PAPER, quality=0.05)),
        ("road", replace(PAPER, quality=0.05, bands=VARIANT.flow.bands)),
    ):
        flow = follow(FlowTracker(CAMERA, config, 60.0), picture, (0.3, 0.0), 3)[-1]
        count[name] = np.count_nonzero((flow.points_px[:, 1] > 245) & (flow.points_px[:, 1] < 280))
    assert count["whole"] == 0
    assert count["road"] > 60


def test_edges_are_refused_and_corners_kept() -> None:
    picture = np.full((480, 640), 90, np.uint8)
    cv2.line(picture, (50, 470), (300, 250), 220, 5, cv2.LINE_AA)
    cv2.rectangle(picture, (400, 270), (430, 300), 30, -1)
    config = replace(PAPER, window_px=11, bands=VARIANT.flow.bands, corner_test=VARIANT.flow.corner_test, max_level=1)
    tracker = FlowTracker(CAMERA, config, 60.0)
    tracker.update(picture, np.zeros(3))
    points = tracker.update(picture, np.zeros(3)).points_px
    ends = np.min(np.hypot(points[:, None, 0] - [50, 300], points[:, None, 1] - [470, 250]), axis=1) < 14.0
    square = (points[:, 0] > 390) & (points[:, 0] < 440)
    assert square.any()
    assert np.all(square | ends)


def test_the_forward_backward_check_drops_what_does_not_come_back() -> None:
    first, second = moved(texture("check"), 0.0, 0.0), moved(texture("check"), 1.0, 0.0)
    second[200:300, 200:400] = moved(texture("other"), 0.0, 0.0)[200:300, 200:400]
    inside = {}
    for limit in (None, 0.5):
        tracker = FlowTracker(CAMERA, replace(PAPER, forward_backward_px=limit, window_px=15), 60.0)
        tracker.update(first, np.zeros(3))
        points = tracker.update(second, np.zeros(3)).points_px
        inside[limit] = np.count_nonzero((np.abs(points[:, 0] - 300) < 80) & (np.abs(points[:, 1] - 250) < 30))
    assert inside[0.5] < 0.5 * inside[None]


def test_an_anchor_is_never_older_than_twice_its_time() -> None:
    config = replace(PAPER, keyframe_s=0.1)
    flows = follow(FlowTracker(CAMERA, config, 60.0), texture("anchor"), (0.2, 0.1), 40)
    assert max(flow.age_frames.max() for flow in flows[1:]) <= 12
    last = flows[-1]
    assert last.first_pose[:, 0] == pytest.approx(3.9 - 0.1 * last.age_frames)
    assert np.median(np.hypot(*(last.points_px - last.first_px - np.outer(last.age_frames, [0.2, 0.1])).T)) < 0.1


@pytest.mark.parametrize(("rate_hz", "levels"), [(60.0, 1), (20.0, 2), (10.0, 3)])
def test_slower_cameras_search_farther(rate_hz: float, levels: int) -> None:
    assert FlowTracker(CAMERA, ROBUST, rate_hz).levels == levels


def test_the_structure_tensor_of_a_ramp_is_its_gradient_squared() -> None:
    column, row = np.meshgrid(np.arange(100), np.arange(80))
    ramp = (2.0 * column + row).astype(np.uint8)
    tensor: Floats = structure_tensor(ramp, np.array([[40.0, 40.0], [30.2, 25.7]]), 11)
    assert tensor == pytest.approx(np.tile([[4.0, 2.0], [2.0, 1.0]], (2, 1, 1)))


def test_an_empty_picture_has_no_flow() -> None:
    tracker = FlowTracker(CAMERA, ROBUST, 60.0)
    for _ in range(3):
        assert len(tracker.update(np.full((480, 640), 90, np.uint8), np.zeros(3))) == 0


def test_corners_on_the_glass_are_kept_apart_from_those_that_move_and_take_no_place() -> None:
    """A picture that moves down by 3 px a frame, as a car 0.1 m on at 1.4 m may see it; drops that stay."""
    picture, rng = texture("behind glass"), stream(12, "spots")
    drops = rng.uniform([60.0, 300.0], [580.0, 400.0], (30, 2))
    tracker, counts = FlowTracker(CAMERA, ROBUST, 30.0), []
    for k in range(20):
        frame = moved(picture, 0.0, 3.0 * k)
        for x, y in drops:
            cv2.circle(frame, (int(x), int(y)), 6, 255, -1)
        flow = tracker.update(frame, np.array([0.15 * k, 0.0, 0.0]))
        counts.append(np.count_nonzero(~flow.on_glass))
    distance = np.min(np.hypot(*(flow.points_px[:, None] - drops).T), axis=0)
    followed = np.abs(np.hypot(*flow.displacement_px.T)) > 3.0
    assert np.count_nonzero(flow.on_glass) > 10
    assert np.all(distance[flow.on_glass] < 15.0)  # radius of a spot, half a window and the corner between
    assert not np.any(flow.on_glass & followed)
    assert counts[-1] > 0.8 * ROBUST.points


def test_no_corners_are_taken_where_the_picture_is_hidden() -> None:
    hidden = np.zeros((480, 640), np.uint8)
    hidden[:, 200:400] = 255
    tracker = FlowTracker(CAMERA, PAPER, 60.0)
    for _ in range(2):
        flow = tracker.update(moved(texture("hidden"), 0.0, 0.0), np.zeros(3), hidden)
    assert len(flow) > 100
    assert not np.any((flow.points_px[:, 0] > 200) & (flow.points_px[:, 0] < 399))


def test_nonsense_is_refused_with_what_was_given() -> None:
    with pytest.raises(ValueError, match="window_px: expected an odd number, got 10"):
        replace(PAPER, window_px=10)
    with pytest.raises(ValueError, match="points: expected >= 8, got 2"):
        replace(PAPER, points=2)
