"""Whole drives on highway-env's roads: drivers that know the route or the world, records, sweeps and their resume."""

from pathlib import Path
from typing import Any

import pytest
from highway_worlds import empty

import vpf_sim
from vpf_sim import cli
from vpf_sim.evaluation.episode.episode import read
from vpf_sim.evaluation.sweeps.run_folder import read_lines

SHORT = """
schema = 1
[highway_env]
id = "highway-fast-v0"
config = {vehicles_count = 3}
[goal]
route_m = 25.0
"""


def write(folder: Path, name: str, more: str = "") -> str:
    """A scenario file of an id without traffic."""
    path = folder / f"{name}.toml"
    path.write_text(f'schema = 1\n[highway_env]\nid = "{name}"\ntraffic = false\n{more}')
    return str(path)


@pytest.mark.parametrize(
    ("name", "driver"),
    [
        ("intersection-v1", "pure-pursuit"),
        ("intersection-v1", "idm"),
        ("roundabout-v0", "stanley"),
        ("merge-v0", "pid"),
        pytest.param("roundabout-v0", "idm", marks=pytest.mark.slow),
        pytest.param("exit-v0", "pid", marks=pytest.mark.slow),
        pytest.param("exit-v0", "idm", marks=pytest.mark.slow),
        pytest.param("racetrack-v0", "pid", marks=pytest.mark.slow),
    ],
)
def test_drivers_arrive_where_nobody_else_drives(name: str, driver: str, tmp_path: Path) -> None:
    record = vpf_sim.drive(write(tmp_path, name), driver=driver, seed=1).record
    assert record["status"] == "success"
    assert record["route_completion"] == 1.0
    assert record["path_mse_m2"] < 1.5 or (name, driver) == ("exit-v0", "idm"), "idm changes lanes when it likes"
    assert record["min_clearance_m"] is None, "nobody is there"


def test_idm_follows_slower_cars() -> None:
    """pid, which does not see them, hits one at the same seed."""
    ends = {driver: vpf_sim.drive("merge-v0", driver=driver, seed=0).record for driver in ("idm", "pid")}
    assert ends["idm"]["status"] == "success"
    assert ends["idm"]["min_clearance_m"] > 1.0
    assert (ends["pid"]["status"], ends["pid"]["collided_with"]) == ("collision", "car")


def test_who_ignores_the_turn_does_not_arrive(tmp_path: Path) -> None:
    """Straight on at a junction where the route turns left, to the end of the road: 100 m of lane and 5 m beyond."""

    class StraightOn(vpf_sim.Driver):
        uses_images = False

        def __init__(self) -> None:
            self.told: set[str] = set()

        def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
            self.told.add(observation.turn)
            return vpf_sim.Command(0.5, 0.0)

    driver = StraightOn()
    record = vpf_sim.drive(write(tmp_path, "intersection-v1"), driver=driver).record
    assert record["status"] == "off_road"
    assert driver.told == {"lane", "left"}


def test_turns_are_told_only_on_highway_envs_roads() -> None:
    for scenario, told in ((empty("merge-v0"), True), ("straight", False)):
        env: Any = vpf_sim.envs.four_lane.FourLane(scenario, frames=False)
        observed, _ = env.reset(seed=0)
        assert ("turn" in observed) is told
        assert ("turn" in env.observation_space.spaces) is told
        assert read(observed).turn == "lane"


@pytest.mark.usefixtures("in_one_process")
def test_a_sweep_is_resumed_and_scored_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "mine.toml", tmp_path / "run"
    path.write_text(SHORT)
    grid = ["--scenario", str(path), "--driver", "pid", "--driver", "idm", "--seeds", "0:2"]
    assert cli.run(["sweep", *grid, "--out", str(out)]) == 0
    records = read_lines(out / "episodes.jsonl")
    assert [record["status"] for record in records] == ["success"] * 4
    lines = (out / "episodes.jsonl").read_text("utf-8").splitlines(keepends=True)
    (out / "episodes.jsonl").write_text("".join(lines[:2]), "utf-8")
    assert cli.run(["sweep", "--out", str(out), "--resume"]) == 0
    assert sorted(read_lines(out / "episodes.jsonl"), key=lambda record: record["id"]) == sorted(
        records, key=lambda record: record["id"]
    )
    capsys.readouterr()
    assert cli.run(["score", str(out)]) == 0
    assert "4 of 4 planned episodes rescored, 0 changed" in capsys.readouterr().out
