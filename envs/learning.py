"""vpf_sim/FourLanePixels-v0: FourLane for learned policies: small pictures, relative goal, weighted reward."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from math import isfinite
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeGuard

import cv2
import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as presets
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError, refuse_options, refuse_unknown
from vpf_sim.policy_state import STATE, policy_state
from vpf_sim.scenarios import AnyScenario
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

MOST_REPEATS = 60

PixelObservation = NDArray[np.uint8] | dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class RewardWeights:
    """Weights of the reward's terms; each term is negative where it punishes, and 0 turns it off."""

    progress: float = 0.1  # per m along the route
    lane: float = 0.02  # per m2 of squared offset from the lane's centre, and second
    comfort: float = 0.01  # per squared change of the action, once a decision
    time: float = 0.0  # per second
    contact: float = 5.0  # once, for a collision or for leaving the road
    arrival: float = 5.0  # once, for success

    def __post_init__(self) -> None:
        for key in (item.name for item in fields(self)):
            value = getattr(self, key)
            if not isinstance(value, Real) or isinstance(value, bool) or not isfinite(value) or value < 0.0:
                raise InputError(f"reward: {key}: expected a finite number of at least 0, got {value!r}")


class FourLanePixels(gymnasium.Env[PixelObservation, Any]):
    """FourLane as an environment to learn in: one small frame a decision, and nothing in world coordinates.

    Action: throttle and steering in [-1, 1], held for `action_repeat` ticks; only the last is drawn. A tick is 1/60 s,
    or with `rate_hz=20` 1/20 s: three times fewer ticks cost less, and cars move almost the same.
    Observation: the image, (H, W, 1) grey or (H, W, 3) RGB, uint8. With `state=True` a Dict of `image` and `state`
    (6,) float32 in [-1, 1]: speed and yaw rate as shares of their limits, the goal in vehicle axes (forward, right) by
    100 m, and the last action. Reward: the sum of the terms of `RewardWeights`; `info["reward_terms"]`
    has each. Else `info` is FourLane's, and so are the endings.

    `scenario` and `weather` are one or several names, files or loaded objects, also as `scenarios` and `weathers`. Each
    reset draws one of each by its seed (domain randomisation; the scenario `random` draws a road and obstacles as
    well). `levels` limits the draw to the first scenarios, for a curriculum: set it between episodes, through
    `env.unwrapped.levels` or a vector environment's `set_attr`. The image has at least 64 x 48 pixels.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 60}  # noqa: RUF012 (gymnasium's)

    def __init__(
        self,
        scenario: str | Path | AnyScenario | Sequence[str | Path | AnyScenario] = "curve-left",
        weather: str | Path | Weather | Sequence[str | Path | Weather] = "clear",
        image_size: tuple[int, int] = (84, 84),
        fov_deg: float = 90.0,
        grey: bool = True,
        action_repeat: int = 3,
        state: bool = False,
        reward: RewardWeights | None = None,
        render_mode: str | None = None,
        rate_hz: float = 60.0,
        **others: Any,
    ) -> None:
        scenario, weather = others.pop("scenarios", scenario), others.pop("weathers", weather)
        refuse_unknown(others, FourLanePixels)
        self._weights = _checked_weights(reward)
        self._repeat = _checked_repeat(action_repeat)
        self._grey, self._with_state = _checked_switch("grey", grey), _checked_switch("state", state)
        self.render_mode = render_mode
        width_px, height_px = _checked_size(image_size)
        rig = Rig(Camera.of(width_px, height_px, _checked_angle(fov_deg)))
        self._worlds = [
            FourLane(one, "clear", render_mode, rate_hz=rate_hz, rig=rig) for one in _several("scenario", scenario)
        ]
        self._weathers = [presets.load(one) for one in _several("weather", weather)]
        self._world = self._worlds[0]
        self.levels = len(self._worlds)
        self.metadata = {**self.metadata, "render_fps": round(self._world.rate_hz / self._repeat)}
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        image = spaces.Box(0, 255, (height_px, width_px, 1 if grey else 3), np.uint8)
        values = spaces.Box(-1.0, 1.0, (len(STATE),), np.float32)
        self.observation_space: Any = spaces.Dict({"image": image, "state": values}) if state else image

    @property
    def world(self) -> FourLane:
        """The environment of the running episode."""
        return self._world

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[PixelObservation, dict[str, Any]]:
        """Draw scenario and weather, and begin their episode; all three follow from the seed."""
        refuse_options(options)
        super().reset(seed=seed, options=options)
        episode_seed = int(self.np_random.integers(2**31)) if seed is None else seed
        draw = stream(episode_seed, "learning")
        self._world = self._worlds[int(draw.integers(self._checked_levels()))]
        self._world.weather = self._weathers[int(draw.integers(len(self._weathers)))]
        observed, info = self._world.reset(seed=episode_seed)
        self._action, self._route_m, self._time_s = np.zeros(2), self._world.route_m, 0.0
        return self._observation(observed), info

    def step(self, action: Any) -> tuple[PixelObservation, float, bool, bool, dict[str, Any]]:
        """Hold an action for one decision, or until the episode ends."""
        observed, _, terminated, truncated, info = self._world.step(action, ticks=self._repeat)
        before_s, self._time_s = self._time_s, float(observed["time"][0])
        terms = self._terms(np.clip(np.asarray(action, float), -1.0, 1.0), self._time_s - before_s, info)
        info["reward_terms"] = terms
        return self._observation(observed), sum(terms.values()), terminated, truncated, info

    def render(self) -> Image | None:
        """The last drawn frame in colour, (H, W, 3)."""
        return self._world.render()

    def close(self) -> None:
        for world in self._worlds:
            world.close()

    def _terms(self, action: Floats, held_s: float, info: dict[str, Any]) -> dict[str, float]:
        """The weighted terms of a decision's reward, by the names of `RewardWeights`."""
        change, self._action = action - self._action, action
        gained_m, self._route_m = info["route_m"] - self._route_m, info["route_m"]
        amounts = {
            "progress": gained_m,
            "lane": -held_s * info["lane_offset_m"] ** 2,
            "comfort": -float(change @ change),
            "time": -held_s,
            "contact": -float(info["status"] in ("collision", "off_road")),
            "arrival": float(info["status"] == "success"),
        }
        return {name: getattr(self._weights, name) * amount for name, amount in amounts.items()}

    def _observation(self, observed: dict[str, NDArray[Any]]) -> PixelObservation:
        image = self._small(observed["image"])
        if not self._with_state:
            return image
        pose, (speed_mps, yaw_rate_radps) = observed["ego"][:3], observed["ego"][3:].tolist()
        state = policy_state(pose, speed_mps, yaw_rate_radps, observed["goal"], self._action)
        return {"image": image, "state": state}

    def _small(self, image: Image) -> NDArray[np.uint8]:
        """(H, W, 1 or 3) the frame as observed."""
        if not self._grey:
            return image
        grey: NDArray[np.uint8] = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)[:, :, None]  # type: ignore[assignment]
        return grey

    def _checked_levels(self) -> int:
        count = len(self._worlds)
        if not _is_whole(self.levels) or not 1 <= self.levels <= count:
            raise InputError(f"levels: expected 1 to {count}, the number of scenarios, got {self.levels!r}")
        return self.levels


def _several(what: str, given: Any) -> list[Any]:
    """One or several of something, as a list that is not empty."""
    found = list(given) if isinstance(given, list | tuple) else [given]
    if not found:
        raise InputError(f"{what}: expected at least one, got none")
    return found


def _checked_repeat(ticks: object) -> int:
    if not _is_whole(ticks) or not 1 <= ticks <= MOST_REPEATS:
        raise InputError(f"action_repeat: expected 1 to {MOST_REPEATS} ticks, got {ticks!r}")
    return int(ticks)


def _checked_size(size: object) -> tuple[int, int]:
    if not isinstance(size, list | tuple) or len(size) != 2 or not all(map(_is_whole, size)):
        raise InputError(f"image_size: expected (width, height) in pixels, got {size!r}")
    return int(size[0]), int(size[1])


def _checked_angle(degrees: object) -> float:
    if not isinstance(degrees, Real) or isinstance(degrees, bool):
        raise InputError(f"fov_deg: expected a number of degrees, got {degrees!r}")
    return float(degrees)


def _is_whole(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number, also one of numpy's."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def _checked_switch(what: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"{what}: expected True or False, got {value!r}")
    return value


def _checked_weights(reward: object) -> RewardWeights:
    if reward is None:
        return RewardWeights()
    if not isinstance(reward, RewardWeights):
        raise InputError(f"reward: expected a vpf_sim.envs.learning.RewardWeights, got {reward!r}")
    return reward
