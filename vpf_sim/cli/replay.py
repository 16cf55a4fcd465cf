"""`vpf-sim replay`: run a driver open loop on recorded drives."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    from vpf_sim.replay.records import Summary
    from vpf_sim.replay.replay_folder import ReplayFolder
    from vpf_sim.reporting.kit.page import Table


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
    from vpf_sim.replay import replay_folder
    from vpf_sim.replay.records import ReplayPlan
    from vpf_sim.replay.replay_folder import ReplayFolder
    from vpf_sim.reporting.video import require
    from vpf_sim.system import limit_opencv

    limit_opencv()
    if video:
        require("replay without --no-video")
    with prints_on_stderr():
        drivers.create(driver)
    found, refused = _read(drive)
    recordings, settings = _simulated([recording for _, recording in found], water, faults)
    drives = {recording.name: str(path) for path, recording in found}
    plan = ReplayPlan(driver=driver, water=water, drives=drives, faults=settings)
    manifest = replay_folder.manifest(plan, recordings)
    folder = ReplayFolder(out or run_folder.new_path("replay"), manifest, resume, mixed)
    try:
        code = max(refused, _replay_all(folder, driver, recordings, video))
        summary = folder.summarize()
        if folder.done or code != 2:  # nothing to report if no drive could be used
            _report(folder, summary, json)
    except (KeyboardInterrupt, OSError):
        say(f"stopped with {len(folder.done)} of {len(recordings)} drives stored")
        options = {"driver": driver, "water": water, "faults": faults, "no_video": not video}
        say(f"go on with: {command('replay', *drive, **options, out=folder.path, resume=True, mixed=mixed)}")
        raise
    finally:
        folder.close()
    raise typer.Exit(code)


def _read(paths: list[Path]) -> "tuple[list[tuple[Path, Recording]], int]":
    """Paths and recordings, and 2 if one cannot be read: fatal only if there is no other."""
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


def _simulated(
    recordings: "list[Recording]", water: str | None, faults: str | None
) -> "tuple[list[Recording], dict[str, object] | None]":
    """The recordings with a weather's water and a scenario's sensor faults, and the settings of the faults."""
    from vpf_sim import scenarios
    from vpf_sim.envs.camera import weather
    from vpf_sim.replay import added

    if water is not None:
        wet = weather.load(water)
        recordings = [added.with_water(recording, wet) for recording in recordings]
    if faults is None:
        return recordings, None
    sensors = scenarios.load(faults).ego.sensor_faults
    return [added.with_faults(recording, sensors) for recording in recordings], sensors.model_dump()


def _with_unique_names(found: "list[tuple[Path, Recording]]") -> "list[tuple[Path, Recording]]":
    """Give drives of the same name a number, also where they differ only by case."""
    taken: set[str] = set()
    result = []
    for path, recording in found:
        names = (recording.name, *(f"{recording.name}-{number}" for number in range(2, len(found) + 2)))
        name = next(name for name in names if file_name(name).casefold() not in taken)
        taken.add(file_name(name).casefold())
        result.append((path, replace(recording, name=name)))
    return result


def _replay_all(folder: "ReplayFolder", driver: str, recordings: "list[Recording]", video: bool) -> int:
    """Replay each drive that lacks a record or its video; the worst exit code."""
    from vpf_sim.replay.frame_table import video_path

    code = 0
    for recording in recordings:
        lacks_video = video and not recording.no_images and not video_path(folder.path, recording.name).exists()
        if recording.name not in folder.done or lacks_video:
            code = max(code, _replay_one(folder, driver, recording, video))
    return max(code, *(int(record.error is not None) for record in folder.records()), 0)


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
    if (fault := record.error) is not None:
        where = f"frame {fault.frame} of {len(recording)}, at {fault.place}: {fault.what}"
        _print_fault(f"{recording.name}: error: {where}; the frames before it are stored")
        return 1
    if not record.driven:
        _print_fault(recording.no_images)
        return 2
    return 0


def _print_fault(text: str) -> None:
    print(f"vpf-sim: {in_one_line(text)}", file=sys.stderr)


def _progress(name: str) -> Callable[[int, int], None]:
    """A callback that prints the number of replayed frames on a terminal."""

    def show(done: int, total: int) -> None:
        if sys.stderr.isatty():
            end = "\n" if done == total else ""
            print(f"\r{in_one_line(name)}: {done}/{total} frames", end=end, file=sys.stderr, flush=True)

    return show


def _report(folder: "ReplayFolder", summary: "Summary", as_json: bool) -> None:
    from vpf_sim.replay import page
    from vpf_sim.replay.tables import drives, real_images, warnings

    records, timing = folder.records(), folder.timing()
    path = page.write(folder.path, records, timing, summary)
    if as_json:
        stored = [record.as_json() for record in records]
        times = {name: one.model_dump() for name, one in timing.items()}
        where = {"out": str(folder.path), "report": str(path)}
        print_json({**where, "drives": stored, "timing": times, **summary.model_dump()})
    else:
        print_short([warnings(records), drives(records), real_images(summary)])
        print(f"\nall tables, plots and videos: {path}\nframes and records: {folder.path}")


def print_short(tables: "Sequence[Table]") -> None:
    """Print tables without notes and without rows that lack a recording, which the page has."""
    shown = [table for table in tables if len(table.rows) > table.faint]
    for number, table in enumerate(shown):
        print(("\n" if number else "") + table.title + "\n")
        rows = [[cell if isinstance(cell, str) else cell.text for cell in row] for row in table.rows]
        print_table(table.header, rows[: len(rows) - table.faint], table.left)
