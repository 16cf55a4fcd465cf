"""Flow of pictures that a wiper's blade crosses, moved by a known amount."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
import pytest
from driver_settings import ROBUST as VARIANT
from test_flow import CAMERA, ROBUST, moved, texture

from vpf_sim.perception.egomotion.flow import FlowTracker
from vpf_sim.perception.egomotion.tracks import Tracks
from vpf_sim.seeding import stream
from vpf_sim.types import Flow, Image

STEP = (0.8125, 0.3125)  # px a frame
HELD = replace(ROBUST, wiper=VARIANT.flow.wiper)
FRAMES, FIRST, LAST = 24, 12, 16  # of the drive; in which the blade is seen
BLADE_PX, WIDTH_PX = 150.0, 60.0  # its way in a frame, and its width


def blade_px(k: int) -> float | None:
    """The column of its middle; None where it is not in the picture."""
    return 20.0 + BLADE_PX * (k - FIRST) if FIRST <= k <= LAST else None


def swept(picture: Image, k: int) -> Image:
    """The picture in frame k, where the blade may be before it."""
    return behind_blade(moved(picture, STEP[0] * k, STEP[1] * k), k)


def behind_blade(frame: Image, k: int) -> Image:
    """Frame k behind a dark blade with soft edges that leans to one side."""
    middle = blade_px(k)
    if middle is None:
        return frame
    columns = np.arange(640.0)[None, :] + 0.2 * np.arange(480.0)[:, None] - 48.0
    share = np.clip(0.5 * WIDTH_PX - np.abs(columns - middle) + 8.0, 0.0, 16.0) / 16.0
    return ((1.0 - 0.9 * share) * frame + 0.9 * share * 25.0).astype(np.uint8)


def flows(tracker: FlowTracker, frames: list[Image]) -> list[Flow]:
    return [tracker.update(frame, np.array([0.1 * k, 0.0, 0.0])) for k, frame in enumerate(frames)]


@cache
def wiped() -> list[Flow]:
    """The flow beneath a wiper's blade."""
    picture = texture("wiper")
    return flows(FlowTracker(CAMERA, HELD, 60.0), [swept(picture, k) for k in range(FRAMES)])


def errors_px(flow: Flow) -> np.ndarray:
    """(N,) of the way since each point was first seen."""
    return np.hypot(*(flow.points_px - flow.first_px - np.outer(flow.age_frames, STEP)).T)


def survivors(tracked: list[Flow]) -> float:
    """Share of the points seen before the blade came that are followed rightly when it has gone."""
    before, after = tracked[FIRST - 1], tracked[-1]
    inside = (before.points_px[:, 0] < 620.0) & (before.points_px[:, 1] < 330.0)  # will not have left the bands
    right = after.identity[errors_px(after) < 0.5]
    return float(np.mean(np.isin(before.identity[inside], right)))


def test_points_are_followed_beneath_a_wiper() -> None:
    picture = texture("wiper")
    frames = [swept(picture, k) for k in range(FRAMES)]
    assert survivors(wiped()) > 0.8
    assert survivors(flows(FlowTracker(CAMERA, ROBUST, 60.0), frames)) < 0.6


def test_no_point_is_carried_along_or_reported_while_it_is_occluded() -> None:
    for k, flow in enumerate(wiped()[FIRST:], FIRST):
        old = flow.age_frames > 1
        assert np.mean(errors_px(flow)[old] < 0.5) > 0.9, f"frame {k}"
        middle = blade_px(k)
        if middle is not None:
            aside = flow.points_px[:, 0] + 0.2 * flow.points_px[:, 1] - 48.0 - middle
            assert np.mean(np.abs(aside) < 0.25 * WIDTH_PX) < 0.02, f"frame {k}"


def test_the_motion_over_the_window_is_right_for_points_that_come_back() -> None:
    for flow in wiped()[LAST + 1 : LAST + 5]:
        expected = np.outer(flow.gap_s * 60.0, STEP)
        assert np.percentile(np.hypot(*(flow.displacement_px - expected).T), 95) < 0.3


def test_the_motion_is_right_for_points_that_did_not_come_back_where_they_were_expected() -> None:
    """The picture grows ever faster about its middle: each point's motion changes while it is occluded."""
    picture, middle = texture("growing"), np.array([319.5, 239.5])

    def scale(k: float) -> float:
        return float(np.exp(0.0012 * k**2 - 0.02 * k))

    def grown(k: int) -> Image:
        matrix = np.column_stack([scale(k) * np.eye(2), middle - scale(k) * (middle + 100.0)])
        return cv2.warpAffine(picture, matrix, (640, 480), flags=cv2.INTER_LINEAR).astype(np.uint8)

    def errors_px(tracked: list[Flow], chosen: np.ndarray) -> np.ndarray:
        errors = []
        for k in range(FIRST + 2, LAST + 7):
            flow, kept = tracked[k], np.isin(tracked[k].identity, chosen)
            shrunk = np.array([scale(before) / scale(k) for before in k - np.rint(flow.gap_s * 60.0)])
            error = flow.displacement_px - (flow.points_px - middle) * (1.0 - shrunk[:, None])
            errors.append(np.hypot(*error[kept].T))
        return np.concatenate(errors)

    tracked = flows(FlowTracker(CAMERA, HELD, 60.0), [behind_blade(grown(k), k) for k in range(FRAMES)])
    clear = flows(FlowTracker(CAMERA, HELD, 60.0), [grown(k) for k in range(FRAMES)])
    occluded = np.unique(np.concatenate([flow.occluded for flow in tracked]))
    came_back = np.intersect1d(occluded, tracked[-1].identity)
    assert len(came_back) > 50
    assert np.percentile(errors_px(tracked, came_back), 90) < np.percentile(errors_px(clear, came_back), 90) + 0.1


def test_a_trail_leads_evenly_to_where_a_point_is_seen_again() -> None:
    """Two points went right by 1 px a frame; one is seen as ever, one again in its third frame, 1.5 px lower."""
    tracks = Tracks.none(4)
    tracks.append(np.zeros((2, 2)), np.zeros((2, 2, 2)), np.zeros(3), 0)
    tracks.trail[:, :, 0] = -np.arange(5.0)[:, None]  # before this frame, newest first
    tracks.occluded[:] = 0, 3
    tracks.uncover(np.array([1]), np.array([[0.0, 1.5]]))
    assert tracks.trail[:, 0, 1] == pytest.approx(np.zeros(5))
    assert tracks.trail[:, 1, 1] == pytest.approx([1.0, 0.5, 0.0, 0.0, 0.0])
    assert tracks.trail[:, 1, 0] == pytest.approx(-np.arange(5.0))
    assert tracks.occluded.tolist() == [0, 0]


def test_what_the_check_forward_and_backward_refuses_is_no_wiper() -> None:
    """At 10 Hz it looks at every frame; noise has it refuse far more points than jump in a sweep."""
    picture, noise = texture("noise"), stream(11, "noise of frames")
    frames = [
        np.clip(moved(picture, 8.5 * k, 3.25 * k) + noise.normal(0.0, 45.0, (480, 640)), 0, 255).astype(np.uint8)
        for k in range(9)
    ]
    plain = replace(ROBUST, forward_backward_px=0.5)
    tracked = flows(FlowTracker(CAMERA, plain, 10.0), frames)
    kept = [np.mean(np.isin(before.identity, after.identity)) for before, after in pairwise(tracked[1:])]
    assert max(kept) < 0.9
    for one, other in zip(
        tracked, flows(FlowTracker(CAMERA, replace(plain, wiper=VARIANT.flow.wiper), 10.0), frames), strict=True
    ):
        assert len(other.occluded) == 0
        assert len(other) >= 0.9 * len(one)


def test_a_sweep_ends_where_its_last_point_leaves_the_picture() -> None:
    """A single body leaves; when the scene comes back, corners are found again."""
    body, scene, frames = texture("body"), texture("scene"), []
    for k in range(120):
        frame = np.full((480, 640), 110, np.uint8)
        x = 400 + 4 * k
        frame[200:260, x : x + 60] = body[300:360, 300 : 300 + max(0, min(60, 640 - x))]
        if k % 9 == 0:
            frame[200:230, x : x + 60] = 110  # something covers half of it for a moment
        frames.append(moved(scene, 0.5 * k - 60.0, 0.0) if k > 90 else frame)
    tracked = flows(FlowTracker(CAMERA, HELD, 60.0), frames)
    assert any(len(flow.occluded) for flow in tracked)
    assert len(tracked[-1]) > 200


@pytest.mark.parametrize("change", ["brightness", "jolt"])
def test_what_all_points_do_at_once_is_no_wiper(change: str) -> None:
    """A shadow's end brightens the whole picture, a bump in the road shifts it: all are followed, in every frame."""
    picture = texture("change")
    frames = [moved(picture, STEP[0] * k, STEP[1] * k) for k in range(FRAMES)]
    for k in range(FIRST, FRAMES):
        if change == "jolt":
            frames[k] = moved(picture, STEP[0] * k, STEP[1] * k + 4.5)
        else:
            frames[k] = cv2.add(frames[k], np.full_like(frames[k], 25))
    plain, held = (flows(FlowTracker(CAMERA, config, 60.0), frames) for config in (ROBUST, HELD))
    for one, other in zip(plain, held, strict=True):
        assert len(other) >= 0.97 * len(one)


def test_the_search_ends_with_what_the_blade_has_wiped_away() -> None:
    """Half of the picture is another one afterwards: its points are given up, and others found in their place."""
    first, second = texture("before"), texture("after")
    frames = [swept(first, k) for k in range(FRAMES + 6)]
    for k in range(FIRST, len(frames)):
        wiped = int(min(blade_px(k) or 640.0, 330.0))
        frames[k][:, :wiped] = swept(second, k)[:, :wiped]
    tracked = flows(FlowTracker(CAMERA, HELD, 60.0), frames)
    before, after = tracked[FIRST - 1], tracked[-1]
    gone = before.identity[before.points_px[:, 0] < 280.0]
    assert np.mean(np.isin(gone, after.identity)) < 0.1
    assert np.count_nonzero(after.points_px[:, 0] < 280.0) > 0.7 * len(gone)
