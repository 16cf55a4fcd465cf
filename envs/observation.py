"""The first-person camera for any highway-env environment."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from vpf_sim.envs.camera import Renderer, Rig, Weather
from vpf_sim.envs.camera.weather import load
from vpf_sim.types import Image

ORIGINAL = "state"  # where an observation that is not a dictionary goes


class CameraObservation(gym.Wrapper, RecordConstructorArgs):
    """Adds what a camera on the ego vehicle sees to the observation.

    The observation becomes a dictionary: `image` (H, W, 3) uint8 RGB beside the entries it had, or, where it was no
    dictionary, beside the whole of it as `state`. The scenery is drawn anew at each reset, from the seed of the reset.

    >>> env = CameraObservation(gym.make("highway-v0"))  # doctest: +SKIP
    >>> observation, info = env.reset(seed=1)  # doctest: +SKIP
    """

    def __init__(self, env: gym.Env[Any, Any], weather: str | Weather = "clear", rig: Rig | None = None) -> None:
        RecordConstructorArgs.__init__(self, weather=weather, rig=rig)
        gym.Wrapper.__init__(self, env)
        world = env.unwrapped
        if not (hasattr(world, "road") and hasattr(world, "vehicle")):
            raise TypeError(
                f"expected a highway-env environment (with `road` and `vehicle`), got {type(world).__name__}"
            )
        if isinstance(env.observation_space, spaces.Dict) and "image" in env.observation_space.spaces:
            raise ValueError("expected an environment without an observation `image`, got one that has it")
        self.rig = rig or Rig()
        self.weather = weather if isinstance(weather, Weather) else load(weather)
        self.renderer: Renderer | None = None
        self._episodes = 0
        self._extend_space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; its road is new, so the renderer is too."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._episodes = 0 if seed is not None else self._episodes + 1
        self._extend_space()
        world: Any = self.env.unwrapped
        # the environment's own generator is not drawn from: its episodes stay as they are without the camera
        episode_seed = int(world.np_random_seed) + self._episodes
        self.renderer = Renderer(world.road, self.rig, self.weather, episode_seed)
        return self._observed(observation), info

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """One step of the environment, seen at its end."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._observed(observation), float(reward), terminated, truncated, info

    def _observed(self, observation: Any) -> dict[str, Any]:
        rest = observation if isinstance(self.env.observation_space, spaces.Dict) else {ORIGINAL: observation}
        return {**rest, "image": self._picture()}

    def _picture(self) -> Image:
        world: Any = self.env.unwrapped
        if self.renderer is None:
            raise RuntimeError("expected reset() before step()")
        return self.renderer.render(world.vehicle, float(world.time))

    def _extend_space(self) -> None:
        camera = self.rig.camera
        inner = self.env.observation_space
        rest = inner.spaces if isinstance(inner, spaces.Dict) else {ORIGINAL: inner}
        picture = spaces.Box(0, 255, (camera.height_px, camera.width_px, 3), np.uint8)
        self.observation_space = spaces.Dict({**rest, "image": picture})
