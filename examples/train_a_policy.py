"""Train a policy: the cross-entropy method finds two weights that keep a car on a bend by its camera alone.

It takes some seconds on one core. Libraries such as Stable-Baselines3 take the same environment. Prints

    generation 0: median return -4.2, best 11.2
    generation 1: median return -3.5, best 11.2
    generation 2: median return 11.2, best 11.2
    arrives: untrained 0%, trained 100%
"""

# %% A bend, and an environment with small frames
# An observation has `image`, `ego` (x, y, yaw, speed, yaw rate), `goal` and `time`. The reward grows along the route.
import tempfile
from pathlib import Path

import cv2
import gymnasium
import numpy as np

import vpf_sim

bend = Path(tempfile.mkdtemp()) / "bend.toml"
bend.write_text("""schema = 1
road = {lanes = 2, segments = [{kind = "arc", length_m = 100, radius_m = -60}]}
ego = {lane = 1, s_m = 10.0}
goal = {s_m = 70.0}
vary = {"ego.lateral_m" = [-0.5, 0.5]}
""")
env = gymnasium.make("vpf_sim/FourLane-v0", scenario=bend, rate_hz=20.0, rig=vpf_sim.Rig(vpf_sim.Camera(64, 48)))


# %% A policy: the steering is linear in the share of grass right of the middle, just below the horizon
def command(weights, image, speed_mps):
    part = image[26:34, 32:].astype(float)
    verge = part[..., 0] - part[..., 2] > 20.0  # more red than blue; asphalt and paint are grey
    return np.clip([5.55 - speed_mps, weights @ [verge.mean(), 1.0]], -1.0, 1.0)


def total_reward(weights, seed):
    (observation, _), total, over = env.reset(seed=seed), 0.0, False
    while not over:
        action = command(weights, observation["image"], observation["ego"][3])
        observation, reward, terminated, truncated, _ = env.step(action)
        total, over = total + reward, terminated or truncated
    return total


# %% Train: draw weights, keep the best, draw about them
random, mean, spread = np.random.default_rng(0), np.zeros(2), np.array([0.5, 0.2])
for generation in range(3):
    drawn = mean + spread * random.standard_normal((8, 2))
    returns = np.array([total_reward(weights, seed=generation) for weights in drawn])
    print(f"generation {generation}: median return {np.median(returns):.1f}, best {returns.max():.1f}")
    elite = drawn[np.argsort(returns)[-3:]]
    mean, spread = elite.mean(axis=0), elite.std(axis=0) + 0.01


# %% Drive on other seeds
class Policy(vpf_sim.Driver):
    """The weights, on the camera's frames made as small as in training."""

    def __init__(self, weights):
        self.weights = weights

    def act(self, observation):
        small = cv2.resize(observation.image, (64, 48), interpolation=cv2.INTER_AREA)
        return vpf_sim.Command(*command(self.weights, small, observation.speed_mps))


policies = {"untrained": Policy(np.zeros(2)), "trained": Policy(mean)}
drives = {name: [vpf_sim.drive(bend, driver=one, seed=seed) for seed in (100, 101)] for name, one in policies.items()}
arrived = {name: np.mean([one.status == "success" for one in drives[name]]) for name in drives}
print(f"arrives: untrained {arrived['untrained']:.0%}, trained {arrived['trained']:.0%}")
drives["trained"][0].picture()
