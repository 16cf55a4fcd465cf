"""Options that commands share, and how they print results."""

import json
import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer
from typer.core import TyperCommand

from vpf_sim.errors import InputError

Paths = Path | list[Path] | None


def located(given: Paths) -> Paths:
    """Run folders with `runs/latest` replaced by the run that it stands for."""
    from vpf_sim.evaluation.sweeps import run_folder

    if isinstance(given, Path):
        return run_folder.located(given)
    return given and [run_folder.located(path) for path in given]


def _scenarios(incomplete: str) -> list[str]:
    from vpf_sim import scenarios

    return [name for name in scenarios.names() if name.startswith(incomplete)]


def _weathers(incomplete: str) -> list[str]:
    from vpf_sim.envs.camera import weather

    return [name for name in weather.names() if name.startswith(incomplete)]


def _drivers(incomplete: str) -> list[str]:
    from vpf_sim import drivers

    return [name for name in drivers.names() if name.startswith(incomplete)]


TyperKeys = dict[str, Any]  # further keys of `typer.Argument` and `typer.Option`
SCENARIO: TyperKeys = {"metavar": "SCENARIO", "autocompletion": _scenarios}
WEATHER: TyperKeys = {"metavar": "WEATHER", "autocompletion": _weathers}
DRIVER: TyperKeys = {"metavar": "DRIVER", "autocompletion": _drivers}
ScenarioArgument = Annotated[str, typer.Argument(help="Name or file of a scenario.", **SCENARIO)]
ScenariosOption = Annotated[
    list[str] | None, typer.Option("--scenario", help="Name or file; may be repeated.", **SCENARIO)
]
WeathersOption = Annotated[
    list[str] | None, typer.Option("--weather", help="Name or file; may be repeated.", **WEATHER)
]
WeatherOption = Annotated[str, typer.Option("--weather", help="Name or file of a weather.", **WEATHER)]
DriverOption = Annotated[
    str, typer.Option("--driver", help='Name of a driver, "onnx:FILE", or "package.module:Class".', **DRIVER)
]
DriversOption = Annotated[
    list[str] | None,
    typer.Option("--driver", help='Name, "onnx:FILE", or "package.module:Class"; may be repeated.', **DRIVER),
]
FileArgument = Annotated[str, typer.Argument(metavar="FILE", help="A TOML file.")]
RunArgument = Annotated[
    Path, typer.Argument(metavar="RUN", help="A run folder; runs/latest is the newest.", callback=located)
]
RunsArgument = Annotated[
    list[Path], typer.Argument(metavar="RUN", help="Run folders; runs/latest is the newest.", callback=located)
]
NEW_FOLDER = "Run folder; by default a new one under runs/."
NewOutOption = Annotated[Path | None, typer.Option("--out", metavar="DIR", help=NEW_FOLDER)]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help=NEW_FOLDER, callback=located),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print only one JSON object.")]
SameJsonOption = Annotated[bool, typer.Option("--json", help="No effect: the output is always JSON.")]
ResumeOption = Annotated[bool, typer.Option("--resume", help="Continue the run in --out.")]
MixedOption = Annotated[
    bool, typer.Option("--mixed", help="Continue with another version or machine; marks the new records.")
]
SeedsOption = Annotated[
    str | None, typer.Option("--seeds", metavar="A:B", help="Seeds A to B, without B; or a list, 3,7.")
]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", metavar="N", min=1, help="Worker processes; by default one per core.")
]
ClusterOption = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Drive on the workers of a Dask scheduler.")
]
TimeoutOption = Annotated[
    float | None,
    typer.Option("--timeout", metavar="S", help="Time limit of an episode, s; by default from its scenario."),
]


def prints_on_stderr() -> redirect_stdout[TextIO]:
    """A context that redirects prints, such as a driver's, to stderr; `streams` does so for native code."""
    return redirect_stdout(sys.stderr)


def print_json(content: Mapping[str, object]) -> None:
    """Print one JSON object on stdout."""
    json.dump(content, sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")


def print_validity(name: str, check: Callable[[], dict[str, str]], as_json: bool) -> None:
    """Print that an input is valid, with what `check` found; its InputError is a fault.

    In JSON, the faults are part of the output, and the exit code is 2 as well.
    """
    try:
        found = check()
    except InputError as error:
        if not as_json:
            raise
        print_json({"ok": False, "name": name, "faults": str(error).splitlines()})
        raise typer.Exit(2) from None
    if as_json:
        print_json({"ok": True, "name": name, "faults": [], **found})
    else:
        print(", ".join([f"{name}: valid", *(f"{key}: {value}" for key, value in found.items())]))


class Command(TyperCommand):
    """A command whose help calls an argument by its metavar; typer adds the Python type, such as <str>."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        sections: dict[str, list[tuple[str, str]]] = {"argument": [], "option": []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            kind, (name, text) = parameter.param_type_name, record
            several = "..." if parameter.nargs != 1 else ""
            sections[kind].append((f"{parameter.metavar}{several}" if kind == "argument" else name, text))
        for kind, rows in sections.items():
            if rows:
                with formatter.section(f"{kind.capitalize()}s"):
                    formatter.write_dl(rows)
