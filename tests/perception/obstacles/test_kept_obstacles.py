"""Which obstacles are kept in the world, and which are pruned."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_obstacles import obstacles
from tracked_points import Drive, body, road_points, tracker

from vpf_sim.types import Floats


def test_an_obstacle_is_kept_out_of_view_and_pruned_once_passed() -> None:
    drive = Drive(np.concatenate([body(30.0, 2.5, 1.6, 1.3, 10), road_points(100)]))
    found = drive.run(tracker(), range(480))
    beside = next(k for k in range(480) if drive.pose(k)[0] > 30.0)
    assert len(found[beside]) == 1
    assert found[beside].forward_m[0] == pytest.approx(0.0, abs=0.3)
    passed = next(k for k in range(480) if drive.pose(k)[0] > 41.6)
    assert not len(found[passed])


def test_lost_tracks_delete_no_obstacle() -> None:
    drive = Drive(np.concatenate([body(40.0, 0.0, 1.8, 1.4, 10), road_points(100)]))
    watch = tracker()
    seen = drive.run(watch, range(280))
    assert len(seen[-1]) == 1
    drive.scene = np.concatenate([np.tile([-50.0, 0.0, 0.0], (10, 1)), drive.scene[10:]])
    later = drive.run(watch, range(280, 400))
    assert all(len(found) == 1 for found in later)
    assert later[-1].forward_m[0] == pytest.approx(40.0 - drive.pose(399)[0], abs=0.5)


@pytest.mark.parametrize(("lost", "reported"), [(True, 1), (False, 2)])
def test_a_lost_fragment_is_no_obstacle_once_the_other_is_passed(lost: bool, reported: int) -> None:
    """Three points that passed for a car's stand 7 m behind its rear, 0.8 m beside it: while it is ahead it may hide
    them, as it does those that slide along its edge."""
    parted = [[47.0, 4.1, 0.6], [47.0, 4.3, 0.9], [47.0, 4.2, 0.4]]
    drive = Drive(np.concatenate([body(40.0, 2.5, 1.6, 1.3, 10), road_points(100), parted]))
    found = tracker()
    assert len(drive.run(found, range(300))[-1]) == 2
    found.points.obstacle[found.points.obstacle >= 0] = 0
    assert len(drive.run(found, range(300, 303))[-1]) == 1
    if lost:
        drive.scene[-3:] = [-50.0, 0.0, 0.0]
    looks = drive.run(found, range(303, 480))
    passed = [look for look, k in zip(looks, range(303, 480), strict=True) if drive.pose(k)[0] > 40.0]
    assert {len(look) for look in passed} == {reported}


def test_parallax_ignores_where_a_moving_obstacle_is_and_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor was it when the older image was taken, 4.5 m of our way before, 2.4 m of its own."""
    found, seen = tracker(), list[Floats]()
    monkeypatch.setattr(found.parallax, "update", lambda *arguments: seen.append(arguments[2]))
    drives = obstacles((12.0, -1.0, 1.0), identity=[-1], speed_mps=[3.0])
    found.compare_road(np.zeros((480, 640), np.uint8), np.zeros(3), Drive(road_points(9)).road, drives, 5.6)
    assert seen[0].shape == (1, 4, 2)
    assert seen[0][0, :, 0].min() == pytest.approx(12.0 - 0.8 - 3.0 * 4.5 / 5.6)


def test_the_road_behind_an_obstacle_is_ignored() -> None:
    face = np.column_stack([np.full(9, 42.0), np.linspace(-0.6, 0.6, 9), np.linspace(0.98, 1.4, 9)])
    drive, found, hidden = Drive(np.concatenate([face, road_points(100)])), tracker(), list[int]()
    assert len(drive.run(found, range(370))[-1]) == 1
    found.parallax = SimpleNamespace(looks=True, update=lambda _image, _pose, corners: hidden.append(len(corners)))  # type: ignore[assignment]
    found.compare_road(np.zeros((480, 640), np.uint8), drive.pose(369), drive.road, speed_mps=5.0)
    assert hidden == [1]


@pytest.mark.parametrize(("drives", "reported"), [(True, False), (False, True)])
def test_a_far_car_that_drives_across_is_no_near_obstacle(drives: bool, reported: bool) -> None:
    """On its corners alone, each seen where one of an obstacle at 40 m would be that stands."""
    corners = np.array([[40.0, 1.5 + 0.12 * k, 1.2 + 0.06 * (k % 3)] for k in range(5)])
    drive, found = Drive(np.concatenate([corners, road_points(100)])), tracker()
    eye_m, reports = np.array([found.camera.forward_m, 0.0, found.camera.height_m]), []
    for k in range(320):
        at = drive.pose(k)[0]
        if drives:  # 55 m ahead, the first corner in line with the one that stands
            here = eye_m + np.array([at, 0.0, 0.0])
            sight = corners[0] - here
            drive.scene[:5] = here + sight * 55.0 / sight[0] + 4.6 * (corners - corners[0]) * [0.0, 1.0, 1.0]
        reports += drive.run(found, range(k, k + 1))
    assert any(len(found) for found in reports[240:]) == reported
