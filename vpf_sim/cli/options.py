"""What the commands share: their options, and how answers are printed."""

import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from vpf_sim.errors import InputError

ScenariosOption = Annotated[
    list[str] | None, typer.Option("--scenario", metavar="SCENARIO", help="Name or file; may be repeated.")
]
WeathersOption = Annotated[
    list[str] | None, typer.Option("--weather", metavar="WEATHER", help="Name or file; may be repeated.")
]
WeatherOption = Annotated[str, typer.Option("--weather", help="Name or file of a weather.")]
DriverOption = Annotated[str, typer.Option("--driver", help='Name of a driver, or "package.module:Class".')]
DriversOption = Annotated[
    list[str] | None, typer.Option("--driver", metavar="DRIVER", help="Name of a driver; may be repeated.")
]
OutOption = Annotated[Path | None, typer.Option("--out", help="Run folder; a new one under runs/ by default.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
ResumeOption = Annotated[bool, typer.Option("--resume", help="Go on with the run in --out.")]
MixedOption = Annotated[bool, typer.Option("--mixed", help="Go on under another fingerprint; marks the records.")]
SeedsOption = Annotated[str | None, typer.Option("--seeds", help="A:B, half open.", metavar="A:B")]
WorkersOption = Annotated[int | None, typer.Option("--workers", min=1, help="Worker processes; one a core by default.")]
ClusterOption = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Let the workers of this Dask scheduler drive.")
]
TimeoutOption = Annotated[
    float | None,
    typer.Option(
        "--timeout", metavar="S", help="Seconds that an episode may take; by its scenario's limit by default."
    ),
]


def prints_on_stderr() -> redirect_stdout[TextIO]:
    """A context in which a driver may print: stdout is for the command's answer. See `streams` for native code."""
    return redirect_stdout(sys.stderr)


def check_place(option: str, path: Path | None) -> None:
    """InputError for a file that could not be written where it is asked for, before hours are spent on what goes into
    it: its folder must be there, since one that is made for a slip of the pen is found by nobody."""
    if path is None:
        return
    if path.is_dir():
        raise InputError(f"{option}: {path}: expected the name of a file, got a folder")
    if not path.parent.is_dir():
        raise InputError(f"{option}: {path}: expected a folder that exists, found no {path.parent}")


def print_json(answer: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    json.dump(answer, sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")
