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
    """Time the step of the driver `vpf`, its stages and the yardstick."""
    from vpf_sim.evaluation.machine.profile import profile as measure

    measured = measure(scenario, weather, steps)
    if json:
        print_json(measured)
        return
    columns = [
        {"step": times["step_ms"], "yardstick": times["yardstick_ms"], **times["stages_ms"]}
        for times in (measured, measured["mean"])
    ]
    cells = [
        (name, *(number(of, 3) for times in columns for of in (times[name], times[name] / times["yardstick"])))
        for name in columns[0]
    ]
    print_table(("stage", "ms, median", "x yardstick", "ms a step, mean", "x yardstick"), cells)
    print("\nMedians are over the steps in which a stage runs. The parts of render and of bodies are inside them; hash")
    print("runs on a helper thread.")
