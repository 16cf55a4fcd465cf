"""`vpf-sim profile`: the time of a step by stage."""

from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, ScenarioArgument, WeatherOption, print_json
from vpf_sim.cli.tables import number, print_table

StepsOption = Annotated[int, typer.Option("--steps", metavar="N", min=2, help="Steps to time.")]


def profile(
    scenario: ScenarioArgument = "town04",
    weather: WeatherOption = "clear",
    steps: StepsOption = 300,
    json: JsonOption = False,
) -> None:
    """Time a step of the driver `vpf` and its stages.

    Times are also given as multiples of a yardstick, a fixed computation on this machine.
    """
    from vpf_sim.machine.profile import profile as measure

    measured = measure(scenario, weather, steps)
    if json:
        print_json(measured)
        return
    stages, once_ms = measured["stages_ms"], measured["once_ms"]
    yardstick_ms = measured["yardstick_ms"]
    times = {"step": (measured["step_ms"], None), "yardstick": (yardstick_ms, yardstick_ms)}
    times |= {name: (ms, once_ms[name]) for name, ms in stages.items()}
    cells = [(name, *(part for ms in pair for part in _both(ms, yardstick_ms))) for name, pair in times.items()]
    print_table(("stage", "ms per step, mean", "x yardstick", "ms per run, median", "x yardstick"), cells)
    print(
        "\nOne step of three uses a frame; per run: over the steps in which a stage runs. Stages with a dot are parts"
    )
    print("of the stage before the dot; hash runs on a separate thread.")


def _both(ms: float | None, yardstick_ms: float) -> tuple[str, str]:
    """Milliseconds, and their multiple of the yardstick."""
    return ("", "") if ms is None else (number(ms, 3), number(ms / yardstick_ms, 3))
