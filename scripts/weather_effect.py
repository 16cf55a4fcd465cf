"""The effect of weather on tracking and the paper's perception: each factor alone, and whole weathers.

python scripts/weather_effect.py [--weather NAME ...] [--seed 0] [--seconds 4] [--every 12] [--json FILE]
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.analysis.text_table import text_table
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.weather import weather_effect
from vpf_sim.evaluation.weather.weather_effect import Factor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weather", nargs="*", help="rows to measure, by name, or other weathers; all by default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=4.0, help="length of the drive")
    parser.add_argument("--every", type=int, default=12, help="score every N-th frame")
    parser.add_argument("--json", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    limit_opencv()
    known = {factor.name: factor for factor in weather_effect.factors()}
    names = arguments.weather or list(known)
    chosen = [known.get(name) or Factor(name, weathers.load(name)) for name in names]
    rows = []
    for factor in chosen:
        score = weather_effect.measure(factor, arguments.seed, arguments.seconds, arguments.every)
        rows.append({"weather": factor.name, **asdict(score)})
        print(text_table(rows[-1:], header=len(rows) == 1), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
