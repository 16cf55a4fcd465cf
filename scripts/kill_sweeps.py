"""Kill sweeps at random times and resume them: the result must be that of an undisturbed sweep, with nothing lost.

    python scripts/kill_sweeps.py --rounds 20 --seed 0 --out /tmp/kills

Each round starts a sweep with two workers. At a random time the parent is killed or interrupted, or a worker is killed;
after a kill of the parent, the last record may be truncated. The sweep is resumed until it finishes. Records, steps and
tables must be equal, and no episode that had been finished may be driven again. Exit code 1 if any round differs.
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

from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.run_folder import read_lines

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
DISTURBANCES = 3  # at most in a round; one per session, since two killed workers may give up an episode
TIMEOUT_S = "600"  # of an episode, so that a busy machine gives up none
LATER_S = 1.0  # longest delay after the awaited record
Contents = tuple[list[str], dict[str, bytes], bytes]  # records, steps, table


def sweep(folder: Path, out: Path, *more: str) -> list[str]:
    """The command that starts or resumes the sweep."""
    grid = ["--scenario", str(folder / "short.toml"), "--driver", "pid", "--driver", "neutral"]
    resume = ["--resume"] if (out / "manifest.json").exists() else []
    requested = [*grid, "--seeds", f"0:{SEEDS}", "--out", str(out), "--timeout", TIMEOUT_S, *resume, *more]
    return [sys.executable, "-m", "vpf_sim.cli", "sweep", *requested]


def contents(out: Path) -> Contents:
    """The records, steps and table, which must not depend on interruptions."""
    steps = {path.name: path.read_bytes() for path in sorted((out / "steps").iterdir()) if path.suffix == ".parquet"}
    lines = (out / "episodes.jsonl").read_text().splitlines()
    return sorted(lines), steps, (out / "summary.json").read_bytes()


def finished(out: Path) -> dict[str, Json]:
    """The timing of each episode with a record, which is another one if it is driven again."""
    timing = {row["id"]: row for row in read_lines(out / "timing.jsonl")}
    return {row["id"]: timing[row["id"]] for row in read_lines(out / "episodes.jsonl")}


def workers_of(parent: int) -> list[int]:
    """The process ids of a sweep's workers."""
    try:
        children = [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
        return [pid for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    except FileNotFoundError:
        return []


def disturb(running: "subprocess.Popen[bytes]", choice: random.Random) -> str:
    """Kill a process; returns which one."""
    workers = workers_of(running.pid)
    victim = choice.choice(["parent", "parent", "worker", "worker", "Ctrl-C"])
    if victim == "worker":
        if workers:
            with suppress(ProcessLookupError):
                os.kill(choice.choice(workers), signal.SIGKILL)
        return victim if workers else "no worker yet"
    running.send_signal(signal.SIGINT if victim == "Ctrl-C" else signal.SIGKILL)
    return victim


def truncate(out: Path) -> None:
    """Append half a record, as after a crash during a write."""
    if (out / "episodes.jsonl").exists():
        with (out / "episodes.jsonl").open("a") as file:
            file.write('{"accuracy": {"shadow": {"thro')


def session(folder: Path, out: Path, choice: random.Random) -> tuple[str, dict[str, Json]]:
    """Start or resume the sweep, disturb it once, and wait for its end; what happened, and what was finished."""
    before = len(read_lines(out / "episodes.jsonl"))
    wait_for = choice.randint(min(before, 2 * SEEDS - 1), 2 * SEEDS - 1) if choice.random() < 0.8 else 0
    with subprocess.Popen(sweep(folder, out, "--workers", "2"), stdout=DEVNULL, stderr=DEVNULL) as running:
        while running.poll() is None and len(read_lines(out / "episodes.jsonl")) < wait_for:
            sleep(0.01)
        sleep(choice.uniform(0.0, LATER_S))
        if running.poll() is not None:
            return "it had ended", finished(out)
        victim = disturb(running, choice)
    stored = finished(out)
    truncated = victim == "parent" and choice.random() < 0.5
    if truncated:
        truncate(out)
    return f"{victim} after {wait_for}, {len(stored)} stored at its end{', line truncated' * truncated}", stored


def killed(folder: Path, out: Path, choice: random.Random) -> tuple[str, int]:
    """Run one round; what happened in its sessions, and how many finished episodes were lost."""
    events, kept = [], dict[str, Json]()
    for _ in range(choice.randint(1, DISTURBANCES)):
        event, stored = session(folder, out, choice)
        events.append(event)
        kept = {**stored, **kept}
    subprocess.run(sweep(folder, out, "--workers", "2"), check=True, stdout=DEVNULL, stderr=DEVNULL)
    at_the_end = finished(out)
    return "; ".join(events), sum(at_the_end.get(name) != timing for name, timing in kept.items())


def undisturbed(folder: Path) -> Contents:
    """The contents of a sweep with one worker."""
    subprocess.run(sweep(folder, folder / "serial", "--workers", "1"), check=True, stdout=DEVNULL, stderr=DEVNULL)
    return contents(folder / "serial")


def new_folder(parser: argparse.ArgumentParser, folder: Path) -> Path:
    """The folder of the option --out, made; the parser refuses one that exists."""
    if folder.exists():
        parser.error(f"--out: expected a new folder, got {folder}")
    folder.mkdir(parents=True)
    return folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of times and killed processes")
    parser.add_argument("--out", type=Path, required=True, help="a new folder")
    arguments = parser.parse_args()
    folder = new_folder(parser, arguments.out)
    (folder / "short.toml").write_text(SCENARIO)
    wanted = undisturbed(folder)
    choice, equal, all_lost = random.Random(arguments.seed), 0, 0
    for number in range(arguments.rounds):
        events, lost = killed(folder, folder / f"round-{number}", choice)
        lines, *rest = contents(folder / f"round-{number}")
        same = (lines, *rest) == wanted
        equal, all_lost = equal + same, all_lost + lost
        print(
            f"round {number}: {events}: {len(lines)} records, {'equal' if same else 'DIFFERENT'}, {lost} lost",
            flush=True,
        )
    equals = f"{equal} of {arguments.rounds} rounds equal to the undisturbed sweep"
    print(f"{equals} of {len(wanted[0])} episodes, {all_lost} lost")
    sys.exit(0 if equal == arguments.rounds and not all_lost else 1)


if __name__ == "__main__":
    main()
