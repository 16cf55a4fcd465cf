"""All versions of highway-env's environments: each id is a scenario, or the docs say why it is not."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator
from highway_worlds import IDS, world
from hypothesis import given, settings
from hypothesis import strategies as st

from vpf_sim import scenarios
from vpf_sim.envs.world import build_world
from vpf_sim.scenarios.highway import without_version

PAGE = (Path(__file__).parents[2] / "docs" / "highway-env.md").read_text("utf-8")
REGISTERED = sorted(name for name, spec in gymnasium.registry.items() if "highway_env" in str(spec.entry_point))
KINDS = {name: load_env_creator(gymnasium.registry[name].entry_point) for name in IDS}
CONNECTED = [name for name, kind in KINDS.items() if kind.default_config().get("neighbour_vehicles_connected_lanes")]


@pytest.mark.parametrize("name", REGISTERED)
def test_every_id_is_a_scenario_or_the_page_says_why_not(name: str) -> None:
    assert f"`{name}`" in PAGE
    assert (name in IDS) == (name in scenarios.names())
    if name not in IDS:
        assert f"`{name}`" in PAGE.partition("Which ids are no scenarios?")[2]


@pytest.mark.parametrize("name", CONNECTED)
def test_a_newer_version_has_the_road_and_the_cars_of_the_older(name: str) -> None:
    """They differ in whom the cars heed."""
    older = f"{without_version(name)}-v0"
    new, old = world(name, 3), world(older, 3)
    assert new.road.neighbour_vehicles_connected_lanes
    assert not old.road.neighbour_vehicles_connected_lanes
    assert np.array_equal(new.route.waypoints(), old.route.waypoints())
    assert [(*car.position, car.speed) for car in new.road.vehicles] == [
        (*car.position, car.speed) for car in old.road.vehicles
    ]


def test_there_are_newer_versions() -> None:
    assert len(CONNECTED) >= 10
    assert {without_version(name) for name in CONNECTED} < {without_version(name) for name in IDS}


CONFIGS = {
    "merge-generic-v1": st.fixed_dictionaries(
        {},
        optional={
            "lanes_count": st.integers(1, 6),
            "vehicles_count": st.integers(0, 20),
            "before_merge_length": st.integers(60, 2000),
            "converge_merge_length": st.integers(20, 500),
            "parallel_merge_length": st.integers(20, 2000),
            "after_merge_length": st.integers(90, 2000),
        },
    ),
    "roundabout-generic-v0": st.fixed_dictionaries(
        {},
        optional={
            "roundabout_radius": st.integers(15, 100),
            "roundabout_lanes": st.integers(1, 4),
            "vehicles_count": st.integers(0, 20),
            "incoming_vehicle_destination": st.integers(0, 2),
        },
    ),
    "racetrack-oval-v0": st.fixed_dictionaries(
        {},
        optional={
            "length": st.integers(60, 1000),
            "block_lane": st.booleans(),
            "force_decision": st.booleans(),
            "other_vehicles": st.integers(0, 20),
        },
    ),
}


@pytest.mark.parametrize("name", CONFIGS)
def test_any_value_of_the_keys_makes_a_world(name: str) -> None:
    @settings(max_examples=12)
    @given(config=CONFIGS[name], seed=st.integers(0, 99))
    def builds(config: dict[str, int], seed: int) -> None:
        made = world(name, seed, **config)
        assert made.route.length_m > 20.0
        assert np.isfinite(made.route.waypoints()).all()
        start, heading = made.route.waypoints()[:2]
        assert np.hypot(*(made.ego.position - start)) < 5.0
        assert np.isfinite(heading).all()

    builds()


def test_a_blocked_oval_has_barriers() -> None:
    made = build_world(scenarios.parse(
        'schema = 1\n[highway_env]\nid = "racetrack-oval-v1"\nconfig = {block_lane = true}\n', "mine.toml"
    ), 0)  # fmt: skip
    assert len(made.road.objects) == 8
    assert {obj.kind for obj in made.road.objects} == {"barrier"}
