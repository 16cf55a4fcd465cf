"""Worlds of scenarios' roads that were made already: an episode that is driven again begins with a copy."""

from collections.abc import Hashable
from copy import deepcopy

from highway_env.road.road import Road

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.envs.camera.world import World
from vpf_sim.types import Camera

WORLDS = 16  # that are kept, a few MB each


_kept: dict[Hashable, World] = {}  # as yet without objects, the one used last at the end


def world(road: Road, camera: Camera, weather: Weather, seed: int) -> World:
    """The world of a road, camera, weather and seed, as yet without objects."""
    settings = getattr(road.network, "road", None)
    if settings is None:
        return _made(road, camera, weather, seed)
    made_from = settings, camera, weather, seed
    kept = _kept.pop(made_from, None)
    result = _made(road, camera, weather, seed) if kept is None else deepcopy(kept)
    _kept[made_from] = deepcopy(result) if kept is None else kept
    if len(_kept) > WORLDS:
        del _kept[next(iter(_kept))]
    return result


def _made(road: Road, camera: Camera, weather: Weather, seed: int) -> World:
    return World(road, camera, Light.of(weather), Atmosphere.of(weather), seed)
