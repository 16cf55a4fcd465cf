"""Measure shimmer: pixels that change with a stationary car, and track errors on distant ground.

python scripts/shimmer.py [--weather ClearNoon ...] [--seed 0] [--seconds 2] [--json FILE]
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.analysis.text_table import text_table
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.rendering import shimmer

SPEEDS_MPS = (0.5, 1.0, 2.0, 5.5)
STILL_FRAMES = 10


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weather", nargs="*", default=["ClearNoon"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=2.0, help="length of each drive")
    parser.add_argument("--json", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    limit_opencv()
    rows: list[dict[str, str | float]] = []
    for name in arguments.weather:
        weather = weathers.load(name)
        for road in shimmer.STARTS_M:
            still = shimmer.changes_standing(weather, road, arguments.seed, STILL_FRAMES)
            for speed in SPEEDS_MPS:
                tracks = shimmer.creep(weather, road, speed, arguments.seed, round(60.0 * arguments.seconds) + 1)
                rows.append({"weather": name, "changed_standing": still, **asdict(tracks)})
                print(text_table(rows[-1:], header=len(rows) == 1), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
