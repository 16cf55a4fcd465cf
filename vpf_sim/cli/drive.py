"""`vpf-sim drive`: one episode."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from vpf_sim.cli.options import (
    DriverOption,
    JsonOption,
    OutOption,
    WeatherOption,
    check_output,
    print_json,
    prints_on_stderr,
)
from vpf_sim.cli.tables import measure

ScenarioArgument = Annotated[str, typer.Argument(metavar="SCENARIO", help="Name or file of a scenario.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of the scenario's random parts.")]
VideoOption = Annotated[
    Path | None, typer.Option("--video", help="Write an .mp4 with the driver's perception and plan.")
]
WatchOption = Annotated[bool, typer.Option("--watch", help="Show the frames in a window.")]
RerunOption = Annotated[Path | None, typer.Option("--rerun", help="Write an .rrd recording for the Rerun viewer.")]


def drive(
    scenario: ScenarioArgument,
    weather: WeatherOption = "clear",
    driver: DriverOption = "vpf",
    seed: SeedOption = 0,
    video: VideoOption = None,
    watch: WatchOption = False,
    rerun: RerunOption = None,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Drive one episode; exit code 1 if it does not succeed."""
    from vpf_sim.cli import invalid_frames, viewers
    from vpf_sim.evaluation import steps
    from vpf_sim.evaluation.episode import episode
    from vpf_sim.evaluation.processes.threads import limit_opencv
    from vpf_sim.evaluation.sweeps import run_folder
    from vpf_sim.evaluation.sweeps.plan import Plan

    check_output("--video", video)
    check_output("--rerun", rerun)
    limit_opencv()
    plan = Plan((scenario,), (weather,), (driver,), f"{seed}:{seed + 1}")
    with prints_on_stderr():
        asked = run_folder.manifest("drive", plan)
    with viewers.attached(video, watch, rerun) as attached:
        with prints_on_stderr():
            folder = run_folder.RunFolder(out or run_folder.new_path("drive"), asked)
            try:
                result = episode.run(scenario, weather, driver, seed, attached.show)
            except BaseException:  # mostly Ctrl-C
                folder.discard()
                raise
        steps.write(result.steps, folder.path / "steps" / f"{result.record['id']}.parquet")
        folder.add(result.record, result.timing)
        folder.close()
        invalid_frames.warn([result.record])
        _answer(result, folder.path, json)
        attached.finish(result.steps)  # last: if the disk is full, all else is already stored
    raise typer.Exit(0 if result.record["status"] == "success" else 1)


def _answer(result: Any, folder: Path, as_json: bool) -> None:
    record, timing = result.record, result.timing
    if "traceback" in timing:
        print(f"vpf-sim: {timing['traceback'].strip().splitlines()[-1]}", file=sys.stderr)
        print(f"vpf-sim: the traceback is in {folder / 'errors' / (record['id'] + '.txt')}", file=sys.stderr)
    if as_json:
        print_json({**record, "timing": {key: timing[key] for key in ("wall_s", "steps_per_s")}})
        return
    shadow = (record["accuracy"] or {}).get("shadow") or {}
    accuracy = ", ".join(f"{name} {_share((shadow.get(name) or {}).get('range'))}" for name in ("throttle", "steering"))
    print(f"{record['id']}: {record['status']}")
    print(f"  route driven     {_share(record['route_completion'])}")
    print(f"  path MSE         {measure(record['path_mse_m2'], 'm2', 3)}")
    print(f"  least clearance  {measure(record['min_clearance_m'], 'm')}")
    print(f"  against the PID  {accuracy} (range, shadow)")
    print(f"  {record['steps']} steps, {timing['steps_per_s']:.0f} a second")
    print(f"  record and steps {folder}")


def _share(share: float | None) -> str:
    """A share as a percentage."""
    return measure(None if share is None else 100.0 * share, "%", 1)
