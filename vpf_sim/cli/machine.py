"""The command about this machine: `vpf-sim doctor`."""

import sys
from dataclasses import asdict
from typing import Annotated

import typer

from vpf_sim.cli.options import SCENARIO, WEATHER, JsonOption, print_json, prints_on_stderr
from vpf_sim.cli.output import number, print_table
from vpf_sim.errors import InputError

ProfileOption = Annotated[
    bool, typer.Option("--profile", help="Time a step of the driver vpf and its stages, in place of the checks.")
]
ScenarioOption = Annotated[
    str | None, typer.Option("--scenario", help="Scenario of --profile; by default town04.", **SCENARIO)
]
WeatherOption = Annotated[
    str | None, typer.Option("--weather", help="Weather of --profile; by default clear.", **WEATHER)
]
StepsOption = Annotated[
    int | None, typer.Option("--steps", metavar="N", min=2, help="Steps that --profile times; by default 300.")
]


def doctor(
    profile: ProfileOption = False,
    scenario: ScenarioOption = None,
    weather: WeatherOption = None,
    steps: StepsOption = None,
    json: JsonOption = False,
) -> None:
    """Check this machine; exit code 1 if a check fails.

    Checked are installation, frames, speed and reproducibility. With --profile, a step of the driver `vpf` is timed.
    """
    if profile:
        _profile(scenario or "town04", weather or "clear", steps or 300, json)
        return
    for name, given in {"scenario": scenario, "weather": weather, "steps": steps}.items():
        if given is not None:
            raise InputError(f"--{name}: expected together with --profile, got it alone")
    from vpf_sim.machine.doctor import examine

    output, checks = sys.stdout, []
    with prints_on_stderr():
        for check in examine():
            checks.append(check)
            if not json:
                remedy = f"; {check.remedy}" if check.remedy else ""
                line = f"{'ok' if check.ok else 'FAIL':<6}{check.name:<16}{check.found}{remedy}"
                print(line, file=output, flush=True)
    all_ok = all(check.ok for check in checks)
    if json:
        print_json({"ok": all_ok, "checks": [asdict(check) for check in checks]})
    raise typer.Exit(0 if all_ok else 1)


def _profile(scenario: str, weather: str, steps: int, json: bool) -> None:
    """Print the time of a step and its stages, and its ratio to a yardstick, a fixed computation on this machine."""
    from vpf_sim.machine.profile import profile as measure

    measured = measure(scenario, weather, steps)
    if json:
        print_json(asdict(measured))
        return
    yardstick_ms = measured.yardstick_ms
    times = {"step": (measured.step_ms, None), "yardstick": (yardstick_ms, yardstick_ms)}
    times |= {name: (ms, measured.once_ms[name]) for name, ms in measured.stages_ms.items()}
    cells = [(name, *(part for ms in pair for part in _both(ms, yardstick_ms))) for name, pair in times.items()]
    print_table(("stage", "ms per step, mean", "x yardstick", "ms per run, median", "x yardstick"), cells)
    print(
        "\nOne step of three uses a frame; per run: over the steps in which a stage runs. Stages with a dot are parts"
    )
    print("of the stage before the dot; hash runs on a separate thread.")


def _both(ms: float | None, yardstick_ms: float) -> tuple[str, str]:
    """Milliseconds, and their multiple of the yardstick."""
    return ("", "") if ms is None else (number(ms, 3), number(ms / yardstick_ms, 3))
