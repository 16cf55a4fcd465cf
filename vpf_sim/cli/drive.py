"""`vpf-sim drive`: one episode."""

import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
from vpf_sim.cli.tables import measure
from vpf_sim.tracebacks import cause

if TYPE_CHECKING:
    from vpf_sim.api.drive import Episode

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

    answer = sys.stdout
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
        redirect_stdout(answer),
    ):
        filling.warn([episode.record])
        _answer(episode, json)
    raise typer.Exit(0 if episode.status == "success" else 1)


def _answer(episode: "Episode", as_json: bool) -> None:
    record, timing, folder = episode.record, episode.timing, episode.path
    if episode.error and folder is not None:
        print(f"vpf-sim: {cause(episode.error)}", file=sys.stderr)
        print(f"vpf-sim: the traceback is in {folder / 'errors' / (record['id'] + '.txt')}", file=sys.stderr)
    if as_json:
        print_json({**record, "timing": {key: timing[key] for key in ("wall_s", "steps_per_s")}})
        return
    print(f"{record['id']}: {record['status']}")
    if record["collided_with"]:
        print(f"  collided with    {record['collided_with']}, {_fault(record)}")
    print(f"  route driven     {_share(record['route_completion'])}")
    print(f"  least clearance  {measure(record['min_clearance_m'], 'm')}")
    for line in _quality(record):
        print(f"  {line}")
    print(f"  {record['steps']} steps, {timing['steps_per_s']:.0f} a second")
    print(f"  record and steps {folder}")


def _fault(record: dict[str, Any]) -> str:
    """Whose fault a collision was, and why."""
    kind = record["collision_type"]
    lane = "out of its lane" if record["at_fault_collisions"] else "in its lane"
    why = {
        "stopped_ego": "it hit the ego, which stood",
        "stopped_track": "it stood",
        "active_rear": "it came from behind",
        "active_front": "the ego's front hit it",
        "active_lateral": f"the sides touched, the ego {lane}",
    }[kind]
    return f"the fault is {'the ego' if record['at_fault_collisions'] else 'the other'}'s: {why} ({kind})"


def _quality(record: dict[str, Any]) -> Iterator[str]:
    """Path and commands of a drive that arrived: those of a short one look better than they are."""
    if record["status"] != "success":
        yield "path, commands   not rated: it did not arrive"
        return
    yield f"path MSE         {measure(record['path_mse_m2'], 'm2', 3)}"
    if record["driver"] != "pid":
        shadow = (record["accuracy"] or {}).get("shadow") or {}
        shares = (f"{name} {_share((shadow.get(name) or {}).get('range'))}" for name in ("throttle", "steering"))
        yield f"like the PID     {', '.join(shares)} (100 % less half the mean difference, in the same states)"


def _share(share: float | None) -> str:
    """A share as a percentage."""
    return measure(None if share is None else 100.0 * share, "%", 1)
