"""`vpf-sim check`: the gate for CI."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.api.arguments import output_file
from vpf_sim.cli.options import JsonOption, RunArgument, print_json
from vpf_sim.cli.output import print_table
from vpf_sim.errors import InputError

if TYPE_CHECKING:
    from vpf_sim.evaluation.gate.checks import Check

RulesOption = Annotated[
    Path | None,
    typer.Option("--rules", metavar="FILE", help="The rules, a TOML file; by default those of the gate's scenarios."),
]
JunitOption = Annotated[Path | None, typer.Option("--junit", metavar="FILE", help="Write the results as JUnit XML.")]
MarkdownOption = Annotated[
    Path | None, typer.Option("--markdown", metavar="FILE", help="Write the results as Markdown.")
]
GATE = ("gate-course", "gate-traffic")  # the scenarios of the default rules
WORDS = {"passed": "ok", "failed": "FAIL", "skipped": "-"}


def check(
    run: RunArgument,
    rules: RulesOption = None,
    junit: JunitOption = None,
    markdown: MarkdownOption = None,
    json: JsonOption = False,
) -> None:
    """Check a run against rules; exit code 1 if it fails any."""
    from vpf_sim.evaluation.gate import gate
    from vpf_sim.evaluation.gate.rules import DEFAULT_RULES, read_rules
    from vpf_sim.evaluation.gate.run_cells import read_run
    from vpf_sim.reporting.check_files import write_junit, write_markdown

    junit, markdown = output_file("junit", junit), output_file("markdown", markdown)
    if junit is not None and junit == markdown:
        raise InputError(f"--markdown: {markdown}: expected another file than that of --junit")
    found, file = read_run(run), rules or DEFAULT_RULES
    if rules is None:
        _check_defaults(run, {cell.scenario for cell in found.cells})
    used = read_rules(file)
    if rules is None:  # some are for a weather that the run may lack
        used = [rule for rule in used if any(map(rule.matches, found.cells))]
    checks = gate.check(found, used, file)
    if junit is not None:
        write_junit(checks, junit)
    if markdown is not None:
        write_markdown(checks, markdown)
    failed = [one for one in checks if one.outcome == "failed"]
    if json:
        print_json({"ok": not failed, "checks": [_row(one) for one in checks]})
    else:
        _print(checks, failed)
    raise typer.Exit(int(bool(failed)))


def _check_defaults(run: Path, scenarios: set[str]) -> None:
    """InputError for a run that the default rules are not made for."""
    if scenarios != set(GATE):
        raise InputError(
            f"{run}: without --rules, expected the scenarios {' and '.join(GATE)}, got {', '.join(sorted(scenarios))}; "
            "for others give --rules FILE"
        )


def _row(check: "Check") -> dict[str, object]:
    values = {key: getattr(check, key) for key in ("expected", "actual", "outcome", "rerun")}
    return {**check.cell._asdict(), **values, "seeds": list(check.seeds)}


def _print(checks: list["Check"], failed: list["Check"]) -> None:
    """Print every check, the commands that repeat failures, and the counts."""
    from vpf_sim.evaluation.gate.checks import listed, repeats, unlisted

    header = ("", "scenario", "weather", "driver", "expected", "actual")
    print_table(header, [(WORDS[one.outcome], *one.cell, one.expected, one.actual) for one in listed(checks)], words=6)
    if commands := repeats(failed):
        print("\nagain, the worst seeds first:", *commands, sep="\n  ")
    counts: Counter[str] = Counter(one.outcome for one in checks)
    if said := unlisted(checks):
        print(f"\n{said}")
    print("\n" + ", ".join(f"{counts[outcome]} {outcome}" for outcome in WORDS))
