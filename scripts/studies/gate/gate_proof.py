"""Proof of the default gate: unchanged runs of `vpf` must pass, degraded ones must fail.

    python scripts/studies/gate/gate_proof.py --out DIR [--unchanged 20] [--only WORD] [--workers N] [--rules FILE]

Each run is that of action.yml: a sweep, and a check by the default rules. The unchanged runs are on different seeds,
the degraded drivers (`degraded_drivers.py`) on the action's seed. Runs that are in DIR are only checked, unless they
are incomplete. Exit code 1 if an unchanged run fails, or more than one degradation passes.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml
from degraded_drivers import DEGRADED

from vpf_sim.cli.output import print_table

HERE = Path(__file__).parent
MOST_MISSED = 1
TIMEOUT_S = "3600"  # of an episode: other work on the machine is no failure
CPU = "cpu_s.txt"  # in a run folder: CPU time of its sweep


Check = dict[str, Any]


def vpf_sim(*words: str) -> str:
    """The output of a command that finds the degraded drivers; exit code 1 is a result, others end the proof."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "vpf_sim.cli", *words]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(done.returncode)
    return done.stdout


def drive(folder: Path, names: list[str], seeds: str, workers: int) -> None:
    """Drive the action's scenarios and weathers, unless the folder has them."""
    if (folder / "summary.json").exists():
        return
    defaults = yaml.safe_load((HERE.parents[2] / "action.yml").read_text("utf-8"))["inputs"]
    grid = {"--driver": names, "--seeds": [seeds], "--out": [str(folder)], "--workers": [str(workers)]}
    grid |= {
        "--scenario": defaults["scenarios"]["default"].split(),
        "--weather": defaults["weathers"]["default"].split(),
    }
    options = [word for option, values in grid.items() for value in values for word in (option, value)]
    before_s = children_s()
    vpf_sim("sweep", *options, "--timeout", TIMEOUT_S, *(["--resume"] if folder.exists() else []))
    (folder / CPU).write_text(f"{children_s() - before_s:.1f}")


def children_s() -> float:
    """CPU time of all processes that ended, s; unlike the time of day it does not depend on other work."""
    times = os.times()
    return times.children_user + times.children_system


def checks(folder: Path, rules: Path | None) -> list[Check]:
    """All checks of a run."""
    found: list[Check] = json.loads(
        vpf_sim("check", str(folder), *(["--rules", str(rules)] if rules else []), "--json")
    )["checks"]
    return found


def row(name: str, found: list[Check]) -> tuple[str, ...]:
    """A run's verdict, and its first failed check in the cell with the most."""
    failed = [one for one in found if one["outcome"] == "failed"]
    if not failed:
        return name, "green", ""
    cells = [(one["scenario"], one["weather"]) for one in failed]
    worst = max(cells, key=cells.count)
    first = next(one for one in failed if (one["scenario"], one["weather"]) == worst)
    said = f"{', '.join(worst)}: {first['expected']}, got {first['actual'].partition(' (')[0]}"
    return name, f"{len(failed)} of {len(found)} failed", said


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--unchanged", type=int, default=20, metavar="N", help="number of unchanged runs")
    parser.add_argument("--first-seed", type=int, default=100, metavar="N", help="of the unchanged runs")
    parser.add_argument("--only", default="", metavar="WORD", help="only degradations whose name contains WORD")
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="as of vpf-sim sweep")
    parser.add_argument("--rules", type=Path, metavar="FILE", help="in place of the default rules")
    arguments = parser.parse_args()
    names = {name: driver for name, driver in DEGRADED.items() if arguments.only in name}
    rows = []
    for seed in range(arguments.first_seed, arguments.first_seed + arguments.unchanged):
        folder = arguments.out / f"unchanged-{seed}"
        drive(folder, ["vpf"], f"{seed}:{seed + 1}", arguments.workers)
        rows.append(row(f"unchanged, seed {seed}", checks(folder, arguments.rules)))
    green = sum(one[1] == "green" for one in rows)
    if names:
        drive(arguments.out / "degraded", list(names.values()), "0:1", arguments.workers)
        found = checks(arguments.out / "degraded", arguments.rules)
        rows += [row(name, [one for one in found if one["driver"] == driver]) for name, driver in names.items()]
    caught = len(rows) - arguments.unchanged - sum(one[1] == "green" for one in rows[arguments.unchanged :])
    print_table(("run", "verdict", "first failed rule"), rows, words=2, prose=True)
    print(f"\n{green} of {arguments.unchanged} unchanged runs green, {caught} of {len(names)} degradations caught")
    cpu_s = [float(path.read_text()) for path in arguments.out.glob(f"unchanged-*/{CPU}")]
    print(f"CPU time of a run: {min(cpu_s):.0f} to {max(cpu_s):.0f} s")
    sys.exit(int(green < arguments.unchanged or caught + MOST_MISSED < len(names)))


if __name__ == "__main__":
    main()
