"""Drive a scenario unchanged, rotated by 137 deg, shifted by 1 km, and mirrored: no direction is special.

python scripts/equivariance.py [SCENARIO] [--weather W] [--seeds 0:4] [--json FILE]

Road, objects and start of each seed are transformed; sun, sky and scenery are not, so the frames differ. In the
mirrored scenario the driver prefers the mirrored lane. The table has successes, the mean path MSE with its 95 %
interval, and the mean paired difference to the unchanged scenario.
"""

import argparse
import json
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from vpf_sim import drivers, scenarios
from vpf_sim.cli.tables import print_table, within
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.analysis.statistics import mean_interval, paired_difference
from vpf_sim.evaluation.episode.episode import roll_out
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics import records
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.sweeps.seeds import parse_seeds
from vpf_sim.planning import variant
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.transforms import mirrored, rotated, translated

Motion = Callable[[Scenario], Scenario]
MOTIONS: dict[str, Motion] = {
    "unchanged": lambda scenario: scenario,
    "turned by 137 deg": lambda scenario: rotated(scenario, 137.0),
    "moved by 1 km": lambda scenario: translated(scenario, 600.0, -800.0),
    "mirrored": mirrored,
}


def drive(scenario: Scenario, weather: str, driver: str, seed: int) -> dict[str, Any]:
    """The record of one episode."""
    with closing(FourLane(scenario, weather, truth=("foe",))) as env:
        outcome = roll_out(env, drivers.create(driver), drivers.create("pid"), seed)
        return records.score(Job("moved", weather, driver, seed), outcome, env.route, env.route_length_m)


def mirrored_driver(folder: Path, scenario: Scenario) -> str:
    """`vpf` with its likely lane mirrored."""
    lane = scenario.road.lanes + 1 - variant.load("robust").road_edges.likely_lane
    file = folder / "mirrored.toml"
    file.write_text(f"[road_edges]\nlikely_lane = {lane}\n")
    return f"vpf@{file}"


def row(motion: str, found: list[dict[str, Any]], unchanged: list[dict[str, Any]]) -> dict[str, Any]:
    """One line of the table."""
    good = [record["status"] == "success" for record in found]
    mse = np.array([record["path_mse_m2"] for record, kept in zip(found, good, strict=True) if kept], float)
    both = [
        (one["path_mse_m2"], other["path_mse_m2"])
        for one, other in zip(found, unchanged, strict=True)
        if one["status"] == other["status"] == "success"
    ]
    pairs = np.array(both, float).reshape(-1, 2)
    change = paired_difference(pairs[:, 0], pairs[:, 1])
    return {
        "world": motion,
        "successes": sum(good),
        "episodes": len(good),
        "path_mse_m2": float(np.mean(mse)) if len(mse) else None,
        "interval": mean_interval(mse) if len(mse) else None,
        "difference": change and change.difference,
        "difference_interval": change and change.interval,
    }


def print_rows(rows: list[dict[str, Any]]) -> None:
    """Print the table."""
    header = ("world", "success", "path MSE m2", "difference m2")
    lines = [
        (
            line["world"],
            f"{line['successes']}/{line['episodes']}",
            within(line["path_mse_m2"], line["interval"], 4),
            within(line["difference"], line["difference_interval"], 4),
        )
        for line in rows
    ]
    print_table(header, lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="town04", help="name or file")
    parser.add_argument("--weather", default="clear")
    parser.add_argument("--seeds", default="0:4", metavar="A:B")
    parser.add_argument("--json", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    limit_opencv()
    undrawn, seeds = scenarios.load(arguments.scenario), parse_seeds(arguments.seeds)
    rows, unchanged = [], []
    with TemporaryDirectory() as folder:
        for name, motion in MOTIONS.items():
            found = []
            for seed in seeds:
                drawn = undrawn.draw(seed)
                driver = mirrored_driver(Path(folder), drawn) if name == "mirrored" else "vpf"
                found.append(drive(motion(drawn), arguments.weather, driver, seed))
            unchanged = unchanged or found
            rows.append(row(name, found, unchanged))
            print(rows[-1], file=sys.stderr, flush=True)
    print_rows(rows)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
