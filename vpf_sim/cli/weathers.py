"""`vpf-sim weathers`: list, show and check weathers."""

from typing import Annotated, Any

import typer

from vpf_sim.cli.options import JsonOption, print_json
from vpf_sim.cli.tables import print_table

app = typer.Typer(help="List and show weathers; check your own.", no_args_is_help=True, rich_markup_mode=None)
SameJsonOption = Annotated[bool, typer.Option("--json", help="No effect: the output is always JSON.")]


@app.command("list")
def list_weathers(json: JsonOption = False) -> None:
    """List the presets with their aliases and meaning."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.evaluation.weather.weather_meaning import aliases, in_words

    loaded = list(weather.PRESETS.values())
    if json:
        print_json({"weathers": [_row(name) for name in weather.names()]})
        return
    print_table(("weather", "alias", ""), [(w.name, ", ".join(aliases(w)), in_words(w)) for w in loaded], words=3)


@app.command()
def show(name: str, json: SameJsonOption = False) -> None:  # noqa: ARG001
    """Show the factors of a weather or weather file and their physical meaning as JSON."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.evaluation.weather.weather_meaning import aliases, in_words, physical

    loaded = weather.load(name)
    meaning = {"aliases": aliases(loaded), "meaning": in_words(loaded), "physical": physical(loaded)}
    print_json({**loaded.model_dump(mode="json"), **meaning})


@app.command()
def validate(file: Annotated[str, typer.Argument(metavar="FILE")]) -> None:
    """Check a weather file; exit code 2 with one line per fault."""
    from vpf_sim.envs.camera import weather

    weather.load(file)
    print(f"{file}: valid")


def _row(name: str) -> dict[str, Any]:
    """A name or alias with its preset and meaning."""
    from vpf_sim.envs.camera import weather
    from vpf_sim.evaluation.weather.weather_meaning import in_words

    loaded = weather.load(name)
    return {"name": name, "preset": loaded.name, "meaning": in_words(loaded)}
