"""The PID's own run, for the paired protocol: the same scenario and seed with the obstacles removed.

The PID uses no frames, so none is rendered and the run takes a fraction of a second.
"""

from contextlib import closing
from typing import NamedTuple

import numpy as np

from vpf_sim import drivers
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.metrics.tracking import at_distance
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.scenarios import DrawnScenario
from vpf_sim.types import Floats, Image

NO_IMAGE: Image = np.empty((0, 0, 3), np.uint8)


class PidRun(NamedTuple):
    """(N,) the PID's positions along its route, m, and its commands there."""

    route_m: Floats
    throttle: Floats
    steering: Floats


def pid_without_obstacles(drawn: DrawnScenario, seed: int, rate_hz: float = 60.0) -> PidRun:
    """Drive the PID to the goal, or until the scenario's time limit."""
    with closing(FourLane(drawn.without_objects(), rate_hz=rate_hz, frames=False)) as env:
        env.reset(seed=seed)
        pid = drivers.create("pid")
        pid.reset(
            DriverSetup(
                env.camera, env.vehicle_model, rate_hz, env.speed_reference_mps, env.goal_m, seed, env.route.copy()
            )
        )
        rows: list[tuple[float, float, float]] = []
        while env.route_m < env.route_length_m and len(rows) < drawn.time_limit_s * rate_hz:
            command = pid.act(_observation(env, len(rows) / rate_hz))
            rows.append((env.route_m, command.throttle, command.steering))
            env.advance(np.array([command.throttle, command.steering]))
    return PidRun(*np.array(rows).T)


def matched(table: StepTable, pid_run: PidRun) -> StepTable:
    """The table with the PID's commands of its own run at each row's distance; nan in the last row."""
    columns = {}
    for name in ("throttle", "steering"):
        own = at_distance(table.route_m, pid_run.route_m, getattr(pid_run, name))
        columns[f"paired_{name}"] = np.append(own[:-1], np.nan)
    return table.replaced(columns)


def _observation(env: FourLane, time_s: float) -> Observation:
    ego = env.ego
    x_m, y_m = ego.position.tolist()
    return Observation(NO_IMAGE, time_s, x_m, y_m, ego.heading, ego.speed, ego.yaw_rate_radps, env.goal_m)
