"""`vpf-sim scenarios`: the catalog, one scenario, or a check of a file."""

from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, print_json
from vpf_sim.cli.tables import print_table

app = typer.Typer(help="The scenarios that there are; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list")
def list_scenarios(json: JsonOption = False) -> None:
    """The catalog."""
    from vpf_sim import scenarios

    loaded = {name: scenarios.load(name) for name in scenarios.names()}
    rows = [
        {"name": name, "road_m": one.road.length_m, "route_m": one.goal.s_m - one.ego.s_m, "bodies": len(one.bodies)}
        for name, one in loaded.items()
    ]
    if json:
        print_json({"scenarios": rows})
        return
    cells = [(str(r["name"]), f"{r['road_m']:.0f}", f"{r['route_m']:.0f}", str(r["bodies"])) for r in rows]
    print_table(("scenario", "road m", "route m", "bodies"), cells)


@app.command()
def show(name: str) -> None:
    """What a scenario says, with its defaults, as JSON."""
    from vpf_sim import scenarios

    print_json(scenarios.load(name).model_dump(mode="json", by_alias=True))


@app.command()
def validate(file: Annotated[str, typer.Argument(metavar="FILE")]) -> None:
    """Check a scenario file: one line a fault, exit code 2."""
    from vpf_sim import scenarios

    scenarios.load(file)
    print(f"{file}: a good scenario")
