"""Lanes of oncoming traffic: a solid line on the left, with a lane and another solid line beyond."""

from contextlib import closing

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim import drivers, scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.types import RoadEdges

WEATHERS = ("clear", "rain", "ClearNight")
BEGINS, ENDS = 150, 300  # frames; 14 m are enough to know the road


def tracked(scenario: str, weather: str, seed: int, frames: int) -> list[RoadEdges]:
    """The road along which the PID drives, frame by frame."""
    pilot = drivers.create("pid")
    seen = []
    with closing(FourLane(scenarios.parse(scenario, "road.toml"), weather)) as env:
        observed, _ = env.reset(seed=seed)
        setup = setup_for(pilot, env, seed)
        pilot.reset(setup)
        tracker = RoadEdgeTracker(setup.camera, ROBUST.road_edges, setup.rate_hz)
        for _ in range(frames):
            now = read(observed)
            pose = np.array([now.x_m, now.y_m, now.yaw_rad])
            seen.append(tracker.update(now.image, grey(now.image), pose, now.speed_mps, now.yaw_rate_radps, None))
            command = drivers.command_of(pilot, now)
            observed, *_ = env.step(np.array([command.throttle, command.steering]))
    return seen[BEGINS:]


@pytest.mark.parametrize(
    ("seed", "weather"),
    [(0, "clear"), (1, "rain"), *(pytest.param(k, w, marks=pytest.mark.slow) for k in (2, 3) for w in WEATHERS)],
)
def test_the_solid_line_before_oncoming_traffic_is_the_left_edge(seed: int, weather: str) -> None:
    roads = tracked('base = "oncoming"\nschema = 1\nbodies = []\n', weather, seed, ENDS)
    assert np.mean([abs(road.oncoming_m - 3.5) < 0.3 for road in roads]) > 0.9
    assert np.mean([abs(road.right_m - road.left_m - 3.5) < 0.3 for road in roads]) > 0.9


@pytest.mark.parametrize(
    ("base", "weather"),
    [
        ("curve-left", "clear"),
        ("town04-clean", "rain"),
        *(pytest.param(base, w, marks=pytest.mark.slow) for base in ("straight", "town04") for w in WEATHERS),
    ],
)
def test_a_road_of_one_direction_has_none(base: str, weather: str) -> None:
    roads = tracked(f'base = "{base}"\nschema = 1\n', weather, 2, ENDS)
    assert not any(road.oncoming_m for road in roads)
