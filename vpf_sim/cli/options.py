"""What the commands share: their options, the parsing of seeds, and how answers are printed."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

WeatherOption = Annotated[str, typer.Option("--weather", help="Name or file of a weather.")]
DriverOption = Annotated[str, typer.Option("--driver", help='Name of a driver, or "package.module:Class".')]
OutOption = Annotated[Path | None, typer.Option("--out", help="Run folder; a new one under runs/ by default.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
ResumeOption = Annotated[bool, typer.Option("--resume", help="Continue the run in --out.")]
MixedOption = Annotated[bool, typer.Option("--mixed", help="Resume on another fingerprint, and mark the records.")]
SeedsOption = Annotated[str | None, typer.Option("--seeds", help="A:B, half open.")]
WorkersOption = Annotated[int, typer.Option("--workers", min=0, help="Worker processes; 0: one a core.")]


def print_json(answer: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    json.dump(answer, sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")
