"""Decisions a second of `vpf_sim/FourLanePixels-v0`, by size of the picture, weather and number of environments.

    python scripts/steps_per_second.py [--sizes 84x84 640x480] [--weathers clear rain] [--counts 1 2] [--seconds 4]

Environments drive the scenario `town04` side by side in gymnasium's vector environments, synchronous (one process) and
asynchronous (one process each). Each figure is the fastest of three runs, with the resets of ended episodes; other
programs slow it down, so the load average is printed too.
"""

import argparse
import os
from time import perf_counter

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv

import vpf_sim  # noqa: F401 (registers the environment)

RUNS, WARM_UP = 3, 60
TOWARDS_LANE, DAMPING = 0.1, 1.5  # steering per m beside the lane's centre, and per m of change since the last decision


class LaneKeeper:
    """Steers a vector environment along its lanes by what `info` says."""

    def __init__(self, env: VectorEnv, seed: int) -> None:
        self._env = env
        env.reset(seed=seed)
        self._offset_m = self._before_m = np.zeros(env.num_envs)

    def decide(self, times: int) -> None:
        """Make decisions in every environment."""
        for _ in range(times):
            action = np.zeros((self._env.num_envs, 2), np.float32)
            change_m = self._offset_m - self._before_m
            action[:, 1] = np.clip(-TOWARDS_LANE * self._offset_m - DAMPING * change_m, -1.0, 1.0)
            info = self._env.step(action)[-1]
            self._before_m, self._offset_m = self._offset_m, np.asarray(info["lane_offset_m"])


def rate(count: int, mode: str, size: tuple[int, int], weather: str, seconds: float) -> float:
    """Decisions a second of all environments together."""
    options = {"scenarios": "town04", "weathers": weather, "image_size": size}
    env = gymnasium.make_vec("vpf_sim/FourLanePixels-v0", count, vectorization_mode=mode, **options)
    keeper, best = LaneKeeper(env, seed=3), 0.0
    keeper.decide(WARM_UP)
    for _ in range(RUNS):
        decided, started_s = 0, perf_counter()
        while perf_counter() - started_s < seconds:
            keeper.decide(20)
            decided += 20 * count
        best = max(best, decided / (perf_counter() - started_s))
    env.close()
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", nargs="+", default=["84x84", "160x120", "640x480"])
    parser.add_argument("--weathers", nargs="+", default=["clear", "rain"])
    parser.add_argument("--counts", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--seconds", type=float, default=4.0, help="of each of three runs")
    requested = parser.parse_args()
    kinds = [("sync", requested.counts[0]), *(("async", count) for count in requested.counts)]
    print("| picture | weather | " + " | ".join(f"{mode}, {count}" for mode, count in kinds) + " |")
    print("|---|---|" + "---|" * len(kinds))
    for size in requested.sizes:
        width, height = (int(part) for part in size.split("x"))
        for weather in requested.weathers:
            rates = [rate(count, mode, (width, height), weather, requested.seconds) for mode, count in kinds]
            print(f"| {size} | {weather} | " + " | ".join(f"{value:,.0f}" for value in rates) + " |", flush=True)
    print(f"\nload average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
