"""What a sweep would drive."""

from typing import TYPE_CHECKING

from vpf_sim.cli.options import print_json, prints_on_stderr
from vpf_sim.cli.tables import print_table

if TYPE_CHECKING:
    from vpf_sim.cli.run_options import RunOptions
    from vpf_sim.evaluation.sweeps.plan import Plan


def print_plan(plan: "Plan", run: "RunOptions") -> None:
    """Check a plan as a sweep would, and print its cells and episodes without driving or writing."""
    from vpf_sim.evaluation.sweeps.run_folder import admitted, manifest, read_records
    from vpf_sim.evaluation.sweeps.seeds import seeds_text

    run.check(plan)
    with prints_on_stderr():
        asked = manifest("sweep", plan)
    done: set[str] = set()
    if run.out is not None:
        admitted(run.out, asked, run.resume, run.mixed)
        done = {record["id"] for record in read_records(run.out)} if run.resume else set()
    cells: dict[tuple[str, str, str], list[int]] = {}
    for job in plan.jobs():
        if job.id not in done:
            cells.setdefault((job.scenario, job.weather, job.driver), []).append(job.seed)
    episodes = sum(map(len, cells.values()))
    if run.json:
        keys = ("scenario", "weather", "driver", "seeds")
        rows = [dict(zip(keys, (*cell, seeds), strict=True)) for cell, seeds in cells.items()]
        print_json({"episodes": episodes, "stored": len(done), "cells": rows})
        return
    lines = [(*cell, str(len(seeds)), seeds_text(seeds, "--seeds")) for cell, seeds in cells.items()]
    print_table(("scenario", "weather", "driver", "episodes", "seeds"), lines, words=3)
    stored = f", {len(done)} are stored" if run.resume else ""
    to_drive = f"{_counted(episodes, 'episode')} to drive in {_counted(len(cells), 'cell')}"
    print(f"\n{to_drive}{stored}; nothing was driven or written")


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" + "s" * (count != 1)
