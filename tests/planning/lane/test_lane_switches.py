"""Each mechanism of the lane planner can be switched off in a variant's file."""

from pathlib import Path

import numpy as np
import pytest
from bicycle import Bicycle
from driver_settings import optional_sections, section_of, unwrap
from ideal import Body, Eyes, Road, perception
from lane_planner import ROBUST, SPEED_MPS, lane_planner

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning import variant
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.types import Camera

RATE_HZ = 10.0
PASS, DEAD_END = (Body(14.0, 0.3), Body(17.0, 4.0, width_m=3.0)), (Body(28.0, 0.0, width_m=3.0), Body(28.0, 2.9))
SCENES = ((0.0, PASS), (20.0, DEAD_END))  # start, obstacles


SWITCHES = sorted(optional_sections(ROBUST))


def load(path: str, folder: Path) -> LanePlannerConfig:
    """`robust` without a mechanism."""
    *outer, key = ["lane_planner", *path.split(".")]
    own = folder / "own.toml"
    own.write_text(f'[{".".join(outer)}]\n{key} = "none"\n')
    return unwrap(variant.load(str(own)).lane_planner)


@pytest.mark.parametrize("path", SWITCHES)
def test_a_planner_without_a_mechanism_drives(path: str, tmp_path: Path) -> None:
    config = load(path, tmp_path)
    assert section_of(ROBUST, path) is not None
    assert section_of(config, path) is None
    for start_m, obstacles in SCENES:
        road, car = Road(), Bicycle(x_m=start_m, speed_mps=0.0, rate_hz=RATE_HZ)
        setup = DriverSetup(Camera(), car.model, RATE_HZ, SPEED_MPS, (1e3, 0.0), 0)
        planner, controller = lane_planner(setup, config), Gtsmc(load_gains("robust"), car.model, RATE_HZ)
        eyes = Eyes(road, obstacles, 16.0)
        for _ in range(60):
            _, reference, _ = planner.step(perception(road.edges(car), eyes.look(car)), car.observe())
            assert np.isfinite([reference.heading_rad, reference.speed_mps]).all()
            assert reference.speed_mps >= 0.0
            car.step(controller.command(car.observe(), reference))
        assert car.x_m > start_m + 1.0 or start_m > 0.0
