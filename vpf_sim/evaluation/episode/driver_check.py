"""Smoke test of a driver: a short episode without and with an obstacle."""

from contextlib import closing
from traceback import format_exc

import numpy as np

from vpf_sim import drivers, process_state, scenarios
from vpf_sim.driver_interface import Driver
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError, cause
from vpf_sim.evaluation.episode.episode import read, setup_for

MOST_FRAMES = 90
ROAD = """schema = 1
[road]
lanes = 3
lane_width_m = 3.5
segments = [{kind = "line", length_m = 80}]
[ego]
lane = 2
s_m = 5.0
speed_mps = 5.55
speed_reference_mps = 5.55
[goal]
s_m = 13.0
"""
CAR = '[[bodies]]\nkind = "car"\ns_m = 30.0\nlane = 2\n'
ROADS = {"without obstacles": ROAD, "with an obstacle": ROAD + CAR}


def check(name: str) -> Driver:
    """The driver, after the smoke test; InputError with code position and frame where it fails."""
    with process_state.preserved():
        for what, text in ROADS.items():
            driver = drivers.create(name)
            _drive(driver, f"driver '{name}': {what}", text)
    return driver


def _drive(driver: Driver, where: str, text: str) -> None:
    """Drive to the goal, or for MOST_FRAMES."""
    with closing(FourLane(scenarios.parse(text, "check.toml"), frames=drivers.uses_images(driver))) as env:
        observed, _ = env.reset(seed=0)
        stage = "reset"
        try:
            driver.reset(setup_for(driver, env, 0))
            for frame in range(MOST_FRAMES):
                stage = f"frame {frame}"
                command = drivers.command_of(driver, read(observed))
                drivers.trace_of(driver)
                with_frame = drivers.needs_next_frame(driver)
                observed, _, terminated, truncated, _ = env.step(
                    np.array([command.throttle, command.steering]), with_frame=with_frame
                )
                if terminated or truncated:
                    break
        except (Exception, SystemExit) as error:
            raise InputError(f"{where}: {stage}: {cause(format_exc())}") from error
