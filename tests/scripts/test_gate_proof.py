"""The degraded drivers of the gate's proof change what they say, and nothing else."""

import runpy
from dataclasses import replace
from math import atan2, degrees
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.types import Camera, VehicleModel

SCRIPTS = Path(__file__).parents[2] / "scripts" / "studies" / "gate"
SCRIPT = runpy.run_path(str(SCRIPTS / "degraded_drivers.py"))
IMAGE = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
SEEN = Observation(IMAGE, 1.0, 2.0, 3.0, 0.1, 5.0, 0.2, (100.0, 0.0))
SETUP = DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (100.0, 0.0), seed=0)


def driver(name: str) -> Any:
    """A degraded driver at the start of an episode."""
    made = SCRIPT[name]()
    made.reset(SETUP)
    return made


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(SCRIPTS))


def test_ten_degradations_are_drivers_without_privilege() -> None:
    assert len(SCRIPT["DEGRADED"]) == 10
    for name in SCRIPT["DEGRADED"].values():
        assert drivers.create(name).privileged == "none"


@pytest.mark.parametrize(
    ("name", "given", "done"),
    [
        ("SteeringBias", Command(0.3, -0.1), Command(0.3, -0.1 + 2.0 / 40.0)),
        ("CoarseSteering", Command(0.3, 0.26), Command(0.3, 0.3)),
        ("CoarseSteering", Command(0.3, 0.04), Command(0.3, 0.0)),
        ("WeakBrakes", Command(-0.8, 0.1), Command(-0.2, 0.1)),
        ("WeakBrakes", Command(0.8, 0.1), Command(0.8, 0.1)),
    ],
)
def test_a_command_is_changed(name: str, given: Command, done: Command) -> None:
    assert driver(name).command(given) == done


def test_commands_are_late_by_three_tenths_of_a_second() -> None:
    late, commands = driver("LateCommands"), [Command(0.01 * i, 0.0) for i in range(40)]
    carried_out = [late.command(command) for command in commands]
    assert carried_out[18:] == commands[:-18]


def test_frames_are_a_quarter_of_a_second_old_and_stamped_as_new() -> None:
    stale = driver("StaleFrames")
    for i in range(40):
        image = np.full((4, 6, 3), i, np.uint8)
        found = stale.observation(replace(SEEN, image=image, time_s=i / 60.0, frame_time_s=i / 60.0))
    assert found.image[0, 0, 0] == 39 - 15
    assert found.frame_time_s == 39 / 60.0


def test_the_yaw_rate_has_the_other_sign() -> None:
    found = driver("YawRateSign").observation(SEEN)
    assert (found.yaw_rate_radps, found.yaw_rad, found.speed_mps) == (-0.2, 0.1, 5.0)


def test_the_mounting_is_off_by_two_degrees() -> None:
    """What is straight ahead is taken to be 2 degrees to the left."""
    camera = driver("WrongMounting").setup(SETUP).camera
    ahead_px = SETUP.camera.cx_px
    assert degrees(atan2(ahead_px - camera.cx_px, camera.fx_px)) == pytest.approx(-2.0)


def test_frames_are_shifted_by_about_a_pixel() -> None:
    noisy, ramp = driver("NoisyFlow"), np.tile(np.arange(64, dtype=np.uint8)[None, :, None] * 3, (48, 1, 3))
    found = [noisy.observation(replace(SEEN, image=ramp)).image for _ in range(200)]
    shifts_px = [(float(ramp[24, 32, 0]) - float(image[24, 32, 0])) / 3.0 for image in found]
    assert np.std(shifts_px) == pytest.approx(1.0, abs=0.2)
