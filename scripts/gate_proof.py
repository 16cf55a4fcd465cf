"""Proof of the default gate: unchanged runs of `vpf` must pass, degraded ones must fail.

    python scripts/gate_proof.py --out DIR [--unchanged 20] [--only WORD] [--workers N] [--rules FILE]

Each run is the one of action.yml: a sweep and a check by the default rules. The unchanged runs are on different seeds,
from --first-seed on; the degraded ones (`degraded_drivers.py`) on seed 0. Runs that are in DIR already are checked
without being driven again. Exit code 1 if an unchanged run fails, or more than one degradation passes.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from degraded_drivers import DEGRADED

from vpf_sim.cli.tables import print_table

SCRIPTS = Path(__file__).parent
MOST_MISSED = 1
CPU = "cpu_s.txt"  # in a run folder: CPU time of its sweep


class Outcome(NamedTuple):
    """A run's verdict: its failed checks of all, and the CPU time of its sweep."""

    name: str
    failed: list[dict[str, Any]]
    checks: int
    cpu_s: float

    def row(self) -> tuple[str, ...]:
        verdict = f"{len(self.failed)} of {self.checks} failed" if self.failed else "green"
        return self.name, verdict, f"{self.cpu_s:.0f}", self.first()

    def first(self) -> str:
        """The first failed check of the cell with the most."""
        if not self.failed:
            return ""
        cells = [(one["scenario"], one["weather"]) for one in self.failed]
        worst = max(cells, key=cells.count)
        one = next(one for one in self.failed if (one["scenario"], one["weather"]) == worst)
        return f"{', '.join(worst)}: {one['expected']}, got {one['actual'].partition(' (')[0]}"


def vpf_sim(*words: str) -> "subprocess.CompletedProcess[str]":
    """A command of ours that finds the degraded drivers; exit code 1 is a result, others end the proof."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(SCRIPTS), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "vpf_sim.cli", *words]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(done.returncode)
    return done


def run(name: str, driver: str, seed: int, arguments: argparse.Namespace) -> Outcome:
    """Drive the gate's grid if it is not stored, and check it."""
    folder = arguments.out / name.replace(" ", "-")
    if not (folder / "summary.json").exists():
        defaults = {key: given["default"] for key, given in action_inputs().items() if "default" in given}
        grid = [word for scenario in defaults["scenarios"].split() for word in ("--scenario", scenario)]
        grid += [word for weather in defaults["weathers"].split() for word in ("--weather", weather)]
        resume = ["--resume"] if folder.exists() else []
        seeds = f"{seed}:{seed + 1}"
        options = ["--seeds", seeds, "--out", str(folder), "--workers", str(arguments.workers), *resume]
        before_s = children_s()
        vpf_sim("sweep", *grid, "--driver", driver, *options)
        (folder / CPU).write_text(f"{children_s() - before_s:.1f}")
    rules = ["--rules", str(arguments.rules)] if arguments.rules else []
    checks = json.loads(vpf_sim("check", str(folder), *rules, "--json").stdout)["checks"]
    failed = [one for one in checks if one["outcome"] == "failed"]
    return Outcome(name, failed, len(checks), float((folder / CPU).read_text()))


def children_s() -> float:
    """CPU time of all processes that ended, s; unlike the time of day it does not depend on other work."""
    times = os.times()
    return times.children_user + times.children_system


def action_inputs() -> dict[str, dict[str, Any]]:
    """The inputs of the action, by name."""
    inputs: dict[str, dict[str, Any]] = yaml.safe_load((SCRIPTS.parent / "action.yml").read_text("utf-8"))["inputs"]
    return inputs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--unchanged", type=int, default=20, metavar="N", help="number of unchanged runs")
    parser.add_argument("--first-seed", type=int, default=100, metavar="N", help="of the unchanged runs")
    parser.add_argument("--only", default="", metavar="WORD", help="only degradations whose name contains WORD")
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="as of vpf-sim sweep")
    parser.add_argument("--rules", type=Path, metavar="FILE", help="in place of the default rules")
    arguments = parser.parse_args()
    degraded = [run(name, driver, 0, arguments) for name, driver in DEGRADED.items() if arguments.only in name]
    first = arguments.first_seed
    unchanged = [
        run(f"unchanged, seed {seed}", "vpf", seed, arguments) for seed in range(first, first + arguments.unchanged)
    ]
    header = ("run", "verdict", "CPU s", "first failed rule")
    print_table(header, [one.row() for one in [*unchanged, *degraded]], words=2, prose=True)
    green, caught = sum(not one.failed for one in unchanged), sum(bool(one.failed) for one in degraded)
    print(f"\n{green} of {len(unchanged)} unchanged runs green, {caught} of {len(degraded)} degradations caught")
    sys.exit(int(green < len(unchanged) or caught + MOST_MISSED < len(degraded)))


if __name__ == "__main__":
    main()
