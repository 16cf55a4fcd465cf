"""`vpf-sim drivers`: list, show and check drivers."""

from typing import Annotated

import typer

from vpf_sim.cli.options import (
    DRIVER,
    Command,
    JsonOption,
    SameJsonOption,
    print_json,
    print_validity,
    prints_on_stderr,
)
from vpf_sim.cli.output import print_table

app = typer.Typer(help="List and show drivers; check your own.", no_args_is_help=True, rich_markup_mode=None)
DriverArgument = Annotated[
    str, typer.Argument(help='Name of a driver, "onnx:FILE", or "package.module:Class".', **DRIVER)
]
GETS = {
    "none": "its camera's frames, its own pose, speed and yaw rate, and the goal",
    "route": "the route as waypoints, its own pose, speed and yaw rate, and the goal; no obstacles",
    "world": "all that is on the road, the route, its own pose, speed and yaw rate, and the goal",
}


@app.command("list", cls=Command)
def list_drivers(json: JsonOption = False) -> None:
    """List the drivers and what each gets beyond its camera."""
    from vpf_sim import drivers

    described = drivers.describe()
    if json:
        keys = ("name", "privileged", "summary")
        print_json({"drivers": [{key: getattr(one, key) for key in keys} for one in described]})
        return
    print_table(("driver", "privileged", ""), [(one.name, one.privileged, one.summary) for one in described], words=3)


@app.command(cls=Command)
def show(name: DriverArgument, json: SameJsonOption = False) -> None:  # noqa: ARG001
    """Show what a driver is and gets, as JSON."""
    from vpf_sim import drivers

    with prints_on_stderr():
        one, driver = drivers.description(name), drivers.create(name)
    print_json(
        {
            "name": one.name,
            "summary": one.summary,
            "privileged": one.privileged,
            "gets": GETS[one.privileged],
            "uses_images": drivers.uses_images(driver),
            "class": drivers.name_of(driver).removesuffix("()"),
        }
    )


@app.command(cls=Command)
def keys(json: JsonOption = False) -> None:
    """List every key of a variant file."""
    from vpf_sim.cli.output import print_keys
    from vpf_sim.planning.variant import Variant

    print_keys(Variant, json)


@app.command(cls=Command)
def validate(driver: DriverArgument, json: JsonOption = False) -> None:
    """Check your driver on a short drive; exit code 2 if it fails.

    It is loaded, and drives some frames without and with an obstacle.
    """
    from vpf_sim.evaluation.episode import driver_check
    from vpf_sim.system import limit_opencv

    def check() -> dict[str, str]:
        limit_opencv()
        with prints_on_stderr():
            return {"privileged": driver_check.check(driver).privileged}

    print_validity(driver, check, json)
