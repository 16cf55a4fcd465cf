"""`vpf-sim weathers`: the weathers that there are, one of them, or a check of a file."""

from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, print_json

app = typer.Typer(help="The weathers that there are; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list")
def list_weathers(json: JsonOption = False) -> None:
    """The presets and their aliases."""
    from vpf_sim.envs.camera import weather

    if json:
        print_json({"weathers": [{"name": name} for name in weather.names()]})
        return
    print("\n".join(weather.names()))


@app.command()
def show(name: str) -> None:
    """The factors of a weather, as JSON."""
    from vpf_sim.envs.camera import weather

    print_json(weather.load(name).model_dump(mode="json"))


@app.command()
def validate(file: Annotated[str, typer.Argument(metavar="FILE")]) -> None:
    """Check a weather file: one line a fault, exit code 2."""
    from vpf_sim.envs.camera import weather

    weather.load(file)
    print(f"{file}: a good weather")
