"""The world of a highway-env environment as it makes it, and the traffic that it lets come and go."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import hypot, nan
from typing import Any

import gymnasium
from gymnasium.envs.registration import load_env_creator
from highway_env.envs import IntersectionEnv
from highway_env.utils import class_from_path
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.ego import Ego
from vpf_sim.envs.highway.indexed_road import speed_up
from vpf_sim.envs.network import Place
from vpf_sim.scenarios.highway import HighwayEnv

# An object that is farther aside of the route (two lanes), or farther from the ego, has no place.
BESIDE_M, FAR_M = 8.0, 100.0
NOWHERE: Place = (nan, nan)
# The id's own action has no planned route, and with it the destination that highway-env draws would be lost.
PLANNED = {"intersection-v1": {"action": {"type": "DiscreteMetaAction"}}}


class Traffic:
    """A highway-env environment after its reset; only its road is driven on, never its `step`."""

    def __init__(self, settings: HighwayEnv, seed: int) -> None:
        config = {**settings.config.given(), **PLANNED.get(settings.id, {})}
        if config.get("destination") == "random":
            config["destination"] = None
        # its class, since gymnasium.make warns that a newer version of the environment exists
        environment: Any = load_env_creator(str(gymnasium.spec(settings.id).entry_point))
        with _changes_undone(environment, config) as changes:
            self._env: Any = environment(config=config)
            self._env.reset(seed=seed)
        self._changes = changes
        self._comes_and_goes = settings.traffic and isinstance(self._env, IntersectionEnv)
        self.road = self._env.road
        self.start = self._env.vehicle  # highway-env's ego
        if not settings.traffic:
            self.road.vehicles, self.road.objects = [self.start], []
        speed_up(self.road)
        self._adopt([*self.road.vehicles, *self.road.objects])

    def replace_ego(self, ego: Ego) -> None:
        """Put our ego in the place of highway-env's."""
        self.road.vehicles[self.road.vehicles.index(self.start)] = ego
        self._env.vehicle = ego
        self._ego = ego
        self.update_places()

    def advance(self, steps: int, rate_hz: float) -> None:
        """One step of the world, after `steps` others: cars decide at highway-env's rate and move at ours."""
        if steps % _every(self._env.config["simulation_frequency"], rate_hz) == 0:
            self.road.act()
        self.road.step(1.0 / rate_hz)
        if self._comes_and_goes and (steps + 1) % _every(self._env.config["policy_frequency"], rate_hz) == 0:
            self._renew()
        self.update_places()

    def _renew(self) -> None:
        """Let cars come and go, as highway-env's `step` does."""
        self._env._clear_vehicles()  # highway-env has no public name for them
        arrived = self._env._spawn_vehicle(spawn_probability=self._env.config["spawn_probability"])
        self._adopt([] if arrived is None else [arrived])

    def update_places(self) -> None:
        """Give every object its place on the route."""
        ego_x, ego_y = self._ego.position.tolist()
        for obj in (*self.road.vehicles, *self.road.objects):
            if obj is not self._ego:
                x, y = obj.position.tolist()
                near = hypot(x - ego_x, y - ego_y) <= FAR_M
                obj.place = self._place(x, y) if near else NOWHERE

    def _place(self, x: float, y: float) -> Place:
        """(s, lateral) on the route; nan for what is not near it."""
        s, lateral = self.road.network.place_at(x, y, self._ego.place[0])
        return (s, lateral) if abs(lateral) <= BESIDE_M else NOWHERE

    def _adopt(self, objects: list[Any]) -> None:
        """Give objects their kind, and cars the parameters that highway-env has set on their class."""
        for obj in objects:
            obj.kind = kind_of(obj)
            for name, value in self._changes.items() if isinstance(obj, Vehicle) else ():
                setattr(obj, name, value)


def kind_of(obj: RoadObject) -> str:
    """What an object of highway-env is, as the camera draws it."""
    return "barrier" if isinstance(obj, Obstacle) else "car"


def _every(frequency_hz: float, rate_hz: float) -> int:
    """Number of our steps in a period of highway-env."""
    return max(1, round(rate_hz / frequency_hz))


@contextmanager
def _changes_undone(environment: Any, config: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Undo what making an environment changes on the class of its cars; yields these changes, filled at the end.

    highway-env's intersection sets parameters of its traffic on the class, and so of all traffic in the process. An
    episode must not depend on those before it.
    """
    traffic = class_from_path({**environment.default_config(), **config}["other_vehicles_type"])
    before = dict(vars(traffic))
    changes: dict[str, Any] = {}
    try:
        yield changes
    finally:
        for name, value in dict(vars(traffic)).items():
            if name not in before:
                delattr(traffic, name)
            elif before[name] is not value:
                setattr(traffic, name, before[name])
            else:
                continue
            changes[name] = value
