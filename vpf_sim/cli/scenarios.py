"""`vpf-sim scenarios`: list, show and check scenarios."""

from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.help import Command
from vpf_sim.cli.options import (
    FileArgument,
    JsonOption,
    SameJsonOption,
    ScenarioArgument,
    print_json,
    print_validity,
)
from vpf_sim.cli.tables import print_table

if TYPE_CHECKING:
    from vpf_sim.scenarios import Scenario

app = typer.Typer(help="List and show scenarios; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list", cls=Command)
def list_scenarios(json: JsonOption = False) -> None:
    """List the scenarios of the catalog and what each is."""
    from vpf_sim import scenarios

    loaded = {name: scenarios.load(name) for name in scenarios.names()}
    rows = [_row(name, None if isinstance(one, scenarios.RandomScenario) else one) for name, one in loaded.items()]
    if json:
        print_json({"scenarios": rows})
        return
    keys = ("name", "road_m", "route_m", "bodies")
    cells = [(*("random" if r[key] is None else str(r[key]) for key in keys), str(r["summary"])) for r in rows]
    print_table(("scenario", "road m", "route m", "objects", ""), cells, prose=True)


def _row(name: str, one: "Scenario | None") -> dict[str, object]:
    """One row of the list; None for values that the seed determines."""
    from vpf_sim import scenarios

    sizes: dict[str, object] = {"road_m": None, "route_m": None, "bodies": None}
    if one is not None:
        route_m = round(one.goal.s_m - one.ego.s_m)
        sizes = {"road_m": round(one.road.length_m), "route_m": route_m, "bodies": len(one.bodies)}
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
def validate(file: FileArgument, json: JsonOption = False) -> None:
    """Check a scenario file; exit code 2 with a line per fault."""
    from vpf_sim import scenarios

    def check() -> dict[str, str]:
        scenarios.load(file)
        return {}

    print_validity(file, check, json)
