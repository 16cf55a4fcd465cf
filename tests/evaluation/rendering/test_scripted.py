"""Scripted drives on a known path."""

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.road import centre_line
from vpf_sim.evaluation.rendering.scripted import Path, ScriptedDrive, smooth_step


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


def test_the_smooth_step_goes_from_0_to_1() -> None:
    values = [smooth_step(10.0, 20.0, s) for s in (0.0, 10.0, 15.0, 20.0, 30.0)]
    assert values == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
