"""Success of drivers with sensor faults: by drop rate, latency, and each other fault.

    python scripts/studies/sensor_faults.py --seeds 0:3 --out DIR [--driver D]... [--base town04]... [--weather W]
        [--only WORD] [--workers N] [--resume]

Each row is a scenario with one fault, stored as a file in DIR, on the same roads as the first row. A cell has the
successes, their least clearance, and the seeds that failed; `vpf-sim video` re-renders them.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from vpf_sim.cli.output import print_table
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import CLEARANCE
from vpf_sim.evaluation.sweeps.run_folder import read_records

FAULTS = {
    "none": "",
    "drop-5": "drop_share = 0.05",
    "drop-10": "drop_share = 0.1",
    "drop-20": "drop_share = 0.2",
    "latency-50": "latency_ms = 50",
    "latency-100": "latency_ms = 100",
    "latency-200": "latency_ms = 200",
    "drop-10-latency-100": "drop_share = 0.1\nlatency_ms = 100",
    "freeze": "freeze_share = 0.1\nfreeze_s = 0.3",
    "freeze-long": "freeze_share = 0.1\nfreeze_s = 2.0",
    "black": "black_share = 0.1",
    "torn": "torn_share = 0.1",
    "noise-rows": "noise_rows_share = 0.1",
    "exposure": "exposure_jump_share = 0.1",
    "speed-stuck": "speed_stuck_after_s = 3.0",
    "yaw-rate-spikes": "yaw_rate_spike_share = 0.02",
}
DRIVERS, BASES = ("vpf", "pid", "stanley"), ("town04", "random")


def write_scenario(folder: Path, base: str, fault: str) -> Path:
    """Write the scenario file of a fault."""
    path = folder / f"{base}-{fault}.toml"
    path.write_text(f'base = "{base}"\n[ego.sensor_faults]\n{FAULTS[fault]}\n')
    return path


def sweep(scenarios: list[Path], arguments: argparse.Namespace) -> list[Record]:
    """Drive all scenarios; returns the records. Exit code 1 is accepted, since failures are results here."""
    out = arguments.out / "run"
    command = [sys.executable, "-m", "vpf_sim.cli", "sweep", "--weather", arguments.weather]
    command += [part for scenario in scenarios for part in ("--scenario", str(scenario))]
    command += [part for driver in arguments.driver or DRIVERS for part in ("--driver", driver)]
    command += ["--seeds", arguments.seeds, "--out", str(out)]
    command += ["--workers", str(arguments.workers)] if arguments.workers else []
    command += ["--resume"] if arguments.resume and out.exists() else []
    code = subprocess.run(command).returncode
    if code not in (0, 1):
        sys.exit(code)
    return read_records(out)


def cell(found: list[Record]) -> str:
    """Successes with their least clearance, and the endings of the other episodes."""
    good = [one for one in found if one.succeeded]
    clearances_m = [gap for one in good if (gap := one[CLEARANCE]) is not None]
    least = f", {min(clearances_m):.2f} m" if clearances_m else ""
    failed = ", ".join(f"{one.seed} {one.status}" for one in found if one not in good)
    return f"{len(good)}/{len(found)}{least}" + (f" ({failed})" if failed else "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:3", metavar="A:B")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--driver", action="append", metavar="D", help=f"by default {', '.join(DRIVERS)}")
    parser.add_argument("--base", action="append", metavar="SCENARIO", help=f"by default {', '.join(BASES)}")
    parser.add_argument("--weather", default="clear")
    parser.add_argument("--only", default="", metavar="WORD", help="only faults whose name contains WORD")
    parser.add_argument("--workers", type=int, metavar="N", help="as of vpf-sim sweep")
    parser.add_argument("--resume", action="store_true", help="continue the run in DIR")
    arguments = parser.parse_args()
    faults = [name for name in FAULTS if arguments.only in name]
    if not faults:
        parser.error(f"argument --only: expected a part of one of {', '.join(FAULTS)}, got {arguments.only!r}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    bases, drivers = arguments.base or BASES, arguments.driver or DRIVERS
    files = {(base, fault): write_scenario(arguments.out, base, fault) for base in bases for fault in faults}
    records = sweep(list(files.values()), arguments)
    rows = []
    for (base, fault), path in files.items():
        of_file = [record for record in records if record.scenario == str(path)]
        cells = [cell([record for record in of_file if record.driver == driver]) for driver in drivers]
        rows.append((base, fault, *cells))
    print_table(("scenario", "fault", *drivers), rows)


if __name__ == "__main__":
    main()
