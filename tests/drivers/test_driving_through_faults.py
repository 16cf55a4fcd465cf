"""`vpf` with a camera that fails: it drives on through lost and late frames, and stops where none can be trusted."""

from contextlib import closing

import numpy as np
import pytest

from vpf_sim import drivers, scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.types import Floats


def driven(faults: str, steps: int) -> Floats:
    """(n, 2) speed, m/s, and offset from the lane's middle, m, of each step."""
    scenario = scenarios.parse(f'base = "straight"\n[ego.sensor_faults]\n{faults}\n', "my.toml")
    driver = drivers.create("vpf")
    with closing(FourLane(scenario)) as env:
        observed, info = env.reset(seed=1)
        driver.reset(setup_for(driver, env, 1))
        rows = []
        for _ in range(steps):
            command = driver.act(read(observed))
            observed, *_, info = env.step(np.array([command.throttle, command.steering]))
            rows.append((env.ego.speed, info["lane_offset_m"]))
    return np.array(rows)


def test_it_keeps_lane_and_speed_through_lost_and_late_frames() -> None:
    speed, offset = driven("drop_share = 0.1\nlatency_ms = 100", 90).T
    assert speed.min() > 4.5
    assert np.abs(offset).max() < 0.5


@pytest.mark.parametrize("faults", ["freeze_share = 1.0", "drop_share = 1.0"])
def test_it_stops_where_no_frame_is_new(faults: str) -> None:
    """0.5 s at 5.55 m/s, then no less than 1.5 m/s2 on average."""
    speed, offset = driven(faults, 250).T
    assert speed[:25].min() > 5.0
    assert speed[-1] < 0.3
    assert np.abs(offset).max() < 0.5
