"""The environment in a gymnasium loop, with the wrappers that learners use.

A camera of 84 x 84 pixels at 20 Hz, its image alone as the observation, grey, and four frames stacked. The policy draws
its actions at random, so the car stands about until the time is over. Prints

    observation (4, 84, 84) uint8, action (2,) float32
    timeout after 2163 steps, return -25.3
"""

from typing import Any

import gymnasium
from gymnasium.spaces import Dict
from gymnasium.wrappers import (
    FrameStackObservation,
    GrayscaleObservation,
    RecordEpisodeStatistics,
    TransformObservation,
)

import vpf_sim


def make() -> gymnasium.Env[Any, Any]:
    rig = vpf_sim.Rig(vpf_sim.Camera(84, 84))
    env = gymnasium.make("vpf_sim/FourLane-v0", scenario="curve-left", rate_hz=20.0, rig=rig)
    assert isinstance(env.observation_space, Dict)
    env = TransformObservation(env, lambda observation: observation["image"], env.observation_space["image"])
    return RecordEpisodeStatistics(FrameStackObservation(GrayscaleObservation(env), 4))


def main() -> None:
    env = make()
    env.action_space.seed(7)
    observation, _ = env.reset(seed=7)
    print(
        f"observation {observation.shape} {observation.dtype}, action {env.action_space.shape} {env.action_space.dtype}"
    )
    over = False
    while not over:
        observation, _, terminated, truncated, info = env.step(env.action_space.sample())
        over = terminated or truncated
    print(f"{info['status']} after {info['episode']['l']} steps, return {info['episode']['r']:.1f}")


if __name__ == "__main__":
    main()
