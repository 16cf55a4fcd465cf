"""`vpf-sim weathers`: list, show and check weathers."""

from typing import Annotated, Any

import typer

from vpf_sim.cli.gallery import gallery
from vpf_sim.cli.help import Command
from vpf_sim.cli.options import WEATHER, FileArgument, JsonOption, SameJsonOption, print_json, print_validity
from vpf_sim.cli.tables import print_table

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
    from vpf_sim.cli.keys import print_keys
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


app.command(cls=Command)(gallery)


def _row(name: str) -> dict[str, Any]:
    """A name or alias with its preset and meaning."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.gallery.weather_meaning import in_words

    loaded = weather.load(name)
    return {"name": name, "preset": loaded.name, "meaning": in_words(loaded)}
