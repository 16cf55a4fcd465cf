"""Flow of pictures that a wiper's blade crosses, moved by a known amount."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from test_flow import CAMERA, ROBUST, moved, texture

from vpf_sim.perception.flow import FlowTracker
from vpf_sim.types import Flow, Image

STEP = (0.8125, 0.3125)  # px a frame
HELD = replace(ROBUST, hold_s=0.1)
FRAMES, FIRST, LAST = 24, 12, 16  # of the drive; in which the blade is seen
BLADE_PX, WIDTH_PX = 150.0, 60.0  # its way in a frame, and its width


def blade_px(k: int) -> float | None:
    """The column of its middle; None where it is not in the picture."""
    return 20.0 + BLADE_PX * (k - FIRST) if FIRST <= k <= LAST else None


def swept(picture: Image, k: int, step: tuple[float, float] = STEP) -> Image:
    """The picture in frame k, behind a dark blade with soft edges that leans to one side."""
    frame = moved(picture, step[0] * k, step[1] * k)
    middle = blade_px(k)
    if middle is None:
        return frame
    columns = np.arange(640.0)[None, :] + 0.2 * np.arange(480.0)[:, None] - 48.0
    share = np.clip(0.5 * WIDTH_PX - np.abs(columns - middle) + 8.0, 0.0, 16.0) / 16.0
    return ((1.0 - 0.9 * share) * frame + 0.9 * share * 25.0).astype(np.uint8)


def flows(tracker: FlowTracker, frames: list[Image]) -> list[Flow]:
    return [tracker.update(frame, np.array([0.1 * k, 0.0, 0.0])) for k, frame in enumerate(frames)]


def errors_px(flow: Flow) -> np.ndarray:
    """(N,) of the way since each point was first seen."""
    return np.hypot(*(flow.points_px - flow.first_px - np.outer(flow.age_frames, STEP)).T)


def survivors(told: list[Flow]) -> float:
    """Share of the points seen before the blade came that are followed rightly when it has gone."""
    before, after = told[FIRST - 1], told[-1]
    inside = (before.points_px[:, 0] < 620.0) & (before.points_px[:, 1] < 330.0)  # will not have left the bands
    right = after.identity[errors_px(after) < 0.5]
    return float(np.mean(np.isin(before.identity[inside], right)))


def test_points_are_followed_beneath_a_wiper() -> None:
    picture = texture("wiper")
    frames = [swept(picture, k) for k in range(FRAMES)]
    assert survivors(flows(FlowTracker(CAMERA, HELD, 60.0), frames)) > 0.8
    assert survivors(flows(FlowTracker(CAMERA, ROBUST, 60.0), frames)) < 0.6


def test_no_point_is_taken_along_nor_told_while_it_is_covered() -> None:
    picture = texture("wiper")
    told = flows(FlowTracker(CAMERA, HELD, 60.0), [swept(picture, k) for k in range(FRAMES)])
    for k, flow in enumerate(told[FIRST:], FIRST):
        old = flow.age_frames > 1
        assert np.mean(errors_px(flow)[old] < 0.5) > 0.9, f"frame {k}"
        middle = blade_px(k)
        if middle is not None:
            aside = flow.points_px[:, 0] + 0.2 * flow.points_px[:, 1] - 48.0 - middle
            assert np.mean(np.abs(aside) < 0.25 * WIDTH_PX) < 0.02, f"frame {k}"


def test_the_motion_over_the_window_is_right_for_points_that_come_back() -> None:
    picture = texture("wiper")
    told = flows(FlowTracker(CAMERA, HELD, 60.0), [swept(picture, k) for k in range(FRAMES)])
    for flow in told[LAST + 1 : LAST + 5]:
        expected = np.outer(flow.gap_s * 60.0, STEP)
        assert np.percentile(np.hypot(*(flow.displacement_px - expected).T), 95) < 0.3


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
    told = flows(FlowTracker(CAMERA, HELD, 60.0), frames)
    before, after = told[FIRST - 1], told[-1]
    gone = before.identity[before.points_px[:, 0] < 280.0]
    assert np.mean(np.isin(gone, after.identity)) < 0.1
    assert np.count_nonzero(after.points_px[:, 0] < 280.0) > 0.7 * len(gone)


def test_a_nonsense_hold_is_refused() -> None:
    with pytest.raises(ValueError, match=r"hold_s: expected > 0, got 0\.0"):
        replace(ROBUST, hold_s=0.0)
