"""`vpf-sim replay`: run a driver open loop on recorded drives."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vpf_sim.api.progress import say
from vpf_sim.cli.options import (
    DriverOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    print_json,
    prints_on_stderr,
)
from vpf_sim.cli.output import in_one_line, print_table
from vpf_sim.errors import InputError
from vpf_sim.files import file_name
from vpf_sim.system import command

if TYPE_CHECKING:
    from vpf_sim.replay.recording import Recording
    from vpf_sim.replay.replay_folder import ReplayFolder
    from vpf_sim.replay.tables import Table


DrivesArgument = Annotated[
    list[Path],
    typer.Argument(metavar="DRIVE", help="Folders of recordings, or videos; docs/recordings.md lists the layouts."),
]


WaterOption = Annotated[
    str | None,
    typer.Option("--water", metavar="WEATHER", help="Add simulated water of a weather to the windscreen."),
]
FaultsOption = Annotated[
    str | None,
    typer.Option("--faults", metavar="SCENARIO", help="Add simulated sensor faults of a scenario."),
]
VideoOption = Annotated[
    bool, typer.Option("--video/--no-video", help="Write a video of each drive with the driver's view.")
]


def replay(
    drive: DrivesArgument,
    driver: DriverOption = "vpf",
    out: OutOption = None,
    resume: ResumeOption = False,
    mixed: MixedOption = False,
    water: WaterOption = None,
    faults: FaultsOption = None,
    video: VideoOption = True,
    json: JsonOption = False,
) -> None:
    """Run a driver on recorded drives, in open loop.

    It is scored against the human and the ground truth.

    Exit code 1 on an error of the driver, 2 on an unusable recording; the other drives are still replayed.
    """
    from vpf_sim import drivers
    from vpf_sim.evaluation.sweeps import run_folder
    from vpf_sim.replay import inputs
    from vpf_sim.replay.replay_folder import ReplayFolder
    from vpf_sim.reporting.video import require
    from vpf_sim.system import limit_opencv

    limit_opencv()
    if video:
        require("replay without --no-video")
    with prints_on_stderr():
        drivers.create(driver)
    recordings, refused = _read(drive)
    if water is not None:
        recordings = _with_water(recordings, water)
    plan: dict[str, object] = {
        "driver": driver,
        "water": water,
        "drives": {name: str(at) for name, (at, _) in recordings.items()},
    }
    if faults is not None:
        recordings = _with_faults(recordings, faults)
        plan["faults"] = _fault_settings(faults)
    inputs_and_plan = {
        "plan": plan,
        **inputs.hashes({name: recording for name, (_, recording) in recordings.items()}, driver, water),
    }
    folder = ReplayFolder(out or run_folder.new_path("replay"), inputs_and_plan, resume, mixed)
    try:
        code = max(refused, _replay_all(folder, driver, [recording for _, recording in recordings.values()], video))
        summary = folder.summarize()
        if folder.done or code != 2:  # nothing to report if no drive could be used
            _report(folder, summary, json)
    except (KeyboardInterrupt, OSError):
        say(f"stopped with {len(folder.done)} of {len(recordings)} drives stored")
        say(f"go on with: {_resume_command(drive, driver, water, faults, video, mixed, folder.path)}")
        raise
    finally:
        folder.close()
    raise typer.Exit(code)


def _resume_command(
    drives: list[Path], driver: str, water: str | None, faults: str | None, video: bool, mixed: bool, folder: Path
) -> str:
    """The command that resumes the replay."""
    options = {"driver": driver, "water": water, "faults": faults, "no_video": not video}
    return command("replay", *drives, **options, out=folder, resume=True, mixed=mixed)


def _read(paths: list[Path]) -> "tuple[dict[str, tuple[Path, Recording]], int]":
    """The recordings by name, and 2 if one cannot be read: fatal only if there is no other."""
    from vpf_sim.replay import readers

    found: list[tuple[Path, Recording]] = []
    faults: list[InputError] = []
    for path in paths:
        try:
            found.append((path, readers.read(path)))
        except InputError as error:
            faults.append(error)
    if not found:
        raise InputError("\n".join(str(fault) for fault in faults))
    for fault in faults:
        _print_fault(str(fault))
    return _with_unique_names(found), 2 if faults else 0


def _with_water(recordings: "dict[str, tuple[Path, Recording]]", weather: str) -> "dict[str, tuple[Path, Recording]]":
    from vpf_sim.envs.camera import weather as weathers
    from vpf_sim.replay.added import with_water

    loaded = weathers.load(weather)
    return {name: (path, with_water(recording, loaded)) for name, (path, recording) in recordings.items()}


def _with_faults(recordings: "dict[str, tuple[Path, Recording]]", scenario: str) -> "dict[str, tuple[Path, Recording]]":
    from vpf_sim import scenarios
    from vpf_sim.replay.added import with_faults

    faults = scenarios.load(scenario).ego.sensor_faults
    return {name: (path, with_faults(recording, faults)) for name, (path, recording) in recordings.items()}


def _fault_settings(scenario: str) -> dict[str, object]:
    """The sensor faults of a scenario, for the manifest."""
    from vpf_sim import scenarios

    return scenarios.load(scenario).ego.sensor_faults.model_dump()


def _with_unique_names(found: "list[tuple[Path, Recording]]") -> "dict[str, tuple[Path, Recording]]":
    """Give drives of the same name a number, also where they differ only by case."""
    taken: set[str] = set()
    result = {}
    for path, recording in found:
        names = (recording.name, *(f"{recording.name}-{number}" for number in range(2, len(found) + 2)))
        name = next(name for name in names if file_name(name).casefold() not in taken)
        taken.add(file_name(name).casefold())
        result[name] = (path, replace(recording, name=name))
    return result


def _replay_all(folder: "ReplayFolder", driver: str, recordings: "list[Recording]", video: bool) -> int:
    """Replay each drive that lacks a record or its video; the worst exit code."""
    from vpf_sim.replay.frame_table import video_path

    code = 0
    for recording in recordings:
        lacks_video = video and not recording.no_images and not video_path(folder.path, recording.name).exists()
        if recording.name not in folder.done or lacks_video:
            code = max(code, _replay_one(folder, driver, recording, video))
    return max(code, *(int(record["error"] is not None) for record in folder.records()), 0)


def _replay_one(folder: "ReplayFolder", driver: str, recording: "Recording", video: bool) -> int:
    from vpf_sim import process_state
    from vpf_sim.replay import open_loop, open_loop_driver

    try:
        with prints_on_stderr(), process_state.preserved():
            record, _ = open_loop.run(recording, driver, folder.path, _progress(recording.name), video, folder.add)
    except InputError as error:
        _print_fault(str(error))
        return 2
    except OSError:
        raise
    except Exception as error:  # the driver's own; go on with the other drives
        _print_fault(f"{recording.name}: error: at {open_loop_driver.place(error)}: {open_loop_driver.what(error)}")
        return 1
    if (fault := record["error"]) is not None:
        where = f"frame {fault['frame']} of {len(recording)}, at {fault['place']}: {fault['what']}"
        _print_fault(f"{recording.name}: error: {where}; the frames before it are stored")
        return 1
    if not record["driven"]:
        _print_fault(recording.no_images)
        return 2
    return 0


def _print_fault(text: str) -> None:
    print(f"vpf-sim: {in_one_line(text)}", file=sys.stderr)


def _progress(name: str) -> Any:
    """A callback that prints the number of replayed frames on a terminal."""

    def show(done: int, total: int) -> None:
        if sys.stderr.isatty():
            print(
                f"\r{in_one_line(name)}: {done}/{total} frames",
                end="\n" if done == total else "",
                file=sys.stderr,
                flush=True,
            )

    return show


def _report(folder: "ReplayFolder", summary: dict[str, Any], as_json: bool) -> None:
    from vpf_sim.replay import page
    from vpf_sim.replay.tables import drives, real_images, warnings

    records, timing = folder.records(), folder.timing()
    path = page.write(folder.path, records, timing, summary)
    if as_json:
        print_json({"out": str(folder.path), "report": str(path), "drives": records, "timing": timing, **summary})
    else:
        print_short([warnings(records), drives(records), real_images(summary["rows"], summary["differences"])])
        print(f"\nall tables, plots and videos: {path}\nframes and records: {folder.path}")


def print_short(tables: "Sequence[Table]") -> None:
    """Print tables without notes and without rows that lack a recording, which the page has."""
    shown = [table for table in tables if len(table.rows) > table.empty]
    for number, table in enumerate(shown):
        print(("\n" if number else "") + table.title + "\n")
        print_table(table.header, table.rows[: len(table.rows) - table.empty], table.words)
