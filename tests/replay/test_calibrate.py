"""Estimates of mounting, speed and yaw rate on a drawn street."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import recorded_street as street

from vpf_sim.replay import calibrate, fixed_structure, rectify
from vpf_sim.replay.recording import Frame
from vpf_sim.replay.rectify import Lens, Mounting
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

FRAMES, RATE_HZ = 30, 20.0
SPEED_MPS = 8.0
LENS = Lens(street.WIDTH, street.HEIGHT, street.FOCAL, street.FOCAL, *street.CENTRE)
ASKEW = Mounting(pitch_rad=0.06, yaw_rad=-0.05, height_m=street.CAMERA_HEIGHT_M)
TIMES_S = np.arange(FRAMES) / RATE_HZ


def drive(yaw_rate_radps: float) -> list[Frame]:
    """Frames of the street on an arc, from a camera at the car's axle."""
    frames = []
    place, yaw = np.zeros(3), 0.0
    for k in range(FRAMES):
        turn = street._about(1, yaw) @ rectify.rotation(ASKEW)
        grey = street.draw(np.column_stack([turn, place]))
        frames.append(Frame(k, np.repeat(grey[..., None], 3, axis=2)))
        course = yaw + 0.5 * yaw_rate_radps / RATE_HZ
        place = place + SPEED_MPS / RATE_HZ * np.array([np.sin(course), 0.0, np.cos(course)])
        yaw += yaw_rate_radps / RATE_HZ
    return frames


@pytest.fixture(scope="module")
def straight() -> list[Frame]:
    return drive(0.0)


@pytest.fixture(scope="module")
def bend() -> list[Frame]:
    return drive(0.25)


def estimated(
    frames: list[Frame], speed_mps: Floats | None, yaw_rate_radps: Floats | None
) -> calibrate.FlowCalibration:
    camera, _ = rectify.rectified(LENS, Mounting(height_m=street.CAMERA_HEIGHT_M))
    return calibrate.estimate(iter(frames), camera, TIMES_S, speed_mps, yaw_rate_radps)


def test_mounting_is_estimated_with_and_without_recorded_motion(straight: list[Frame]) -> None:
    for yaw_rate in (None, np.zeros(FRAMES)):
        own = estimated(straight, None if yaw_rate is None else yaw_rate + SPEED_MPS, yaw_rate)
        assert own.observations > 10
        assert own.mounting.pitch_rad == pytest.approx(0.06, abs=0.006)
        assert own.mounting.yaw_rad == pytest.approx(-0.05, abs=0.006)
        assert own.mounting.height_m == street.CAMERA_HEIGHT_M


@pytest.mark.parametrize("height_m", [0.4, 0.6, 6.0])
def test_mounting_does_not_depend_on_a_doubtful_scale(straight: list[Frame], height_m: float) -> None:
    """With a wrong height the speed and all metres are wrong, but not the angles."""
    camera, _ = rectify.rectified(LENS, Mounting(height_m=height_m))
    own = calibrate.estimate(iter(straight), camera, TIMES_S, None, None)
    assert own.mounting.pitch_rad == pytest.approx(0.06, abs=own.pitch.half_width_rad)
    assert own.mounting.yaw_rad == pytest.approx(-0.05, abs=own.yaw.half_width_rad)


def test_speed_and_yaw_rate_follow_from_the_images(straight: list[Frame]) -> None:
    own = estimated(straight, None, None)
    assert np.nanmedian(own.speed_mps) == pytest.approx(SPEED_MPS, rel=0.08)
    assert np.nanmedian(own.yaw_rate_radps) == pytest.approx(0.0, abs=0.01)


def test_bend_with_recorded_yaw_rate_gives_the_mounting(bend: list[Frame]) -> None:
    """The direction of travel is separated from the rotation of the image."""
    own = estimated(bend, np.full(FRAMES, SPEED_MPS), np.full(FRAMES, 0.25))
    assert own.mounting.pitch_rad == pytest.approx(0.06, abs=0.01)
    assert own.mounting.yaw_rad == pytest.approx(-0.05, abs=0.01)
    assert np.nanmedian(own.yaw_rate_radps) == pytest.approx(0.25, abs=0.02)


def test_short_bend_without_yaw_rate_gives_no_yaw(bend: list[Frame]) -> None:
    """A turn looks like a sideways direction, so without straight road there is no yaw."""
    own = estimated(bend, np.full(FRAMES, SPEED_MPS), None)
    assert not own.yaw.is_used
    assert own.mounting.yaw_rad == 0.0
    assert own.yaw.seconds == 0.0
    assert own.mounting.pitch_rad == pytest.approx(0.06, abs=0.01)


def test_interval_contains_the_mounting(straight: list[Frame]) -> None:
    own = estimated(straight, None, None)
    assert own.pitch.is_used
    assert own.yaw.is_used
    assert abs(own.pitch.rad - 0.06) < own.pitch.half_width_rad
    assert abs(own.yaw.rad + 0.05) < own.yaw.half_width_rad


def test_camera_ahead_of_axle_moves_outward_in_a_bend(bend: list[Frame]) -> None:
    """For a camera assumed 2 m before the axle, the same images mean a yaw to the inside."""
    camera, _ = rectify.rectified(LENS, Mounting(height_m=street.CAMERA_HEIGHT_M))
    motion = (np.full(FRAMES, SPEED_MPS), np.full(FRAMES, 0.25))
    there, before = (calibrate.estimate(iter(bend), camera, TIMES_S, *motion, ahead_m) for ahead_m in (0.0, 2.0))
    assert before.mounting.yaw_rad - there.mounting.yaw_rad == pytest.approx(2.0 * 0.25 / SPEED_MPS, abs=0.005)


def test_gaps_and_standstill_are_ignored(straight: list[Frame]) -> None:
    def with_gaps() -> Iterator[Frame]:
        return (replace(frame, image=None) if frame.index % 7 == 3 else frame for frame in straight)

    camera, _ = rectify.rectified(LENS, Mounting())
    own = calibrate.estimate(with_gaps(), camera, TIMES_S, np.full(FRAMES, SPEED_MPS), np.zeros(FRAMES))
    assert own.observations > 10
    standing = calibrate.estimate(iter(straight), camera, TIMES_S, np.zeros(FRAMES), np.zeros(FRAMES))
    assert standing.observations == 0


def test_stopped_car_has_zero_speed(straight: list[Frame]) -> None:
    """Without road flow there is no speed to interpolate."""
    noise = stream(0, "noise of a camera that stands")
    stationary = [
        Frame(FRAMES + k, np.clip(straight[-1].image + noise.normal(0.0, 1.0, (240, 400, 1)), 0, 255).astype(np.uint8))
        for k in range(20)
        if straight[-1].image is not None
    ]
    times = np.arange(FRAMES + 20) / RATE_HZ
    camera, _ = rectify.rectified(LENS, Mounting(height_m=street.CAMERA_HEIGHT_M))
    fixed = fixed_structure.find(iter(straight), times)
    own = calibrate.estimate(iter([*straight, *stationary]), camera, times, None, None, fixed=fixed)
    assert np.nanmedian(own.speed_mps[:FRAMES]) == pytest.approx(SPEED_MPS, rel=0.08)
    assert own.speed_mps[-12:] == pytest.approx(np.zeros(12))
    assert own.yaw_rate_radps[-12:] == pytest.approx(np.zeros(12))
