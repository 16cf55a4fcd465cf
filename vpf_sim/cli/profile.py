"""`vpf-sim profile`: where the time of a step goes."""

from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, WeatherOption, print_json
from vpf_sim.cli.tables import number, print_table

ScenarioArgument = Annotated[str, typer.Argument(metavar="SCENARIO", help="Name or file of a scenario.")]
StepsOption = Annotated[int, typer.Option("--steps", min=2, help="Steps to time.")]


def profile(
    scenario: ScenarioArgument = "town04",
    weather: WeatherOption = "clear",
    steps: StepsOption = 300,
    json: JsonOption = False,
) -> None:
    """Time the step of the driver `vpf`, its stages and the yardstick: what each takes on average."""
    from vpf_sim.evaluation.machine.profile import profile as measure

    measured = measure(scenario, weather, steps)
    if json:
        print_json(measured)
        return
    yardstick_ms = measured["yardstick_ms"]
    rows = [("step", measured["step_ms"]), ("yardstick", yardstick_ms), *measured["stages_ms"].items()]
    cells = [(name, number(value_ms, 3), number(value_ms / yardstick_ms, 3)) for name, value_ms in rows]
    print_table(("stage", "ms", "x yardstick"), cells)
    print("\nThe parts of render and of bodies are inside them; hash runs on a helper thread.")
