"""Each mechanism of egomotion and road can be switched off in a variant's file."""

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from types import NoneType
from typing import Any, get_args

import pytest
from driver_settings import ROBUST
from road_picture import RoadPicture

from vpf_sim.configuration_fields import keys, sections
from vpf_sim.drivers import FieldDriver
from vpf_sim.planning.variant import load
from vpf_sim.types import Camera, DriverSetup, Observation, VehicleModel

SPEED_MPS, RATE_HZ, FRAMES = 5.55, 20.0, 6
SECTIONS = ("flow", "focus_of_expansion", "camera_pitch", "odometry", "road_edges")
NEEDED = {"focus_of_expansion.fit"}  # the robust method is this fit


def switches(settings: Any, path: str) -> Iterator[str]:
    """Paths of the optional sections, and of those within them."""
    for key, hint in keys(type(settings)).items():
        value, inner = getattr(settings, key), f"{path}.{key}"
        if not sections(hint) or isinstance(value, tuple):
            continue
        if NoneType in get_args(hint) and inner not in NEEDED:
            yield inner
        yield from switches(value, inner)


SWITCHES = [switch for section in SECTIONS for switch in switches(getattr(ROBUST, section), section)]


@pytest.mark.parametrize("switch", [*SWITCHES, "flow.bands", "flow.keyframe_s"])
def test_a_driver_without_one_mechanism_drives(switch: str, tmp_path: Path) -> None:
    *path, key = switch.split(".")
    file = tmp_path / "without.toml"
    file.write_text(f'[{".".join(path)}]\n{key} = "none"\n')
    value: Any = load(str(file))
    for name in (*path, key):
        value = getattr(value, name)
    assert value is None
    picture, driver = RoadPicture(Camera(), 0.01), FieldDriver(str(file))
    driver.reset(DriverSetup(Camera(), VehicleModel(), RATE_HZ, SPEED_MPS, (200.0, 0.0), 1))
    for i in range(FRAMES):
        pose = picture.pose(i * SPEED_MPS / RATE_HZ, 1.75, 0.0)
        x, y, yaw = pose.tolist()
        command = driver.act(Observation(picture.draw(pose, i), i / RATE_HZ, x, y, yaw, SPEED_MPS, 0.0, (200.0, 0.0)))
        assert isfinite(command.throttle)
        assert isfinite(command.steering)
