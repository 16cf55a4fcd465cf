"""`vpf-sim scenarios`: list, show and check scenarios."""

from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import (
    Command,
    FileArgument,
    JsonOption,
    SameJsonOption,
    ScenarioArgument,
    print_json,
    print_validity,
)
from vpf_sim.cli.output import print_table

if TYPE_CHECKING:
    from vpf_sim.scenarios import AnyScenario

app = typer.Typer(help="List and show scenarios; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list", cls=Command)
def list_scenarios(json: JsonOption = False) -> None:
    """List the scenarios of the catalog and what each is."""
    from vpf_sim import scenarios

    loaded = {name: scenarios.load(name) for name in scenarios.names()}
    rows = [_row(name, one) for name, one in loaded.items()]
    if json:
        print_json({"scenarios": rows})
        return
    keys = ("name", "road_m", "route_m", "bodies")
    cells = [(*(_cell(row, key) for key in keys), str(row["summary"])) for row in rows]
    print_table(("scenario", "road m", "route m", "objects", ""), cells, prose=True)


def _cell(row: dict[str, object], key: str) -> str:
    """A value of a row; a lane network has no one length."""
    if row[key] is None:
        return "-" if key == "road_m" and row["route_m"] is not None else "random"
    return str(row[key])


def _row(name: str, one: "AnyScenario") -> dict[str, object]:
    """One row of the list; None for values that the seed determines."""
    from vpf_sim import scenarios

    sizes: dict[str, object] = {"road_m": None, "route_m": None, "bodies": None}
    if isinstance(one, scenarios.Scenario):
        route_m = round(one.goal.s_m - one.ego.s_m)
        sizes = {"road_m": round(one.road.length_m), "route_m": route_m, "bodies": len(one.bodies)}
    if isinstance(one, scenarios.HighwayScenario):
        sizes["route_m"] = round(one.goal.route_m)
    return {"name": name, **sizes, "summary": scenarios.summary(name)}


@app.command(cls=Command)
def show(
    name: ScenarioArgument,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", min=0, help="Show the scenario as this seed draws it.")
    ] = None,
    json: SameJsonOption = False,  # noqa: ARG001
) -> None:
    """Show a scenario with its defaults as JSON."""
    from vpf_sim import scenarios

    scenario = scenarios.load(name)
    shown = scenario if seed is None else scenario.draw(seed)
    print_json(shown.model_dump(mode="json", by_alias=True))


@app.command(cls=Command)
def keys(json: JsonOption = False) -> None:
    """List every key of a scenario file."""
    from vpf_sim.cli.output import print_keys
    from vpf_sim.scenarios import Scenario

    print_keys(Scenario, json)


@app.command(cls=Command)
def validate(file: FileArgument, json: JsonOption = False) -> None:
    """Check a scenario file; exit code 2 with a line per fault."""
    from vpf_sim import scenarios

    def check() -> dict[str, str]:
        scenarios.load(file)
        return {}

    print_validity(file, check, json)
