"""Train a driver by reward: PPO learns to steer on `straight` and `curve-left`, and is exported to ONNX.

python train_ppo.py FOLDER writes FOLDER/policy.onnx and FOLDER/policy.toml. Then

    vpf-sim drive curve-left --driver onnx:FOLDER/policy.onnx

It needs `pip install 'vpf_sim[learn]'`. PPO is Stable-Baselines3's; the throttle is not learned, it holds a speed.
"""

import argparse
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv
from torch import Tensor, nn

from behaviour_cloning.export import export
from vpf_sim.drivers.learned.manifest import Manifest, PictureInput, StateInput
from vpf_sim.envs.learning import FourLanePixels, RewardWeights
from vpf_sim.policy_state import SPEED_SCALE_MPS, STATE

WIDTH_PX, HEIGHT_PX, REPEAT = 64, 48, 6  # 4:3 as in the drives; ticks of 1/60 s
SPEED_MPS, STEERING = 5.55, 0.25  # to hold; of full steering, that an action of 1 means
REWARD = RewardWeights(progress=0.05, lane=0.2, comfort=0.02)
MANIFEST = Manifest(
    schema=1,
    rate_hz=60.0 / REPEAT,
    summary="steers by PPO, and holds its speed",
    image=PictureInput(width_px=WIDTH_PX, height_px=HEIGHT_PX, deviation=1.0),
    state=StateInput(values=STATE),  # type: ignore[arg-type]
)


class Steering(gymnasium.ActionWrapper[Any, Any, Any]):
    """The environment with the steering as the only action."""

    def __init__(self) -> None:
        size = (WIDTH_PX, HEIGHT_PX)
        super().__init__(
            FourLanePixels(("straight", "curve-left"), "clear", size, action_repeat=REPEAT, state=True, reward=REWARD)
        )
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)

    def action(self, action: Any) -> Any:
        """Throttle and steering."""
        world: Any = self.unwrapped
        return np.array([SPEED_MPS - world.world.ego.speed, STEERING * float(action[0])]).clip(-1.0, 1.0)


class Command(nn.Module):
    """The policy as a driver's: throttle and steering, of a picture in grey levels and the state."""

    def __init__(self, policy: Any) -> None:
        super().__init__()
        self.policy = policy

    def forward(self, image: Tensor, state: Tensor) -> Tensor:
        features = self.policy.extract_features({"image": image, "state": state})
        steering = STEERING * self.policy.action_net(self.policy.mlp_extractor.forward_actor(features)).clamp(-1.0, 1.0)
        throttle = (SPEED_MPS - SPEED_SCALE_MPS * state[:, :1]).clamp(-1.0, 1.0)
        return torch.cat([throttle, steering], dim=1)


def main(options: argparse.Namespace) -> None:
    torch.set_num_threads(options.workers)
    worlds = make_vec_env(Steering, options.workers, seed=options.seed, vec_env_cls=SubprocVecEnv)
    learned = PPO(
        "MultiInputPolicy",
        worlds,
        n_steps=options.steps_of_an_update,
        batch_size=128,
        n_epochs=5,
        gamma=0.97,
        learning_rate=3e-4,
        policy_kwargs={"log_std_init": -1.0},
        seed=options.seed,
        device="cpu",
        verbose=1,
    )
    learned.learn(options.steps)
    worlds.close()
    options.out.mkdir(parents=True, exist_ok=True)
    export(Command(learned.policy), MANIFEST, options.out / "policy.onnx")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", type=Path, metavar="FOLDER")
    parser.add_argument("--steps", type=int, default=100_000, help="decisions, at 10 a second")
    parser.add_argument("--steps-of-an-update", type=int, default=1024, help="of each process")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2, help="processes that drive, and threads that fit")
    main(parser.parse_args())
