"""Train a driver by reward: PPO learns to steer on `straight` and `curve-left`, and is exported to ONNX.

python train_ppo.py FOLDER writes FOLDER/policy.onnx and FOLDER/policy.toml. Then

    vpf-sim drive curve-left --driver onnx:FOLDER/policy.onnx

It needs `pip install 'vpf_sim[learn]'`. PPO is Stable-Baselines3's; the throttle is not learned, it holds a speed.
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import cv2
import gymnasium
import numpy as np
from gymnasium import spaces

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.logger import configure
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from stable_baselines3.common.vec_env import SubprocVecEnv
    from torch import Tensor, nn
except ModuleNotFoundError as missing:
    sys.exit(f"train_ppo.py: {missing}: pip install 'vpf_sim[learn]'")

from behaviour_cloning.export import commit, export
from vpf_sim.drivers.learned.familiarity import learned_from
from vpf_sim.drivers.learned.manifest import LearnedFrom, Manifest, PictureInput, StateInput, Training
from vpf_sim.envs.learning import FourLanePixels, RewardWeights
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import parse_seeds
from vpf_sim.policy_state import SPEED_SCALE_MPS, STATE
from vpf_sim.types import Image

SCENARIOS, WEATHERS = ("straight", "curve-left"), ("clear", "rain")
WIDTH_PX, HEIGHT_PX, REPEAT = 64, 48, 6  # 4:3 as in the drives; ticks of 1/60 s
SPEED_MPS, STEERING = 5.55, 0.25  # to hold; of full steering, that an action of 1 means
LOST_M = 2.5  # from the lane's centre; an episode of training ends there
REWARD = RewardWeights(progress=0.1, lane=0.2, comfort=0.02)
MANIFEST = Manifest(
    schema=1,
    rate_hz=60.0 / REPEAT,
    summary="a small network that learned to keep its lane by reward",
    image=PictureInput(width_px=WIDTH_PX, height_px=HEIGHT_PX, deviation=1.0),
    state=StateInput(values=STATE),  # type: ignore[arg-type]
)


class LaneKeeping(gymnasium.Wrapper[Any, Any, Any, Any]):
    """The environment with the steering as the only action, and pictures drawn `shrink` times larger than observed."""

    def __init__(self, shrink: int, scenarios: Sequence[str] = SCENARIOS, weathers: Sequence[str] = WEATHERS) -> None:
        size = (shrink * WIDTH_PX, shrink * HEIGHT_PX)
        super().__init__(FourLanePixels(scenarios, weathers, size, action_repeat=REPEAT, state=True, reward=REWARD))
        image = spaces.Box(0, 255, (HEIGHT_PX, WIDTH_PX, 1), np.uint8)
        self.observation_space = spaces.Dict({"image": image, "state": self.unwrapped.observation_space["state"]})
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)

    def reset(self, **options: Any) -> tuple[Any, dict[str, Any]]:
        observed, info = super().reset(**options)
        return _shrunk(observed), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """One decision."""
        world: Any = self.unwrapped
        command = np.array([SPEED_MPS - world.world.ego.speed, STEERING * float(action[0])]).clip(-1.0, 1.0)
        observed, reward, terminated, truncated, info = super().step(command)
        return _shrunk(observed), reward, terminated or abs(info["lane_offset_m"]) > LOST_M, truncated, info


def _shrunk(observed: dict[str, Any]) -> dict[str, Any]:
    """The observation with its picture averaged over areas, as a drive's picture is for its policy."""
    image = cv2.resize(observed["image"], (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
    return {**observed, "image": image.reshape(HEIGHT_PX, WIDTH_PX, 1)}


class Features(BaseFeaturesExtractor):
    """What the policy sees of a picture, with the state: a twentieth of the work of the library's network."""

    def __init__(self, space: spaces.Dict, features: int = 64) -> None:
        super().__init__(space, features + len(STATE))
        self.picture = nn.Sequential(
            nn.Conv2d(1, 16, 5, stride=3),
            nn.ReLU(),
            nn.Conv2d(16, 32, 3, stride=2),
            nn.ReLU(),
            nn.Conv2d(32, 32, 3, stride=2),
            nn.ReLU(),
            nn.Flatten(),
            nn.Linear(384, features),
            nn.ReLU(),
        )

    def forward(self, observed: dict[str, Tensor]) -> Tensor:
        return torch.cat([self.picture(observed["image"]), observed["state"]], dim=1)


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
    began_s, made_from = perf_counter(), commit()
    torch.set_num_threads(1)
    worlds = make_vec_env(
        LaneKeeping, options.workers, options.seed, env_kwargs={"shrink": options.shrink}, vec_env_cls=SubprocVecEnv
    )
    learned = PPO(
        "MultiInputPolicy",
        worlds,
        n_steps=options.steps_of_an_update,
        batch_size=128,
        n_epochs=5,
        gamma=0.98,
        learning_rate=lambda left: 3e-4 * left,
        policy_kwargs={"features_extractor_class": Features, "log_std_init": -1.0},
        seed=options.seed,
        device="cpu",
    )
    options.out.mkdir(parents=True, exist_ok=True)
    learned.set_logger(configure(str(options.out), ["stdout", "csv"]))  # progress.csv: the learning curve
    learned.learn(options.steps)
    worlds.close()
    learned.save(options.out / "policy.zip")  # to train on
    known = learned_from(*shown(options.shrink, learned, options.test_seeds))
    manifest = recorded(options, known, made_from, learned.num_timesteps, (perf_counter() - began_s) / 3600.0)
    export(Command(learned.policy), manifest, options.out / "policy.onnx")
    for scenario, weather in product(SCENARIOS, WEATHERS):
        count = arrivals(LaneKeeping(options.shrink, (scenario,), (weather,)), learned, options.test_seeds)
        print(f"{scenario}, {weather}, {count} of {len(options.test_seeds)} arrive without noise")


def arrivals(world: LaneKeeping, learned: PPO, seeds: Iterable[int]) -> int:
    """How many drives arrive, one for each seed, without the noise of training."""
    count = 0
    for seed in seeds:
        observed, info = world.reset(seed=seed)
        over = False
        while not over:
            action, _ = learned.predict(observed, deterministic=True)
            observed, _, terminated, truncated, info = world.step(action)
            over = terminated or truncated
        count += info["is_success"]
    return count


def shown(shrink: int, learned: PPO, seeds: Iterable[int]) -> tuple[list[Image], list[float]]:
    """Pictures (1, H, W) of drives of the learned policy, one in ten, and all of their speeds, m/s."""
    world = LaneKeeping(shrink, SCENARIOS, WEATHERS)
    pictures, speeds = [], []
    for seed in seeds:
        observed, _ = world.reset(seed=seed)
        over = False
        while not over:
            if len(speeds) % 10 == 0:
                pictures.append(observed["image"].transpose(2, 0, 1))
            speeds.append(SPEED_SCALE_MPS * float(observed["state"][STATE.index("speed")]))
            action, _ = learned.predict(observed, deterministic=True)
            observed, _, terminated, truncated, _ = world.step(action)
            over = terminated or truncated
    return pictures, speeds


def recorded(
    options: argparse.Namespace, known: LearnedFrom, made_from: str, decisions: int, wall_h: float
) -> Manifest:
    """The manifest with the record of the training."""
    training = Training(
        command=f"python examples/train_ppo.py FOLDER --steps {options.steps} --shrink {options.shrink} "
        f"--seed {options.seed} --workers {options.workers} --steps-of-an-update {options.steps_of_an_update}",
        commit=made_from,
        scenarios=SCENARIOS,
        weathers=WEATHERS,
        frames=decisions,
        driven_h=round(decisions / MANIFEST.rate_hz / 3600.0, 2),
        wall_h=round(wall_h, 2),
    )
    return replace(MANIFEST, learned_from=known, training=training)


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 up, got {text!r}")
    return int(text)


def _seeds(text: str) -> Sequence[int]:
    try:
        return parse_seeds(text, "A:B")
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", type=Path, metavar="FOLDER")
    parser.add_argument("--steps", type=_positive, default=250_000, help="decisions, at 10 a second")
    parser.add_argument("--steps-of-an-update", type=_positive, default=1024, help="of each process")
    parser.add_argument(
        "--shrink", type=_positive, default=1, help="draw pictures so many times larger, and average them"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--test-seeds", type=_seeds, default="900:905", help="of the drives after training")
    parser.add_argument("--workers", type=_positive, default=2, help="processes that drive")
    main(parser.parse_args())
