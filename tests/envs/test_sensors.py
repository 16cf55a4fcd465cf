"""Sensor errors: none by default, of the configured size, hidden from the driver."""

from contextlib import closing
from dataclasses import replace
from math import radians, sin, tan

import numpy as np
import pytest
from short_scenario import SHORT

from vpf_sim import scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.sensors import Sensors
from vpf_sim.evaluation.episode.episode import read
from vpf_sim.evaluation.episode.log import StepLog
from vpf_sim.geometry import project
from vpf_sim.scenarios.parts import Sensors as SensorErrors
from vpf_sim.types import Camera, Floats

CAMERA = Camera()
STATE = np.array([10.0, -20.0, 0.5, 5.0, 0.1])
EXACT = SHORT.partition("[vary]")[0]
ERRING = EXACT + "[ego.sensors]\nposition_noise_m = 0.5\nspeed_scale = 0.1\nyaw_rate_noise_radps = 0.05\n"


def readings(errors: SensorErrors, count: int, seed: int = 1) -> Floats:
    """(n, 5) less the truth."""
    sensors = Sensors(errors, CAMERA, 60.0, seed)
    return np.array([sensors.read(STATE) for _ in range(count)]) - STATE


def test_sensors_are_exact_by_default() -> None:
    frame = np.zeros((480, 640, 3), np.uint8)
    sensors = Sensors(SensorErrors(), CAMERA, 60.0, 1)
    assert sensors.are_exact
    assert sensors.read(STATE) is STATE
    assert sensors.frame(frame) is frame


def test_noise_has_the_configured_sd() -> None:
    errors = SensorErrors(position_noise_m=0.1, heading_noise_deg=1.0, speed_noise_mps=0.2, yaw_rate_noise_radps=0.03)
    found = readings(errors, 4000)
    assert found.std(axis=0) == pytest.approx([0.1, 0.1, radians(1.0), 0.2, 0.03], rel=0.05)
    assert np.abs(found.mean(axis=0)).max() < 0.02


def test_scale_and_bias_are_drawn_once_and_differ_from_seed_to_seed() -> None:
    errors = SensorErrors(speed_scale=0.02, yaw_rate_bias_radps=0.01)
    ends = np.array([readings(errors, 1, seed)[0] for seed in range(300)])
    assert np.ptp(readings(errors, 50), axis=0) == pytest.approx(np.zeros(5))
    assert ends[:, 3].std() == pytest.approx(0.02 * 5.0, rel=0.15)
    assert ends[:, 4].std() == pytest.approx(0.01, rel=0.15)


def test_random_walk_grows_with_the_root_of_time() -> None:
    errors = SensorErrors(position_walk_m=0.3, heading_walk_deg=2.0)
    after = np.array([readings(errors, 240, seed)[[59, 239]] for seed in range(200)])
    assert after[:, 0, 0].std() == pytest.approx(0.3, rel=0.15)
    assert after[:, 1, 1].std() == pytest.approx(0.6, rel=0.15)
    assert after[:, 0, 2].std() == pytest.approx(radians(2.0), rel=0.15)


def test_mounting_pitch_moves_points_to_their_projection() -> None:
    errors, seed = SensorErrors(mounting_deg=1.0), 3
    frame = np.zeros((480, 640, 3), np.uint8)
    dot = (420, 300)
    frame[dot[1] - 1 : dot[1] + 2, dot[0] - 1 : dot[0] + 2] = 255
    seen = Sensors(errors, CAMERA, 60.0, seed).frame(frame)[..., 0].astype(float)
    rows, columns = np.mgrid[:480, :640]
    found = np.array([(seen * columns).sum(), (seen * rows).sum()]) / seen.sum()
    ray = np.array([(dot[0] - CAMERA.cx_px) / CAMERA.fx_px, (dot[1] - CAMERA.cy_px) / CAMERA.fy_px])
    forward = 1.0 / ray[1] * CAMERA.height_m  # the point of the road there
    point = np.array([[CAMERA.forward_m + forward, ray[0] * forward, 0.0]])
    shifts = [project(replace(CAMERA, pitch_rad=pitch), point)[0] - found for pitch in np.linspace(-0.06, 0.06, 2401)]
    assert min(np.abs(shift).max() for shift in shifts) < 0.05
    assert np.abs(found - dot).max() > 0.5


def test_body_pitch_has_its_sd_and_is_smooth() -> None:
    sensors = Sensors(SensorErrors(pitch_deg=0.4), CAMERA, 60.0, 5)
    pitches = []
    for _ in range(12000):
        sensors.frame(None)
        pitches.append(sensors.pitch_rad)
    assert np.std(pitches) == pytest.approx(radians(0.4), rel=0.15)
    assert np.std(np.diff(pitches)) < 0.25 * np.std(pitches)
    assert tan(np.std(pitches)) * CAMERA.fy_px == pytest.approx(2.2, rel=0.2)  # px at the horizon
    assert sin(max(pitches)) < radians(2.5)


def test_driver_gets_measurements_and_the_log_the_truth() -> None:
    with closing(FourLane(scenarios.parse(ERRING, "erring"), frames=False)) as env:
        observed, info = env.reset(seed=4)
        log = StepLog()
        measured = []
        for _ in range(20):
            observation = read(observed)
            log.observe(observation, info, env, used=True)
            measured.append(observation)
            observed, *_, info = env.step(np.zeros(2))
            assert info["ego"][:2] == pytest.approx(env.ego.position)
        table = log.table()
        assert table.x_m == pytest.approx(5.0 + 5.55 / 60.0 * np.arange(20))
        assert np.std([one.y_m for one in measured]) == pytest.approx(0.5, rel=0.5)
        assert np.abs(table.y_m - 1.75).max() == 0.0
        assert abs(measured[0].speed_mps - 5.55) > 0.01


def test_exact_sensors_change_nothing() -> None:
    with closing(FourLane(scenarios.parse(EXACT, "exact"), frames=False)) as env:
        observed, info = env.reset(seed=4)
        assert "ego" not in info
        assert observed["ego"] == pytest.approx([5.0, 1.75, 0.0, 5.55, 0.0])
