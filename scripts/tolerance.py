"""Robustness of `vpf` to other verges, surfaces, markings, lanes and sensor errors, on random roads.

    python scripts/tolerance.py --seeds 1000:1010 --out DIR [--weather W] [--only WORD] [--workers N] [--resume]

Each row of the table is one world. Worlds with the default lanes have the same roads and objects; in the others the
driver is configured with their number and width of lanes. The table has successes, and the mean path MSE and least
clearance of successful episodes with 95 % intervals. DIR has the scenario files and the run; `vpf-sim video` re-
renders its failures.
"""

import argparse
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim.cli.tables import print_table, within
from vpf_sim.evaluation.analysis.statistics import mean_interval
from vpf_sim.evaluation.sweeps.json_lines import read_lines

BASE = """schema = 1
[random]
length_m = [120.0, 180.0]
rows = [1, 2]
{lanes}
[random.look]
{look}
[ego]
lane = 2
speed_mps = 5.55
[ego.sensors]
{sensors}
[vary]
"ego.lateral_m" = [-0.3, 0.3]
"ego.heading_deg" = [-1.0, 1.0]
"""
YAW_RATE = "yaw_rate_noise_radps = 0.01\nyaw_rate_bias_radps = 0.01"
SPEED = "speed_scale = 0.03\nspeed_noise_mps = 0.05"
WALK = "position_walk_m = 0.05\nheading_walk_deg = 0.1"
NOISE = "position_noise_m = 0.01\nheading_noise_deg = 0.05"
MOUNTING, PITCH = "mounting_deg = 0.3", "pitch_deg = 0.2"
WORLDS: dict[str, dict[str, str]] = {
    "default": {},
    "verge-sand": {"look": 'verge = "sand"'},
    "verge-snow": {"look": 'verge = "snow"'},
    "verge-paved": {"look": 'verge = "paved"'},
    "concrete": {"look": 'surface = "concrete"'},
    "dark-asphalt": {"look": 'surface = "dark"'},
    "worn-paint": {"look": "worn = true"},
    "worn-concrete-paved": {"look": 'worn = true\nsurface = "concrete"\nverge = "paved"'},
    "edge-left-only": {"look": 'edge_lines = "left"'},
    "edge-right-only": {"look": 'edge_lines = "right"'},
    "edge-none": {"look": 'edge_lines = "none"'},
    "lanes-3": {"lanes": "lanes = 3"},
    "lanes-5": {"lanes": "lanes = 5"},
    "lane-width-3.0": {"lanes": "lane_width_m = 3.0"},
    "lane-width-3.75": {"lanes": "lane_width_m = 3.75"},
    "yaw-rate": {"sensors": YAW_RATE},
    "speed": {"sensors": SPEED},
    "pose-walk": {"sensors": WALK},
    "pose-noise": {"sensors": NOISE},
    "mounting": {"sensors": MOUNTING},
    "pitch": {"sensors": PITCH},
    "all-sensors": {"sensors": "\n".join((YAW_RATE, SPEED, WALK, NOISE, MOUNTING, PITCH))},
}


def write_world(folder: Path, name: str, parts: Mapping[str, str]) -> tuple[Path, str]:
    """Write the scenario file of a world; returns it and the driver configured for its lanes."""
    scenario = folder / f"{name}.toml"
    scenario.write_text(BASE.format(**{"lanes": "", "look": "", "sensors": "", **parts}))
    if "lanes" not in parts:
        return scenario, "vpf"
    driver = folder / f"driver-{name}.toml"
    driver.write_text(f"[road_edges]\n{parts['lanes']}\n")
    return scenario, f"vpf@{driver}"


def sweep(scenarios: list[Path], driver: str, out: Path, arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """Drive the worlds of one driver; returns the records. Exit code 1 is accepted, since failures are results here."""
    command = [sys.executable, "-m", "vpf_sim.cli", "sweep", "--driver", driver, "--weather", arguments.weather]
    command += [part for scenario in scenarios for part in ("--scenario", str(scenario))]
    command += ["--seeds", arguments.seeds, "--out", str(out)]
    command += ["--workers", str(arguments.workers)] if arguments.workers else []
    command += ["--resume"] if arguments.resume and out.exists() else []
    code = subprocess.run(command).returncode
    if code not in (0, 1):
        sys.exit(code)
    return read_lines(out / "episodes.jsonl")


def row(world: str, found: list[dict[str, Any]]) -> tuple[str, ...]:
    """One line of the table."""
    good = [record for record in found if record["status"] == "success"]
    mse = np.array([record["path_mse_m2"] for record in good], float)
    clearance = np.array([record["min_clearance_m"] for record in good if record["min_clearance_m"] is not None], float)
    return (
        world,
        f"{len(good)}/{len(found)}",
        within(float(mse.mean()) if len(mse) else None, mean_interval(mse), 2),
        within(float(clearance.mean()) if len(clearance) else None, mean_interval(clearance), 2),
        ", ".join(f"{record['seed']} {record['status']}" for record in found if record["status"] != "success"),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1000:1010", metavar="A:B")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--weather", default="clear")
    parser.add_argument("--only", default="", metavar="WORD", help="only worlds whose name contains WORD")
    parser.add_argument("--workers", type=int, metavar="N", help="as of vpf-sim sweep")
    parser.add_argument("--resume", action="store_true", help="continue the run in DIR")
    arguments = parser.parse_args()
    worlds = {name: parts for name, parts in WORLDS.items() if arguments.only in name}
    if not worlds:
        parser.error(f"argument --only: expected a part of one of {', '.join(WORLDS)}, got {arguments.only!r}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    by_driver: dict[str, list[Path]] = {}
    for name, parts in worlds.items():
        scenario, driver = write_world(arguments.out, name, parts)
        by_driver.setdefault(driver, []).append(scenario)
    found: list[dict[str, Any]] = []
    for driver, scenarios in by_driver.items():
        run = "run" if driver == "vpf" else f"run-{scenarios[0].stem}"
        found += sweep(scenarios, driver, arguments.out / run, arguments)
    header = ("world", "success", "path MSE m2", "least clearance m", "failed seeds")
    by_world = {name: [record for record in found if Path(record["scenario"]).stem == name] for name in worlds}
    print_table(header, [row(name, of) for name, of in by_world.items()])


if __name__ == "__main__":
    main()
