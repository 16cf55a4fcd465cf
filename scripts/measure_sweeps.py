"""Measure sweeps: episodes an hour with 2 workers against 1, and memory growth of a worker.

    python scripts/measure_sweeps.py workers --episodes 24
    python scripts/measure_sweeps.py memory --episodes 200

Times are wall times from the first episode to the last, without the start of the workers. They need an idle machine, so
the load average is printed too.
"""

import argparse
import json
import os
import tempfile
from functools import partial
from pathlib import Path
from time import monotonic

from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.processes import pool

SCENARIO = """
schema = 1
[road]
segments = [{{kind = "line", length_m = 80}}]
[goal]
s_m = {goal_m}
[vary]
"ego.lateral_m" = [-0.3, 0.3]
"""
WEATHERS = ("clear", "rain")
SETTLED = 20  # episodes before growth is measured: imports and caches are complete
MIB = 2**20


def job(folder: Path, number: int) -> Job:
    """A short episode of the whole stack, alternating clear weather and rain."""
    return Job(str(folder / "short.toml"), WEATHERS[number % 2], "vpf", number)


def drive(folder: Path, number: int) -> tuple[float, float]:
    """Run on a worker: end time of an episode, s, and memory in use, MiB."""
    episode.run(*job(folder, number))
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return monotonic(), pages * os.sysconf("SC_PAGE_SIZE") / MIB


def rate(folder: Path, episodes: int, workers: int) -> float:
    """Episodes an hour, without the first of each worker, which includes imports."""
    ends = sorted(done.result[0] for done in pool.run(partial(drive, folder), range(episodes), workers) if done.result)
    return 3600.0 * (len(ends) - workers) / (ends[-1] - ends[workers - 1])


def compare_workers(folder: Path, episodes: int) -> dict[str, float]:
    one, two = (rate(folder, episodes, workers) for workers in (1, 2))
    return {"episodes_per_hour_1": one, "episodes_per_hour_2": two, "ratio": two / one}


def watch_memory(folder: Path, episodes: int) -> dict[str, float]:
    """Memory, MiB: after the first episodes, after the last, the growth, and the maximum."""
    used = [done.result[1] for done in pool.run(partial(drive, folder), range(episodes), 1) if done.result]
    first, last = max(used[:SETTLED]), max(used[-SETTLED:])
    return {"settled_mib": first, "end_mib": last, "growth_mib": last - first, "most_mib": max(used)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("workers", "memory"))
    parser.add_argument("--episodes", type=int, required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        goal_m = 16.0 if arguments.what == "workers" else 7.0
        (folder / "short.toml").write_text(SCENARIO.format(goal_m=goal_m))
        before = os.getloadavg()[0]
        found = (compare_workers if arguments.what == "workers" else watch_memory)(folder, arguments.episodes)
    load = {"load_before": before, "load_after": os.getloadavg()[0]}
    print(json.dumps({"episodes": arguments.episodes, **found, **load}, indent=2))


if __name__ == "__main__":
    main()
