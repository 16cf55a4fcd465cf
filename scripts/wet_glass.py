"""Detection and removal of water on the windscreen of a recording, and its effect on the focus of expansion.

python scripts/wet_glass.py DRIVE [--weather NAME ...] [--wiper SECONDS] [--seed 0] [--json FILE]

The first row is the recording as it is; the others add the water of a weather, so that the ground truth behind it is
known. `--wiper` is the time between sweeps; 0 is off.
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.evaluation.analysis.text_table import text_table
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.weather import wet_glass
from vpf_sim.replay import readers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drive", type=Path, help="a recording, as for vpf-sim replay")
    parser.add_argument("--weather", nargs="*", default=["HardRainNoon"], help="weathers whose water is added")
    parser.add_argument("--wiper", type=float, help="seconds between sweeps, instead of the weather's")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    limit_opencv()
    recording = readers.read(arguments.drive)
    rows = []
    for weather in (None, *(load(name, arguments.wiper) for name in arguments.weather)):
        frames = (frame.image for frame in recording.frames())
        drive = wet_glass.Drive(recording.camera, recording.rate_hz, recording.poses, recording.foe_px, frames)
        score = wet_glass.measure(drive, weather, arguments.seed)
        rows.append({"water": "as recorded" if weather is None else weather.name, **asdict(score)})
        print(text_table(rows[-1:], header=len(rows) == 1), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


def load(name: str, wiper_period_s: float | None) -> Weather:
    """A weather, with another wiper period if given."""
    weather = weathers.load(name)
    return weather if wiper_period_s is None else weather.model_copy(update={"wiper_period_s": wiper_period_s})


if __name__ == "__main__":
    main()
