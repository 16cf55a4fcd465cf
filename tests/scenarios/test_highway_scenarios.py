"""highway-env's environments as scenario files: their keys, their defaults, and what is said of mistakes."""

from pathlib import Path

import pytest
from highway_worlds import IDS, original

from vpf_sim import scenarios
from vpf_sim.errors import InputError
from vpf_sim.scenarios.highway import CONFIG_KEYS, OWN_LANES

HEAD = 'schema = 1\n[highway_env]\nid = "highway-v0"\n'


@pytest.mark.parametrize("name", IDS)
def test_a_file_with_an_id_alone_is_the_catalogs_scenario(name: str) -> None:
    assert scenarios.parse(f'schema = 1\n[highway_env]\nid = "{name}"\n', "mine.toml") == scenarios.load(name)


def test_keys_are_laid_over_the_catalogs_scenario() -> None:
    mine = scenarios.parse(HEAD + "[ego]\nspeed_reference_mps = 10.0\n", "mine.toml")
    assert isinstance(mine, scenarios.HighwayScenario)
    assert mine.ego.speed_reference_mps == 10.0
    assert mine.goal == scenarios.load("highway-v0").goal


@pytest.mark.parametrize("name", IDS)
def test_the_keys_of_an_id_are_keys_of_highway_env(name: str) -> None:
    config = original(name, 0).config
    assert set(CONFIG_KEYS[name]) <= set(config)  # type: ignore[index]
    if name in OWN_LANES:
        assert OWN_LANES[name] == config["lanes_count"]  # type: ignore[index]


def test_only_our_own_roads_can_be_drawn_as_roads() -> None:
    assert scenarios.drawn_road("town04", 0).road.lanes == 4
    with pytest.raises(InputError, match="expected one with a road of its own, got highway-v0"):
        scenarios.drawn_road("highway-v0", 0)


def test_the_file_in_the_docs_is_one() -> None:
    page = (Path(__file__).parents[2] / "docs" / "highway-env.md").read_text("utf-8")
    text = page.partition("```toml\n")[2].partition("```")[0]
    mine = scenarios.parse(text, "docs")
    assert isinstance(mine, scenarios.HighwayScenario)
    assert mine.highway_env.config.given() == {"lanes_count": 3, "vehicles_count": 20, "initial_lane_id": 1}
