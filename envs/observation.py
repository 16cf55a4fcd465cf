"""The first-person camera for any highway-env environment."""

from pathlib import Path
from typing import Any, Protocol, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.utils import RecordConstructorArgs
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle

from vpf_sim.envs.camera import Renderer, Rig, Weather
from vpf_sim.envs.camera.rig import checked_rig
from vpf_sim.envs.camera.weather import load

ORIGINAL = "state"  # the key of an observation that is not a dictionary


class HighwayWorld(Protocol):
    """What the camera uses of a highway-env environment."""

    road: Road
    vehicle: Vehicle  # the one that carries the camera
    time: float  # s
    np_random_seed: int


class CameraObservation(gym.Wrapper, RecordConstructorArgs):
    """Adds the frame of a camera on the ego vehicle to the observation.

    The observation becomes a dictionary: `image` (H, W, 3) uint8 RGB beside the original entries; an original
    observation that is not a dictionary becomes `state`. With several controlled vehicles the camera is on the first.
    Each reset draws new scenery from its seed. `render()` remains the environment's own view from above.

    Raises InputError for an invalid weather or rig, ResetNeeded for a step before the first reset, ValueError for an
    action of the wrong shape or with non-finite values. A copy (`copy.deepcopy`) continues with the same frames.

    >>> env = CameraObservation(gym.make("highway-v0"))  # doctest: +SKIP
    >>> observation, info = env.reset(seed=1)  # doctest: +SKIP
    """

    def __init__(self, env: gym.Env[Any, Any], weather: str | Path | Weather = "clear", rig: Rig | None = None) -> None:
        RecordConstructorArgs.__init__(self, weather=weather, rig=rig)
        gym.Wrapper.__init__(self, env)
        world = env.unwrapped
        if not (hasattr(world, "road") and hasattr(world, "vehicle")):
            raise TypeError(
                f"expected a highway-env environment (with `road` and `vehicle`), got {type(world).__name__}"
            )
        if isinstance(env.observation_space, spaces.Dict) and "image" in env.observation_space.spaces:
            raise ValueError("expected an environment without an observation `image`, got one that has it")
        self.rig = checked_rig(rig)
        self.weather = load(weather)
        self.renderer: Renderer | None = None
        self._episodes = 0
        self._extend_space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode with a new road and a new renderer."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._episodes = 0 if seed is not None else self._episodes + 1
        self._extend_space()
        world = cast(HighwayWorld, self.env.unwrapped)
        # no draw from the environment's own generator: its episodes stay the same with the camera
        episode_seed = int(world.np_random_seed) + self._episodes
        self.renderer = Renderer(world.road, self.rig, self.weather, episode_seed)
        return self._observed(observation, self.renderer), info

    def step(self, action: Any) -> tuple[dict[str, Any], Any, bool, bool, dict[str, Any]]:
        """One step of the environment; the frame shows its end."""
        if self.renderer is None:
            raise ResetNeeded("step: expected reset() first")
        _check_action(self.env.action_space, action)
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._observed(observation, self.renderer), reward, terminated, truncated, info

    def _observed(self, observation: Any, renderer: Renderer) -> dict[str, Any]:
        world = cast(HighwayWorld, self.env.unwrapped)
        rest = observation if isinstance(self.env.observation_space, spaces.Dict) else {ORIGINAL: observation}
        return {**rest, "image": renderer.render(world.vehicle, float(world.time))}

    def _extend_space(self) -> None:
        camera = self.rig.camera
        inner = self.env.observation_space
        rest = inner.spaces if isinstance(inner, spaces.Dict) else {ORIGINAL: inner}
        picture = spaces.Box(0, 255, (camera.height_px, camera.width_px, 3), np.uint8)
        self.observation_space = spaces.Dict({**rest, "image": picture})


def _check_action(space: gym.Space[Any], action: Any) -> None:
    """ValueError for an action that highway-env cannot use; clipping is left to highway-env."""
    if isinstance(space, spaces.Tuple):
        if not isinstance(action, tuple | list | np.ndarray) or len(action) != len(space):
            raise ValueError(f"action: expected one for each of {len(space)} vehicles, got {action!r}")
        for part, own in zip(space.spaces, action, strict=True):
            _check_action(part, own)
    elif isinstance(space, spaces.Discrete):
        if not space.contains(action):
            raise ValueError(f"action: expected a whole number from 0 to {space.n - 1}, got {action!r}")
    elif isinstance(space, spaces.Box):
        try:
            values = np.asarray(action, np.float64)
        except (TypeError, ValueError):  # not numeric
            values = np.empty(0)
        if values.shape != space.shape or not np.isfinite(values).all():
            raise ValueError(f"action: expected finite numbers of the shape {space.shape}, got {action!r}")
