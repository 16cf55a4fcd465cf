"""`vpf-sim weathers`: list, show and check weathers."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import (
    WEATHER,
    Command,
    FileArgument,
    JsonOption,
    SameJsonOption,
    WeathersOption,
    WorkersOption,
    print_json,
    print_validity,
)
from vpf_sim.cli.output import print_table

if TYPE_CHECKING:
    from vpf_sim.gallery.page import Entry


app = typer.Typer(help="List, show and draw weathers; check your own.", no_args_is_help=True, rich_markup_mode=None)
WeatherArgument = Annotated[str, typer.Argument(help="Name or file of a weather.", **WEATHER)]


@app.command("list", cls=Command)
def list_weathers(json: JsonOption = False) -> None:
    """List the presets with their aliases and meaning."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.gallery.weather_meaning import aliases, in_words

    loaded = list(weather.PRESETS.values())
    if json:
        print_json({"weathers": [_row(name) for name in weather.names()]})
        return
    print_table(("weather", "alias", ""), [(w.name, ", ".join(aliases(w)), in_words(w)) for w in loaded], words=3)


@app.command(cls=Command)
def show(name: WeatherArgument, json: SameJsonOption = False) -> None:  # noqa: ARG001
    """Show a weather's factors and their meaning as JSON."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.gallery.weather_meaning import aliases, in_words, physical

    loaded = weather.load(name)
    meaning = {"aliases": aliases(loaded), "meaning": in_words(loaded), "physical": physical(loaded)}
    print_json({**loaded.model_dump(mode="json"), **meaning})


@app.command(cls=Command)
def keys(json: JsonOption = False) -> None:
    """List every key of a weather file."""
    from vpf_sim.cli.output import print_keys
    from vpf_sim.envs.camera.weather import Weather

    print_keys(Weather, json)


@app.command(cls=Command)
def validate(file: FileArgument, json: JsonOption = False) -> None:
    """Check a weather file; exit code 2 with a line per fault."""
    from vpf_sim.envs.camera import weather

    def check() -> dict[str, str]:
        weather.load(file)
        return {}

    print_validity(file, check, json)


def _row(name: str) -> dict[str, str]:
    """A name or alias with its preset and meaning."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.gallery.weather_meaning import in_words

    loaded = weather.load(name)
    return {"name": name, "preset": loaded.name, "meaning": in_words(loaded)}


FolderOption = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder of the page; by default a new one under runs/.")
]


@app.command(cls=Command)
def gallery(
    weather: WeathersOption = None,
    workers: WorkersOption = None,
    out: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Render weathers at fixed poses, as a page.

    Each has ten places and a short drive; the folder has an index.html.
    """
    from vpf_sim.envs.camera import weather as weathers
    from vpf_sim.evaluation.sweeps import run_folder
    from vpf_sim.evaluation.sweeps.sweep import default_workers
    from vpf_sim.gallery import page as pictures

    loaded = list(dict.fromkeys(weathers.load(name) for name in weather or weathers.PRESETS))
    folder = out or run_folder.new_path("gallery")
    run_folder.check_name(folder)
    with _progress(len(loaded)) as notify:
        page = pictures.make(folder, loaded, workers or default_workers(), notify)
    if json:
        print_json({"out": str(folder), "page": str(page), "weathers": [one.name for one in loaded]})
    else:
        print(page)


@contextmanager
def _progress(total: int) -> "Iterator[Callable[[Entry], None]]":
    """A callback for each finished weather: a progress bar on a terminal, lines elsewhere."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True)) as bar:
            task = bar.add_task("weathers", total=total)
            yield lambda entry: bar.update(task, advance=1, description=entry.name)
        return
    count = 0

    def print_line(entry: "Entry") -> None:
        nonlocal count
        count += 1
        print(f"{count}/{total} {entry.name}", file=sys.stderr, flush=True)

    yield print_line
