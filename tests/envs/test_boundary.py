"""The sensor boundary: a driver's inputs give no access to the world without the declared privilege."""

import gc
from collections.abc import Iterator
from contextlib import closing
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest
from highway_env.road.lane import AbstractLane
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.objects import RoadObject
from short_scenario import write_short

from vpf_sim.evaluation.episode.episode import read, setup_for

CODE = (type, ModuleType, FunctionType, BuiltinFunctionType)  # lead to all that is imported, not to an episode
WORLD = (Road, RoadNetwork, AbstractLane, RoadObject)


def reachable(*roots: object) -> Iterator[object]:
    """All objects reachable from the roots: attributes, items, bases of views."""
    found = {id(root): root for root in roots}
    ahead = list(roots)
    while ahead:
        holder = ahead.pop()
        yield holder
        held = [*gc.get_referents(holder), getattr(holder, "base", None) if isinstance(holder, np.ndarray) else None]
        for item in held:
            if not isinstance(item, CODE) and id(item) not in found:
                found[id(item)] = item
                ahead.append(item)


def is_of_the_world(value: object) -> bool:
    return isinstance(value, WORLD) or type(value).__module__.startswith(("highway_env", "vpf_sim.envs"))


class Declares:
    def __init__(self, privileged: Any) -> None:
        self.privileged = privileged


@pytest.fixture(scope="module")
def driver_inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[object]]:
    """All inputs of a driver by privilege, after the first step of an episode."""
    from vpf_sim.envs.four_lane import FourLane

    with closing(FourLane(str(write_short(tmp_path_factory.mktemp("scenario"))), truth=("foe",))) as env:
        first, _ = env.reset(seed=3)
        setups = {name: setup_for(Declares(name), env, 3) for name in ("none", "route", "world")}  # type: ignore[arg-type]
        second, *_ = env.step(np.zeros(2, np.float32))
        return {name: [setup, read(first), read(second)] for name, setup in setups.items()}


@pytest.mark.parametrize("privileged", ["none", "route"])
def test_unprivileged_driver_cannot_reach_the_world(privileged: str, driver_inputs: dict[str, list[object]]) -> None:
    assert not [value for value in reachable(*driver_inputs[privileged]) if is_of_the_world(value)]


def test_search_finds_the_world_when_privileged(driver_inputs: dict[str, list[object]]) -> None:
    kinds = {kind for value in reachable(*driver_inputs["world"]) for kind in WORLD if isinstance(value, kind)}
    assert kinds == set(WORLD)


def test_unprivileged_driver_holds_only_numbers_and_frames(driver_inputs: dict[str, list[object]]) -> None:
    modules = {type(value).__module__ for value in reachable(*driver_inputs["none"])}
    assert modules <= {"builtins", "numpy", "vpf_sim.driver_interface", "vpf_sim.types"}
    arrays = [value for value in reachable(*driver_inputs["none"]) if isinstance(value, np.ndarray)]
    assert {array.shape for array in arrays} == {(480, 640, 3)}, "no waypoints, no other picture"
