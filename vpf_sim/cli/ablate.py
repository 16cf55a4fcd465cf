"""`vpf-sim ablate`: from one variant to another, one change at a time."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from vpf_sim.cli.options import (
    ClusterOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    ScenariosOption,
    SeedsOption,
    TimeoutOption,
    WeathersOption,
    WorkersOption,
    print_json,
)
from vpf_sim.shell import command

Row = dict[str, Any]
NAME = "ablation.json"
COLUMNS = {  # label, digits
    "success_rate": ("success", 2),
    "path_mse_m2": ("MSE m2", 3),
    "min_clearance_m": ("clearance m", 2),
    "comfortable_rate": ("comfortable", 2),
    "steering_changes_per_s": ("turns of steering /s", 1),
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
        help="robust: from vpf@full-frame to vpf; paper: from vpf-literal to vpf-paper; "
        "without: vpf-paper without one of its repairs; mechanisms: vpf without one of its mechanisms.",
    ),
]


def ablate(
    chain: ChainOption = ChainName.robust,
    scenario: ScenariosOption = None,
    weather: WeathersOption = None,
    seeds: SeedsOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    cluster: ClusterOption = None,
    out: OutOption = None,
    resume: ResumeOption = False,
    mixed: MixedOption = False,
    json: JsonOption = False,
) -> None:
    """Drive each step from one variant to another on the same seeds, and tell what each change buys."""
    from vpf_sim.cli.results import exit_code, read_summary
    from vpf_sim.cli.running import Means, fill, plan_of
    from vpf_sim.evaluation.analysis.ablation import plan as ablation_plan
    from vpf_sim.evaluation.sweeps.plan import parse_seeds

    if seeds is not None:
        parse_seeds(seeds)
    asked = bool(seeds or scenario or weather)
    plan = plan_of(out, resume, asked, lambda: ablation_plan(seeds, scenario or [], weather or [], chain.value))
    path = fill("ablate", plan, Means(out, resume, mixed, workers, timeout, cluster))
    rows = _store(path)
    if json:
        print_json({"out": str(path), "seeds": plan.seeds, "rows": rows})
    else:
        print_steps(rows, plan.seeds)
        print(f"\nrecords and steps: {path}")
        print(f"a page of all this: {command('report', path)}")
    raise typer.Exit(exit_code(read_summary(path)))


def _store(path: Path) -> list[Row]:
    """The ablation's table of a finished run folder, stored beside its summary."""
    from vpf_sim.evaluation.analysis import ablation
    from vpf_sim.evaluation.sweeps.json_lines import read_lines
    from vpf_sim.evaluation.sweeps.run_folder import read_records, stored_plan, write_json

    timing = read_lines(path / "timing.jsonl")
    table = ablation.table(stored_plan(path).jobs(), read_records(path), timing)
    write_json(path / NAME, table)
    rows: list[Row] = table["rows"]
    return rows


def print_steps(rows: list[Row], seeds: str) -> None:
    """The steps, then what each changes against the one before."""
    from vpf_sim.cli.tables import number, print_table, within

    apart = any(row["driver"].startswith(("vpf@without-", "vpf@no-")) for row in rows)
    how = "One change is taken back at a time" if apart else "Each step keeps the changes of those before it"
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
    print(f"\nDifferences to the {'first' if apart else 'step before'} on the same seeds, with 95 % intervals:\n")
    lines = [
        (*_names(row), *(_change(row["difference"][key], digits, within) for key, (_, digits) in COLUMNS.items()))
        for row in rows
        if row["difference"]
    ]
    print_table(header, lines, words=3)
    print(
        "\nMSE and clearance over the successful episodes, their differences where both succeeded; the rest over all."
    )


def _names(row: Row) -> tuple[str, str, str]:
    return row["scenario"], row["weather"], row["driver"]


def _means() -> list[str]:
    return [key for key in COLUMNS if key != "success_rate"]


def _change(told: Row | None, digits: int, within: Any) -> str:
    return "-" if told is None else str(within(told["difference"], told["interval"], digits))
