"""`vpf-sim drive`: one episode."""

import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import (
    DriverOption,
    JsonOption,
    NewOutOption,
    ScenarioArgument,
    WeatherOption,
    print_json,
    prints_on_stderr,
)
from vpf_sim.cli.output import measured
from vpf_sim.errors import cause

if TYPE_CHECKING:
    from vpf_sim.api.drive import Episode
    from vpf_sim.evaluation.metrics.records import Record

SeedOption = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the scenario's random parts.")]
VideoOption = Annotated[
    Path | None, typer.Option("--video", metavar="FILE", help="Write an .mp4 with the driver's perception and plan.")
]
WatchOption = Annotated[bool, typer.Option("--watch", help="Show the frames in a window.")]
RerunOption = Annotated[
    Path | None, typer.Option("--rerun", metavar="FILE", help="Write an .rrd recording for the Rerun viewer.")
]


def drive(
    scenario: ScenarioArgument,
    weather: WeatherOption = "clear",
    driver: DriverOption = "vpf",
    seed: SeedOption = 0,
    video: VideoOption = None,
    watch: WatchOption = False,
    rerun: RerunOption = None,
    out: NewOutOption = None,
    json: JsonOption = False,
) -> None:
    """Drive one episode; exit code 1 if it does not succeed."""
    from vpf_sim.api import filling
    from vpf_sim.api.drive import driven

    stdout = sys.stdout
    with (
        prints_on_stderr(),
        driven(
            scenario,
            driver=driver,
            weather=weather,
            seed=seed,
            video=video,
            watch=watch,
            rerun=rerun,
            out=True if out is None else out,
        ) as episode,
        redirect_stdout(stdout),
    ):
        filling.warn([episode.result.record])
        print_episode(episode, json)
    raise typer.Exit(0 if episode.status == "success" else 1)


def print_episode(episode: "Episode", as_json: bool) -> None:
    """Print how an episode ended, or its record as JSON."""
    from vpf_sim.evaluation.metrics.registry import CLEARANCE, COMPLETION

    record, timing, folder = episode.result.record, episode.result.timing, episode.path
    if episode.error and folder is not None:
        print(f"vpf-sim: {cause(episode.error)}", file=sys.stderr)
        print(f"vpf-sim: the traceback is in {folder / 'errors' / (record.id + '.txt')}", file=sys.stderr)
    if as_json:
        print_json({**record.as_json(), "timing": {"wall_s": timing.wall_s, "steps_per_s": timing.steps_per_s}})
        return
    print(f"{record.id}: {record.status}")
    if record.collided_with:
        print(f"  collided with    {record.collided_with}, {_fault(record)}")
    print(f"  route driven     {measured(COMPLETION, record)}")
    print(f"  least clearance  {measured(CLEARANCE, record)}")
    for line in _quality(record):
        print(f"  {line}")
    print(f"  {record.steps} steps, {timing.steps_per_s:.0f} a second")
    print(f"  record and steps {folder}")


def _fault(record: "Record") -> str:
    """Whose fault a collision was, and why."""
    from vpf_sim.evaluation.metrics.registry import AT_FAULT

    kind, is_at_fault = str(record.collision_type), bool(record[AT_FAULT])
    why = {
        "stopped_ego": "it hit the ego, which stood",
        "stopped_track": "it stood",
        "active_rear": "it came from behind",
        "active_front": "the ego's front hit it",
        "active_lateral": f"the sides touched, the ego {'out of' if is_at_fault else 'in'} its lane",
    }[kind]
    return f"the fault is {'the ego' if is_at_fault else 'the other'}'s: {why} ({kind})"


def _quality(record: "Record") -> Iterator[str]:
    """Path and commands of a drive that arrived: those of a short drive would seem better than they are."""
    from vpf_sim.evaluation.metrics.registry import PATH_MSE, STEERING, THROTTLE

    if not record.succeeded:
        yield "path, commands   not rated: it did not arrive"
        return
    yield f"path MSE         {measured(PATH_MSE, record)}"
    if record.driver != "pid":
        shares = f"throttle {measured(THROTTLE, record)}, steering {measured(STEERING, record)}"
        yield f"like the PID     {shares} (100 % less half the mean difference, in the same states)"
