"""Each optional mechanism of egomotion can be switched off in a variant's file."""

from math import isfinite
from pathlib import Path

import pytest
from driver_settings import ROBUST, optional_sections, section_of
from road_picture import RoadPicture

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers import VisionDriver
from vpf_sim.planning.variant import load
from vpf_sim.types import Camera, VehicleModel

SPEED_MPS, RATE_HZ, FRAMES = 5.55, 20.0, 6
SECTIONS = ("flow", "focus_of_expansion")
NEEDED = {"focus_of_expansion.fit"}  # the robust method is this fit


SWITCHES = [f"{section}.{path}" for section in SECTIONS for path in optional_sections(getattr(ROBUST, section))]
SWITCHES = [switch for switch in SWITCHES if switch not in NEEDED]


@pytest.mark.parametrize("switch", SWITCHES)
def test_a_driver_without_one_mechanism_drives(switch: str, tmp_path: Path) -> None:
    *path, key = switch.split(".")
    file = tmp_path / "without.toml"
    file.write_text(f'[{".".join(path)}]\n{key} = "none"\n')
    assert section_of(load(str(file)), switch) is None
    picture, driver = RoadPicture(Camera(), 0.01), VisionDriver(str(file))
    driver.reset(DriverSetup(Camera(), VehicleModel(), RATE_HZ, SPEED_MPS, (200.0, 0.0), 1))
    for i in range(FRAMES):
        pose = picture.pose(i * SPEED_MPS / RATE_HZ, 1.75, 0.0)
        x, y, yaw = pose.tolist()
        command = driver.act(Observation(picture.draw(pose, i), i / RATE_HZ, x, y, yaw, SPEED_MPS, 0.0, (200.0, 0.0)))
        assert isfinite(command.throttle)
        assert isfinite(command.steering)
