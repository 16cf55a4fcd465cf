"""The policies installed fit their manifests, follow a bend and pass a car; the cloned one doubts before lorries."""

from pathlib import Path

import pytest

import vpf_sim
from vpf_sim import drivers
from vpf_sim.drivers.learned import manifest
from vpf_sim.evaluation.sweeps.plan import parse_seeds

BEND = 'schema = 1\nbase = "{base}"\n[ego]\ns_m = 45.0\n[goal]\ns_m = 95.0\n'
ROAD = 'schema = 1\nbase = "straight"\n[limits]\ntime_s = 5.0\n'
WALL = ROAD + "".join(f'[[bodies]]\nkind = "truck"\ns_m = 45.0\nlane = {lane}\n' for lane in (1, 2, 3, 4))


@pytest.mark.parametrize("driver", ["learned-bc", "learned-ppo"])
def test_it_is_small_and_says_how_it_was_trained(driver: str) -> None:
    model = drivers.model_of(driver)
    assert model is not None
    assert model.stat().st_size < 2e6
    policy = manifest.load(model)
    assert policy.training is not None
    assert len(policy.training.commit) == 40
    assert policy.training.frames == pytest.approx(3600.0 * policy.rate_hz * policy.training.driven_h, rel=0.01)


def test_the_cloned_policy_has_not_seen_the_seeds_of_its_evaluation() -> None:
    training = manifest.load(drivers.model_of("learned-bc")).training
    assert training is not None
    assert parse_seeds(training.seeds).stop <= 900, "900 to 999 are for its development, the others for its evaluation"


@pytest.mark.parametrize(
    ("driver", "base", "weather"),
    [
        ("learned-bc", "curve-left", "rain"),
        ("learned-bc", "curve-right", "clear"),
        ("learned-ppo", "curve-left", "clear"),
        pytest.param("learned-ppo", "curve-left", "rain", marks=pytest.mark.slow),
    ],
)
def test_it_follows_a_bend(driver: str, base: str, weather: str, tmp_path: Path) -> None:
    path = tmp_path / "bend.toml"
    path.write_text(BEND.format(base=base))
    episode = vpf_sim.drive(path, driver=driver, weather=weather, seed=900)
    assert episode.status == "success"
    assert episode.record["max_lane_offset_m"] < 1.0


def test_the_one_that_learned_by_reward_passes_a_parked_car(tmp_path: Path) -> None:
    """The second of `town04`, which stands 0.9 m beside the lane's centre, so that no car fits straight on."""
    path = tmp_path / "car.toml"
    path.write_text('schema = 1\nbase = "town04"\n[ego]\ns_m = 130.0\n[goal]\ns_m = 180.0\n')
    episode = vpf_sim.drive(path, driver="learned-ppo", weather="rain", seed=900)
    assert episode.status == "success"
    assert episode.record["max_lane_offset_m"] > 1.0


@pytest.mark.parametrize(("road", "unsure"), [(WALL, True), (ROAD, False)], ids=["wall", "empty"])
def test_it_is_unsure_before_a_wall_of_lorries_alone(road: str, unsure: bool, tmp_path: Path) -> None:
    """It has met no road without a gap, and drives on before one."""
    path = tmp_path / "road.toml"
    path.write_text(road)
    episode = vpf_sim.drive(path, driver="learned-bc", seed=900)
    assert (episode.steps["uncertainty"].max() > 1.0) == unsure
