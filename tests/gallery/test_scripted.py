"""Scripted drives on a known path."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.road import centre_line
from vpf_sim.gallery.poses import Path, ScriptedDrive, TimedPath, smooth_step


def weave(s_m: float) -> float:
    return 1.75 + 1.0 * float(np.sin(0.2 * s_m))


def drive(speed_mps: float = 6.0) -> ScriptedDrive:
    return ScriptedDrive(scenarios.load("town04").draw(3), Path(60.0, speed_mps, weave))


def test_the_camera_looks_along_its_path() -> None:
    course = drive()
    centre = centre_line(course.scenario.road)
    poses = np.array([course.pose(centre, s) for s in np.arange(60.0, 80.0, 0.01)])
    steps = np.diff(poses[:, :2], axis=0)
    directions = np.arctan2(steps[:, 1], steps[:, 0])
    assert np.abs(directions - poses[:-1, 2]).max() < 1e-3
    assert centre.local_at(*poses[700, :2]) == pytest.approx((67.0, weave(67.0)), abs=1e-6)


def test_every_weather_shows_the_same_poses() -> None:
    seen = {
        name: np.array([shot.pose for shot in drive().shots(weathers.load(name), 1, 4)])
        for name in ("ClearNoon", "HardRainNoon")
    }
    assert np.array_equal(*seen.values())
    assert np.hypot(*np.diff(seen["ClearNoon"][:, :2], axis=0).T) == pytest.approx([0.1] * 3, rel=0.2)


def test_a_stationary_drive_stays() -> None:
    poses = [shot.pose for shot in drive(0.0).shots(weathers.load("ClearNoon"), 1, 3)]
    assert np.array_equal(poses[0], poses[2])


def test_a_timed_path_passes_its_places_and_keeps_its_last_speed() -> None:
    path = TimedPath(np.array([0.0, 1.0, 2.0]), np.array([10.0, 14.0, 15.0]), weave)
    assert [path.s_m(time_s) for time_s in (0.0, 0.5, 1.0, 2.0, 4.0)] == pytest.approx([10.0, 12.0, 14.0, 15.0, 17.0])


def test_a_pitching_body_moves_the_horizon_and_not_the_poses() -> None:
    """The frames are those of a level body, moved up and down by f tan(pitch)."""
    level, pitching = (
        list(replace(drive(), pitch_deg=degrees).shots(weathers.load("ClearNoon"), 1, 12)) for degrees in (0.0, 0.5)
    )
    assert all(np.array_equal(one.pose, other.pose) for one, other in zip(level, pitching, strict=True))
    moved_px = []
    for one, other in zip(level, pitching, strict=True):
        before, after = (cv2.cvtColor(shot.image, cv2.COLOR_RGB2GRAY).astype(float) for shot in (one, other))
        moved_px.append(cv2.phaseCorrelate(before, after, cv2.createHanningWindow(before.shape[::-1], cv2.CV_64F))[0])
    across, down = np.abs(moved_px).max(axis=0)
    assert across < 0.3
    assert 0.5 < down < 4.0 * 320.0 * np.radians(0.5)


def test_the_smooth_step_goes_from_0_to_1() -> None:
    values = [smooth_step(10.0, 20.0, s) for s in (0.0, 10.0, 15.0, 20.0, 30.0)]
    assert values == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
