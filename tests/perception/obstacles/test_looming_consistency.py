"""Far things that drive across, against near things that stand: both seen by a pinhole camera that drives straight."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import section
from flow_between import flow_between
from tracked_points import CAMERA

from vpf_sim.perception.obstacles.looming_consistency import LoomingConsistency
from vpf_sim.types import Floats, Flow

RATE_HZ, SPEED_MPS = 20.0, 5.5
SETTINGS = section("static_obstacles.looming_consistency")
CORNERS_M = np.array([[0.0, 0.0], [0.16, 0.03], [0.05, 0.12], [0.2, 0.15]])  # right and up


def seen(corners_m: Floats, distance_m: Floats | float, time_s: float, born_s: float) -> Flow:
    """A frame with corners (N, 2), right of the pose and above the camera, so far ahead of it."""
    distance, count = np.broadcast_to(distance_m, len(corners_m)), len(corners_m)
    aside, up = corners_m.T / distance
    points = np.stack([CAMERA.cx_px + CAMERA.fx_px * aside, CAMERA.cy_px - CAMERA.fy_px * up], axis=1)
    pose = np.array([SPEED_MPS * time_s, 0.0, 0.0])
    identity = np.arange(count) + (100 if time_s < born_s else 0)
    return replace(flow_between(points, points, pose, pose), identity=identity)


def watch() -> LoomingConsistency:
    return LoomingConsistency(SETTINGS, RATE_HZ)


def approached(looming: LoomingConsistency, count: int, stands: bool, now_m: float, born_s: float = 0.0) -> None:
    """Record 1 s of the corners of an obstacle that stands.

    Or of one five times as far off and as large that drives as fast as the car, and across, so that its corners are
    seen where those of the first would be.
    """
    times_s = np.arange(0.0, 1.01, 1.0 / RATE_HZ)
    for time_s in times_s:
        to_go_m = SPEED_MPS * (times_s[-1] - time_s)
        distance_m = now_m + to_go_m
        if stands:
            flow = seen(CORNERS_M[:count] + np.array([1.5, 0.0]), distance_m, time_s, born_s)
        else:
            bearing = 1.5 / distance_m  # of the obstacle that stands
            flow = seen(5.0 * CORNERS_M[:count] + np.array([5.0 * now_m * bearing, 0.0]), 5.0 * now_m, time_s, born_s)
        looming.record(flow)


def reported(looming: LoomingConsistency, count: int, now_m: float) -> list[bool]:
    return looming.keeps_together(np.arange(count), np.full(count, 1.0 / now_m)).tolist()


def keeps_together(count: int, stands: bool, now_m: float, born_s: float = 0.0) -> list[bool]:
    """What is reported of them then."""
    looming = watch()
    approached(looming, count, stands, now_m, born_s)
    return reported(looming, count, now_m)


@pytest.mark.parametrize("now_m", [6.0, 12.0])
def test_a_far_car_that_drives_across_keeps_together(now_m: float) -> None:
    assert keeps_together(4, False, now_m) == [True] * 4
    assert keeps_together(4, True, now_m) == [False] * 4


def test_one_point_or_young_ones_are_not_judged() -> None:
    assert keeps_together(2, False, 6.0) == [True] * 2
    assert keeps_together(1, False, 6.0) == [False]
    assert keeps_together(4, False, 12.0, born_s=0.8) == [False] * 4


def test_a_result_holds_while_a_point_is_alone_and_followed() -> None:
    looming = watch()
    approached(looming, 2, False, 6.0)
    assert reported(looming, 2, 6.0) == [True] * 2
    assert reported(looming, 1, 6.0) == [True]
    looming.record(seen(CORNERS_M[:2], 6.0, 0.0, 1.0))  # other tracks
    approached(looming, 1, False, 6.0)
    assert reported(looming, 1, 6.0) == [False]


def test_a_wiper_leaves_results() -> None:
    looming = watch()
    approached(looming, 2, False, 6.0)
    assert reported(looming, 2, 6.0) == [True] * 2
    nothing = seen(CORNERS_M[:0], 6.0, 1.0, 0.0)
    looming.record(replace(nothing, occluded=np.arange(2)))
    looming.record(seen(5.0 * CORNERS_M[:1], 30.0, 1.0, 0.0))
    assert reported(looming, 1, 6.0) == [True]


def test_results_are_limited() -> None:
    looming, kept = watch(), round(SETTINGS.memory_s * RATE_HZ)
    approached(looming, 2, False, 6.0)
    for _ in range(3 * kept):
        assert reported(looming, 2, 6.0) == [True] * 2
    approached(looming, 2, True, 6.0)
    found = [reported(looming, 2, 6.0) for _ in range(kept)]
    assert found == [[True] * 2] * (kept - 1) + [[False] * 2]


def test_points_of_other_objects_are_not_compared() -> None:
    """Each by itself beside a far tree line, 40 px apart, or at another depth."""
    apart = np.array([[1.5, 0.0], [3.5, 0.0], [5.5, 0.0]])
    for corners_m, depth_m in ((apart, np.full(3, 12.0)), (CORNERS_M[:3], np.array([4.0, 9.0, 20.0]))):
        looming = watch()
        for frame in range(11):
            looming.record(seen(corners_m, 12.0, frame / RATE_HZ, 0.0))
        assert looming.keeps_together(np.arange(3), 1.0 / depth_m).tolist() == [False] * 3
