"""The road as the tracker of the edges sees it, along which the PID drives."""

from collections.abc import Iterator
from contextlib import closing

import numpy as np
from driver_settings import ROBUST

from vpf_sim import drivers, scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.types import RoadEdges


def followed(scenario: str, weather: str, seed: int, frames: int) -> Iterator[tuple[RoadEdges, FourLane]]:
    """The edges after each frame, and the world, of a scenario given as the text of its file."""
    pilot = drivers.create("pid")
    with closing(FourLane(scenarios.parse(scenario, "road.toml"), weather)) as env:
        observed, _ = env.reset(seed=seed)
        setup = setup_for(pilot, env, seed)
        pilot.reset(setup)
        tracker = RoadEdgeTracker(setup.camera, ROBUST.road_edges, setup.rate_hz, ROBUST.verges)
        for _ in range(frames):
            now = read(observed)
            yield tracker.update(now.image, grey(now.image), now.pose, now.speed_mps, now.yaw_rate_radps, None), env
            command = drivers.command_of(pilot, now)
            observed, *_ = env.step(np.array([command.throttle, command.steering]))
