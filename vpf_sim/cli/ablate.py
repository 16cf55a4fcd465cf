"""`vpf-sim ablate`: the ablation steps from one variant to another."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from vpf_sim.cli.options import ScenariosOption, WeathersOption, print_json
from vpf_sim.cli.run_options import RunOptions, with_run_options
from vpf_sim.shell import command

Row = dict[str, Any]
NAME = "ablation.json"
COLUMNS = {  # label, digits
    "success_rate": ("success", 2),
    "path_mse_m2": ("MSE m2", 3),
    "min_clearance_m": ("clearance m", 2),
    "comfortable_rate": ("comfortable", 2),
    "steering_changes_per_s": ("steering reversals /s", 1),
    "driver_ms": ("driver ms", 2),
}


class ChainName(StrEnum):
    """Which ablation."""

    robust = "robust"
    paper = "paper"
    without = "without"
    mechanisms = "mechanisms"


ChainOption = Annotated[
    ChainName,
    typer.Option(
        "--chain",
        metavar="CHAIN",
        help="robust: from vpf@full-frame to vpf; paper: from vpf-literal to vpf-paper; "
        "without: vpf-paper without one of its repairs; mechanisms: vpf without one of its mechanisms.",
    ),
]


@with_run_options
def ablate(
    run: RunOptions,
    chain: ChainOption = ChainName.robust,
    scenario: ScenariosOption = None,
    weather: WeathersOption = None,
) -> None:
    """Drive every step between two variants, and compare them.

    All steps drive the same seeds.
    """
    from vpf_sim.cli.results import exit_code, read_summary
    from vpf_sim.cli.running import fill, plan_of
    from vpf_sim.evaluation.analysis.ablation import plan as ablation_plan

    asked = bool(run.seeds or scenario or weather)
    plan = plan_of(run, asked, lambda: ablation_plan(run.seeds, scenario or [], weather or [], chain.value))
    path = fill("ablate", plan, run)
    rows = _store(path)
    if run.json:
        print_json({"out": str(path), "seeds": plan.seeds, "rows": rows})
    else:
        print_steps(rows, plan.seeds)
        print(f"\nrecords and steps: {path}")
        print(f"as a page: {command('report', path)}")
    raise typer.Exit(exit_code(read_summary(path)))


def _store(path: Path) -> list[Row]:
    """Write the ablation table of a finished run folder beside its summary, and return its rows."""
    from vpf_sim.evaluation.analysis import ablation
    from vpf_sim.evaluation.sweeps.json_lines import read_lines
    from vpf_sim.evaluation.sweeps.run_folder import read_records, stored_plan, write_json

    timing = read_lines(path / "timing.jsonl")
    table = ablation.table(stored_plan(path).jobs(), read_records(path), timing)
    write_json(path / NAME, table)
    rows: list[Row] = table["rows"]
    return rows


def print_steps(rows: list[Row], seeds: str) -> None:
    """Print the steps, their scores, and their differences to the step before."""
    from vpf_sim.cli.tables import number, print_table, within

    apart = any(row["driver"].startswith(("vpf@without-", "vpf@no-")) for row in rows)
    how = "Each step leaves one part out" if apart else "Each step keeps the changes of the steps before it"
    print(f"Seeds {seeds}. {how}:\n")
    for step, change in {row["driver"]: row["changes"] for row in rows}.items():
        print(f"  {step}: {change}")
    header = ("scenario", "weather", "step", *(label for label, _ in COLUMNS.values()))
    print()
    lines = [
        (
            *_names(row),
            f"{row['successes']}/{row['episodes']}",
            *(number(row[key], COLUMNS[key][1]) for key in _means()),
        )
        for row in rows
    ]
    print_table(header, lines, words=3)
    print(f"\nDifferences to the {'first' if apart else 'previous step'} on the same seeds, with 95 % intervals:\n")
    lines = [
        (*_names(row), *(_change(row["difference"][key], digits, within) for key, (_, digits) in COLUMNS.items()))
        for row in rows
        if row["difference"]
    ]
    print_table(header, lines, words=3)
    print("\nMSE and clearance: successful episodes, differences where both succeeded. All else: every episode.")


def _names(row: Row) -> tuple[str, str, str]:
    return row["scenario"], row["weather"], row["driver"]


def _means() -> list[str]:
    return [key for key in COLUMNS if key != "success_rate"]


def _change(difference: Row | None, digits: int, within: Any) -> str:
    return "-" if difference is None else str(within(difference["difference"], difference["interval"], digits))
