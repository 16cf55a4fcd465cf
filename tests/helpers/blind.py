"""Episodes of drivers that look at no frame, without rendering any: the physics and the judge alone."""

from contextlib import closing
from typing import NamedTuple

import numpy as np

from vpf_sim import drivers
from vpf_sim.driver_interface import Observation
from vpf_sim.envs.ending import Ending
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.world import build_route
from vpf_sim.evaluation.episode.episode import NO_FRAME, setup_for
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats


class Drive(NamedTuple):
    status: str
    offset_m: Floats  # (N,) right of the lane's centre
    steering: Floats  # (N,) commanded


def drive_blind(scenario: str, name: str, seed: int) -> Drive:
    """From reset to end."""
    with closing(FourLane(scenario, frames=False)) as env:
        env.reset(seed=seed)
        driver = drivers.create(name)
        driver.reset(setup_for(driver, env, seed))
        ending = Ending(env.scenario, build_route(env.scenario, seed), env.rate_hz, env.ego, None, ())
        status, rows = "running", []
        while status == "running":
            ego, time_s = env.ego, len(rows) / env.rate_hz
            state = (*ego.position.tolist(), -wrap_angle(-ego.heading), ego.speed, ego.yaw_rate_radps)
            command = drivers.command_of(driver, Observation(NO_FRAME, time_s, *state, env.goal_m))
            rows.append((env.ego.place[1] - env.scenario.road.lane_offset_m(env.scenario.ego.lane), command.steering))
            env.advance(np.array([command.throttle, command.steering]))
            status = ending.status(env.ego, None)
    offset_m, steering = np.array(rows).T
    return Drive(status, offset_m, steering)
