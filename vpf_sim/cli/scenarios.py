"""`vpf-sim scenarios`: list, show and check scenarios."""

from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import JsonOption, print_json
from vpf_sim.cli.tables import print_table

if TYPE_CHECKING:
    from vpf_sim.scenarios import Scenario

app = typer.Typer(help="List and show scenarios; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list")
def list_scenarios(json: JsonOption = False) -> None:
    """List the catalog."""
    from vpf_sim import scenarios

    loaded = {name: scenarios.load(name) for name in scenarios.names()}
    rows = [_row(name, None if isinstance(one, scenarios.RandomScenario) else one) for name, one in loaded.items()]
    if json:
        print_json({"scenarios": rows})
        return
    keys = ("name", "road_m", "route_m", "bodies")
    cells = [tuple("random" if r[key] is None else str(r[key]) for key in keys) for r in rows]
    print_table(("scenario", "road m", "route m", "objects"), cells)


def _row(name: str, one: "Scenario | None") -> dict[str, object]:
    """One row of the list; None for values that the seed determines."""
    if one is None:
        return {"name": name, "road_m": None, "route_m": None, "bodies": None}
    route_m = round(one.goal.s_m - one.ego.s_m)
    return {"name": name, "road_m": round(one.road.length_m), "route_m": route_m, "bodies": len(one.bodies)}


@app.command()
def show(
    name: str, seed: Annotated[int | None, typer.Option(min=0, help="Show the scenario as this seed draws it.")] = None
) -> None:
    """Show a scenario with its defaults as JSON."""
    from vpf_sim import scenarios

    scenario = scenarios.load(name)
    shown = scenario if seed is None else scenario.draw(seed)
    print_json(shown.model_dump(mode="json", by_alias=True))


@app.command()
def validate(file: Annotated[str, typer.Argument(metavar="FILE")]) -> None:
    """Check a scenario file; exit code 2 with one line per fault."""
    from vpf_sim import scenarios

    scenarios.load(file)
    print(f"{file}: valid")
