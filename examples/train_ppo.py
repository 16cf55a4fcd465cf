"""Train a driver by reward: PPO learns to steer, also past parked cars, and is exported to ONNX.

python train_ppo.py FOLDER writes FOLDER/policy.onnx and FOLDER/policy.toml. Then

    vpf-sim drive town04 --driver onnx:FOLDER/policy.onnx

It needs `pip install 'vpf_sim[learn]'`. PPO is Stable-Baselines3's; the throttle is not learned, it holds a speed.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback, CheckpointCallback
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.logger import configure
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from torch import Tensor, nn
except ModuleNotFoundError as missing:
    sys.exit(f"train_ppo.py: {missing}: pip install 'vpf_sim[learn]'")

from behaviour_cloning.export import commit, export
from vpf_sim import scenarios
from vpf_sim.drivers.learned.driver import shrink
from vpf_sim.drivers.learned.familiarity import learned_from
from vpf_sim.drivers.learned.manifest import Crop, LearnedFrom, Manifest, PictureInput, StateInput, Training
from vpf_sim.envs.learning import FourLanePixels, RewardWeights
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import parse_seeds
from vpf_sim.policy_state import SPEED_SCALE_MPS, STATE
from vpf_sim.scenarios import AnyScenario

SCENARIOS, WEATHERS = ("town04", "straight", "curve-left", "curve-right"), ("clear", "rain")
RATE_HZ, REPEAT = 20.0, 4  # ticks a second, and of a decision
SPEED_MPS, STEERING = 5.55, 0.25  # to hold; of full steering, that an action of 1 means
LOST_M = 4.0  # from the lane's centre; an episode of training ends there
CHECKPOINT = 100_000  # decisions between two policies that are kept
DRIVES_OF_A_ROAD = 8  # in a row: making a road takes as long as 40 decisions
REWARD = RewardWeights(progress=0.1, lane=0.1, comfort=0.5, arrival=0.0)
PICTURE = PictureInput(width_px=64, height_px=24, deviation=1.0, crop=Crop(top_share=45 / 96, bottom_share=93 / 96))
VALUES = ("speed", "yaw_rate", "steering")
MANIFEST = Manifest(
    schema=1,
    rate_hz=RATE_HZ / REPEAT,
    summary="a small network that learned by reward to keep its lane and to pass parked cars",
    image=PICTURE,
    state=StateInput(values=VALUES),
)
STARTS = """schema = 1
base = "{base}"
[vary]
"ego.lateral_m" = [-0.7, 0.7]
"ego.heading_deg" = [-5.0, 5.0]
"ego.s_m" = [0.0, {farthest_m}]
"bodies.s_m" = [-8.0, 8.0]
"bodies.lateral_m" = [-1.0, 1.0]
"""
CAR = '[[bodies]]\nkind = "car"\nlane = 2\ns_m = {s_m}\nlateral_m = {lateral_m}\n'
CARS, BETWEEN_M, LATERAL_M = 5, 38.0, (-2.09, 0.91)  # the two places of town04, by turns


def empty_road(base: str) -> AnyScenario:
    """A scenario without obstacles, begun anywhere."""
    return scenarios.parse(STARTS.format(base=base, farthest_m=120.0), f"{base}, begun anywhere")


def parked_cars(base: str, side: float) -> AnyScenario:
    """A scenario's road with a row of parked cars as on `town04`, or with `side` -1 mirrored."""
    start_m = scenarios.load(base).draw(0).ego.s_m
    places = [(start_m + BETWEEN_M * (index + 0.8), side * LATERAL_M[index % 2]) for index in range(CARS)]
    cars = "".join(CAR.format(s_m=s_m, lateral_m=lateral_m) for s_m, lateral_m in places)
    return scenarios.parse(STARTS.format(base=base, farthest_m=8.0) + cars, f"{base}, parked cars")


def roads() -> list[AnyScenario]:
    """The scenarios of the training."""
    bends = ("town04", "curve-left")
    return [*(parked_cars(*one) for one in product(bends, (1.0, -1.0))), *map(empty_road, SCENARIOS[1:])]


class Steering(gymnasium.Wrapper[Any, Any, Any, Any]):
    """The environment with steering as the only action, and a driver's inputs, of pictures drawn `scale` times larger.

    An arrival truncates: what would come after it counts.
    """

    def __init__(self, scale: int, on: Sequence[str | AnyScenario], weathers: Sequence[str] = WEATHERS) -> None:
        size = (scale * PICTURE.width_px, scale * PICTURE.width_px * 3 // 4)  # 4:3 as in the drives
        super().__init__(
            FourLanePixels(
                on,
                weathers,
                size,
                grey=False,
                action_repeat=REPEAT,
                state=True,
                reward=REWARD,
                rate_hz=RATE_HZ,
            )
        )
        image = spaces.Box(0, 255, PICTURE.shape[1:], np.uint8)
        self.observation_space = spaces.Dict({"image": image, "state": spaces.Box(-1.0, 1.0, (len(VALUES),))})
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self._draw, self._drives, self._seed = np.random.default_rng(), 0, 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """The drive of a seed; without one, the last again or another, as `DRIVES_OF_A_ROAD` says."""
        if seed is not None:
            self._draw, self._drives, self._seed = np.random.default_rng(seed), 0, seed
        elif self._drives % DRIVES_OF_A_ROAD == 0:
            self._seed = int(self._draw.integers(2**31))
        self._drives += 1
        observed, info = super().reset(seed=self._seed, options=options)
        return _seen(observed), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """One decision."""
        world: Any = self.unwrapped
        command = np.array([SPEED_MPS - world.world.ego.speed, STEERING * float(action[0])]).clip(-1.0, 1.0)
        observed, reward, terminated, truncated, info = super().step(command)
        if not terminated and abs(info["lane_offset_m"]) > LOST_M:
            return _seen(observed), float(reward) - REWARD.contact, True, truncated, info
        arrives = info["is_success"]
        return _seen(observed), reward, terminated and not arrives, truncated or arrives, info


def _seen(observed: dict[str, Any]) -> dict[str, Any]:
    """What a driver gives its policy."""
    values = observed["state"][[STATE.index(name) for name in VALUES]]
    return {"image": shrink(observed["image"], PICTURE), "state": values}


class Features(BaseFeaturesExtractor):
    """What the policy sees of a picture, with the state: a twentieth of the work of the library's network."""

    def __init__(self, space: spaces.Dict, features: int = 64) -> None:
        super().__init__(space, features + len(VALUES))
        self.picture = nn.Sequential(
            nn.Conv2d(1, 16, 5, stride=2),
            nn.ReLU(),
            nn.Conv2d(16, 32, 3, stride=2),
            nn.ReLU(),
            nn.Conv2d(32, 32, 3, stride=2),
            nn.ReLU(),
            nn.Flatten(),
            nn.Linear(192, features),
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


class StopAt(BaseCallback):
    """Ends the training after some decisions, before the learning rate has fallen to 0."""

    def __init__(self, decisions: int) -> None:
        super().__init__()
        self._decisions = decisions

    def _on_step(self) -> bool:
        return self.num_timesteps < self._decisions


def main(options: argparse.Namespace) -> None:
    began_s, made_from = perf_counter(), commit()
    torch.set_num_threads(1)
    settings = {"scale": options.scale, "on": roads()}
    worlds = make_vec_env(Steering, options.worlds, options.seed, env_kwargs=settings)
    learned = PPO(
        "MultiInputPolicy",
        worlds,
        n_steps=options.steps_of_an_update,
        batch_size=128,
        n_epochs=3,
        gamma=0.97,
        learning_rate=lambda left: 5e-4 * left,
        policy_kwargs={"features_extractor_class": Features, "log_std_init": -1.0},
        seed=options.seed,
        device="cpu",
    )
    options.out.mkdir(parents=True, exist_ok=True)
    learned.set_logger(configure(str(options.out), ["stdout", "csv"]))  # progress.csv: the learning curve
    kept = CheckpointCallback(max(CHECKPOINT // options.worlds, 1), str(options.out), "policy")
    learned.learn(options.steps, [kept, StopAt(options.stop_at or options.steps)])
    worlds.close()
    finish(learned, options, made_from, (perf_counter() - began_s) / 3600.0)


def finish(learned: PPO, options: argparse.Namespace, made_from: str, wall_h: float) -> None:
    """Drive without noise, and write the policy with its manifest."""
    learned.save(options.out / "policy.zip")  # to train on
    seen: list[dict[str, Any]] = []
    for scenario, weather in product(SCENARIOS, WEATHERS):
        world = Steering(options.scale, (scenario,), (weather,))
        count = sum(arrives(world, learned, seed, seen) for seed in options.test_seeds)
        print(f"{scenario}, {weather}, {count} of {len(options.test_seeds)} arrive without noise", flush=True)
    pictures = [one["image"] for one in seen[::10]]
    speeds = [SPEED_SCALE_MPS * float(one["state"][0]) for one in seen]
    manifest = recorded(options, learned_from(pictures, speeds), made_from, learned.num_timesteps, wall_h)
    export(Command(learned.policy), manifest, options.out / "policy.onnx")


def arrives(world: Steering, learned: PPO, seed: int, seen: list[dict[str, Any]]) -> bool:
    """Whether a drive arrives without the noise of training; what it observes is added to `seen`."""
    observed, info = world.reset(seed=seed)
    over = False
    while not over:
        seen.append(observed)
        action, _ = learned.predict(observed, deterministic=True)
        observed, _, terminated, truncated, info = world.step(action)
        over = terminated or truncated
    return bool(info["is_success"])


def recorded(
    options: argparse.Namespace, known: LearnedFrom, made_from: str, decisions: int, wall_h: float
) -> Manifest:
    """The manifest with the record of the training."""
    training = Training(
        command=f"python examples/train_ppo.py FOLDER --steps {options.steps} "
        f"{f'--stop-at {options.stop_at} ' if options.stop_at else ''}--scale {options.scale} "
        f"--seed {options.seed} --worlds {options.worlds} --steps-of-an-update {options.steps_of_an_update}",
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


def _seed(text: str) -> int:
    return int(text) if text == "0" else _positive(text)


def _seeds(text: str) -> Sequence[int]:
    try:
        return parse_seeds(text, "A:B")
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", type=Path, metavar="FOLDER")
    parser.add_argument("--steps", type=_positive, default=1_000_000, help="decisions, at 5 a second")
    parser.add_argument("--stop-at", type=_positive, help="decisions, before the learning rate has fallen to 0")
    parser.add_argument("--steps-of-an-update", type=_positive, default=128, help="of each world")
    parser.add_argument(
        "--scale", type=_positive, default=2, help="draw pictures so many times larger, and average them"
    )
    parser.add_argument("--seed", type=_seed, default=0)
    parser.add_argument("--test-seeds", type=_seeds, default="900:905", help="of the drives after training")
    parser.add_argument("--worlds", type=_positive, default=16, help="drives side by side, in one process")
    try:
        main(parser.parse_args())
    except InputError as error:
        sys.exit(f"train_ppo.py: {error}")
