"""Kill sweeps at random moments and resume them: records, steps and tables must equal those of an undisturbed one.

    python scripts/kill_sweeps.py --rounds 20 --seed 0 --out /tmp/kills

In each round a sweep with two workers is started; at a random moment its parent is killed or interrupted, or one of its
workers is killed, and where the parent ended the last line of the records may be torn. It is resumed until it ends by
itself. Exit code 1 if any round differs.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from subprocess import DEVNULL
from time import sleep

from vpf_sim.evaluation.sweeps.json_lines import read_lines

SCENARIO = """
schema = 1
[road]
segments = [{kind = "line", length_m = 80}]
[goal]
s_m = 9.0
[vary]
"ego.lateral_m" = [-0.3, 0.3]
"""
SEEDS = 6  # twice as many episodes, as there are two drivers
DISTURBANCES = 3  # of a round, at most; a session has one, for two killed workers in it may give an episode up
LATER_S = 1.0  # at most, after the record that is waited for
Contents = tuple[list[str], dict[str, bytes], bytes]  # records, steps, table


def sweep(folder: Path, out: Path, *more: str) -> list[str]:
    """The command; it goes on with what is there."""
    grid = ["--scenario", str(folder / "short.toml"), "--driver", "pid", "--driver", "neutral"]
    resume = ["--resume"] if (out / "manifest.json").exists() else []
    asked = [*grid, "--seeds", f"0:{SEEDS}", "--out", str(out), *resume, *more]
    return [sys.executable, "-m", "vpf_sim.cli", "sweep", *asked]


def contents(out: Path) -> Contents:
    """What must not depend on how it came about: the records, the steps, the table."""
    steps = {path.name: path.read_bytes() for path in sorted((out / "steps").iterdir()) if path.suffix == ".parquet"}
    lines = (out / "episodes.jsonl").read_text().splitlines()
    return sorted(lines), steps, (out / "summary.json").read_bytes()


def workers_of(parent: int) -> list[int]:
    """Process ids."""
    try:
        children = [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
        return [pid for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    except FileNotFoundError:
        return []


def disturb(running: "subprocess.Popen[bytes]", choice: random.Random) -> str:
    """Kill somebody; who it was."""
    workers = workers_of(running.pid)
    victim = choice.choice(["parent", "parent", "worker", "worker", "Ctrl-C"])
    if victim == "worker":
        if workers:
            with suppress(ProcessLookupError):
                os.kill(choice.choice(workers), signal.SIGKILL)
        return victim if workers else "nobody yet"
    running.send_signal(signal.SIGINT if victim == "Ctrl-C" else signal.SIGKILL)
    return victim


def tear(out: Path) -> None:
    """Half a line at the end, as if the crash had come while it was written."""
    if (out / "episodes.jsonl").exists():
        with (out / "episodes.jsonl").open("a") as file:
            file.write('{"accuracy": {"shadow": {"thro')


def session(folder: Path, out: Path, choice: random.Random) -> str:
    """Start or resume the sweep, disturb it once, and wait for its end; what happened."""
    before = len(read_lines(out / "episodes.jsonl"))
    wait_for = choice.randint(min(before, 2 * SEEDS - 1), 2 * SEEDS - 1) if choice.random() < 0.8 else 0
    with subprocess.Popen(sweep(folder, out, "--workers", "2"), stdout=DEVNULL, stderr=DEVNULL) as running:
        while running.poll() is None and len(read_lines(out / "episodes.jsonl")) < wait_for:
            sleep(0.01)
        sleep(choice.uniform(0.0, LATER_S))
        if running.poll() is not None:
            return "it had ended"
        victim = disturb(running, choice)
    stored = len(read_lines(out / "episodes.jsonl"))
    torn = victim == "parent" and choice.random() < 0.5
    if torn:
        tear(out)
    return f"{victim} after {wait_for}, {stored} stored at its end{', line torn' * torn}"


def killed(folder: Path, out: Path, choice: random.Random) -> str:
    """One round; what happened in its sessions."""
    told = [session(folder, out, choice) for _ in range(choice.randint(1, DISTURBANCES))]
    subprocess.run(sweep(folder, out, "--workers", "2"), check=True, stdout=DEVNULL, stderr=DEVNULL)
    return "; ".join(told)


def undisturbed(folder: Path) -> Contents:
    """What a sweep with one worker makes."""
    subprocess.run(sweep(folder, folder / "serial", "--workers", "1"), check=True, stdout=DEVNULL, stderr=DEVNULL)
    return contents(folder / "serial")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the moments and victims")
    parser.add_argument("--out", type=Path, required=True, help="a new folder")
    arguments = parser.parse_args()
    folder: Path = arguments.out
    folder.mkdir(parents=True)
    (folder / "short.toml").write_text(SCENARIO)
    wanted = undisturbed(folder)
    choice, equal = random.Random(arguments.seed), 0
    for number in range(arguments.rounds):
        told = killed(folder, folder / f"round-{number}", choice)
        lines, *rest = contents(folder / f"round-{number}")
        same = (lines, *rest) == wanted
        equal += same
        print(f"round {number}: {told}: {len(lines)} records, {'equal' if same else 'DIFFERENT'}", flush=True)
    print(f"{equal} of {arguments.rounds} rounds equal to the undisturbed sweep of {len(wanted[0])} episodes")
    sys.exit(0 if equal == arguments.rounds else 1)


if __name__ == "__main__":
    main()
