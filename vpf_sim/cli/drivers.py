"""`vpf-sim drivers`: list and check drivers."""

import typer

from vpf_sim.cli.options import JsonOption, print_json, prints_on_stderr
from vpf_sim.cli.tables import print_table

app = typer.Typer(help="List drivers; check your own.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list")
def list_drivers(json: JsonOption = False) -> None:
    """List the registered drivers with their privileged information."""
    from vpf_sim import drivers

    described = drivers.describe()
    if json:
        keys = ("name", "privileged", "summary")
        print_json({"drivers": [{key: getattr(one, key) for key in keys} for one in described]})
        return
    print_table(("driver", "privileged", ""), [(one.name, one.privileged, one.summary) for one in described], words=3)


@app.command()
def show(name: str) -> None:
    """Show one driver as JSON."""
    from vpf_sim import drivers

    one = drivers.description(name)
    print_json({"name": one.name, "privileged": one.privileged, "summary": one.summary})


@app.command()
def validate(driver: str) -> None:
    """Load your driver, "package.module:Class", and drive some frames without and with an obstacle; exit code 2 if
    it fails."""
    from vpf_sim.evaluation.episode import driver_check
    from vpf_sim.evaluation.processes.threads import limit_opencv

    limit_opencv()
    with prints_on_stderr():
        privileged = driver_check.check(driver).privileged
    print(f"{driver}: valid, privileged: {privileged}")
