"""Repeat one sweep many times on two workers: records, steps and table must be equal, and each run verified.

    python scripts/repeat_sweeps.py --rounds 100 --out /tmp/repeats

The sweep drives two scenarios with two drivers, one of which sees. Of each run, one episode is driven again
(`vpf-sim verify`). Exit code 1 if any run differs or is not verified.
"""

import argparse
import subprocess
import sys
from collections import Counter
from hashlib import sha256
from pathlib import Path
from subprocess import DEVNULL
from time import perf_counter

from kill_sweeps import SCENARIO, TIMEOUT_S, contents, new_folder

BEND = """
schema = 1
[road]
segments = [{kind = "arc", length_m = 80, radius_m = 60}]
[goal]
s_m = 9.0
[[bodies]]
kind = "car"
s_m = 20.0
lane = 2
lateral_m = 3.5
"""


def sweep(folder: Path, out: Path, seeds: str) -> None:
    """Drive the sweep into a new folder."""
    scenarios = [option for name in ("short", "bend") for option in ("--scenario", str(folder / f"{name}.toml"))]
    grid = [*scenarios, "--driver", "lane-lines", "--driver", "expert", "--seeds", seeds]
    command = [
        sys.executable,
        "-m",
        "vpf_sim.cli",
        "sweep",
        *grid,
        "--workers",
        "2",
        "--timeout",
        TIMEOUT_S,
        "--out",
        str(out),
    ]
    subprocess.run(command, check=True, stdout=DEVNULL, stderr=DEVNULL)


def digest(out: Path) -> str:
    """One hash of a run's records, steps and table."""
    lines, steps, table = contents(out)
    whole = sha256("\n".join(lines).encode())
    for name, content in sorted(steps.items()):
        whole.update(name.encode() + content)
    whole.update(table)
    return whole.hexdigest()


def is_verified(out: Path, seed: int) -> bool:
    """Whether `vpf-sim verify` passes the run."""
    command = [sys.executable, "-m", "vpf_sim.cli", "verify", str(out), "--seed", str(seed), "--workers", "1"]
    return subprocess.run(command, stdout=DEVNULL, stderr=DEVNULL, check=False).returncode == 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seeds", default="0:2", help="of the sweep")
    parser.add_argument("--out", type=Path, required=True, help="a new folder")
    options = parser.parse_args()
    folder = new_folder(parser, options.out)
    for name, text in (("short", SCENARIO), ("bend", BEND)):
        (folder / f"{name}.toml").write_text(text)
    hashes, verified, began_s = Counter[str](), 0, perf_counter()
    for number in range(options.rounds):
        out = folder / f"round-{number}"
        sweep(folder, out, options.seeds)
        found = digest(out)
        hashes[found] += 1
        passes = is_verified(out, number)
        verified += passes
        words = f"{'verified' if passes else 'NOT VERIFIED'}, {perf_counter() - began_s:.0f} s"
        print(f"round {number}: {found[:16]}, {words}", flush=True)
    equal = hashes.most_common(1)[0][1]
    print(f"{equal} of {options.rounds} runs equal, {verified} of {options.rounds} verified")
    sys.exit(0 if equal == verified == options.rounds else 1)


if __name__ == "__main__":
    main()
