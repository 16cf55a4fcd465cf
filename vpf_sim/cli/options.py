"""Options that commands share, and how they print answers."""

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
OutOption = Annotated[Path | None, typer.Option("--out", help="Run folder; by default a new one under runs/.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print only one JSON object.")]
ResumeOption = Annotated[bool, typer.Option("--resume", help="Continue the run in --out.")]
MixedOption = Annotated[
    bool, typer.Option("--mixed", help="Continue with another version or machine; marks the new records.")
]
SeedsOption = Annotated[str | None, typer.Option("--seeds", help="A:B, without B.", metavar="A:B")]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", min=1, help="Worker processes; by default one per core.")
]
ClusterOption = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Drive on the workers of this Dask scheduler.")
]
TimeoutOption = Annotated[
    float | None,
    typer.Option("--timeout", metavar="S", help="Time limit of an episode, s; by default from its scenario."),
]


def prints_on_stderr() -> redirect_stdout[TextIO]:
    """A context that redirects prints, such as a driver's, to stderr; `streams` does so for native code."""
    return redirect_stdout(sys.stderr)


def check_output(option: str, path: Path | None) -> None:
    """InputError for an output file that cannot be written, raised before a long computation.

    Its folder must exist, since a mistyped folder would be hard to find.
    """
    if path is None:
        return
    if path.is_dir():
        raise InputError(f"{option}: {path}: expected the name of a file, got a folder")
    if not path.parent.is_dir():
        raise InputError(f"{option}: {path}: expected a folder that exists, found no {path.parent}")


def print_json(answer: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    json.dump(answer, sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")
