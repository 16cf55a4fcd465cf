"""`vpf-sim replay`: a driver on recorded drives."""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vpf_sim.cli.options import DriverOption, JsonOption, OutOption, print_json, prints_on_stderr
from vpf_sim.cli.tables import number, print_table

if TYPE_CHECKING:
    from vpf_sim.replay.recording import Recording

DrivesArgument = Annotated[list[Path], typer.Argument(metavar="DRIVE", help="Folders in KITTI's odometry layout.")]


def replay(
    drive: DrivesArgument, driver: DriverOption = "vpf", out: OutOption = None, json: JsonOption = False
) -> None:
    """Run a driver over recorded drives, open loop: what it sees against the truth; exit code 1 on its error."""
    from vpf_sim import drivers
    from vpf_sim.errors import InputError
    from vpf_sim.evaluation import run_folder
    from vpf_sim.evaluation.threads import limit_opencv
    from vpf_sim.replay import open_loop, readers

    limit_opencv()
    with prints_on_stderr():
        drivers.create(driver)
    recordings = _named_apart([readers.read(folder) for folder in drive])
    folder = _new(out) if out else run_folder.new_path("replay")
    entries = []
    for recording in recordings:
        try:
            with prints_on_stderr():
                entries.append(open_loop.run(recording, driver, folder, _tell(recording.name)))
        except (InputError, OSError):
            raise
        except Exception as error:  # the driver's own; the other drives are still worth their time
            print(f"vpf-sim: {recording.name}: error: {type(error).__name__}: {error}", file=sys.stderr)
    if json:
        print_json({"drives": entries})
    else:
        _print(entries)
        print(f"\nvideos and commands: {folder}")
    raise typer.Exit(0 if len(entries) == len(recordings) else 1)


def _named_apart(recordings: "list[Recording]") -> "list[Recording]":
    """Drives of the same name get a number, so that each has files of its own."""
    names: Counter[str] = Counter()
    result = []
    for recording in recordings:
        names[recording.name] += 1
        number = names[recording.name]
        result.append(replace(recording, name=f"{recording.name}-{number}") if number > 1 else recording)
    return result


def _new(path: Path) -> Path:
    from vpf_sim.errors import InputError

    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise InputError(f"{path}: expected an empty or new folder for --out, got other files")
    path.mkdir(parents=True, exist_ok=True)
    return path


def _tell(name: str) -> Any:
    def tell(done: int, total: int) -> None:
        if sys.stderr.isatty():
            print(f"\r{name}: {done}/{total} frames", end="\n" if done == total else "", file=sys.stderr, flush=True)

    return tell


def _print(drives: list[dict[str, Any]]) -> None:
    rows = []
    for entry in drives:
        errors = [entry[key] or {} for key in ("foe_median_error_px", "foe_median_error_own_derotation_px")]
        cells = [number(error.get(axis), 1) for error in errors for axis in ("x", "y")]
        rows.append([entry["name"], str(entry["frames"]), *cells])
    print_table(("drive", "frames", "FOE x px", "FOE y px", "own x px", "own y px"), rows)
    print("\nmedian error of the focus of expansion: recorded rotation removed; own derotation, from the flow alone")
    for entry in drives:
        print(f"{entry['name']}: derived: {', '.join(entry['derived'])}; throttle and steering: no recording")
