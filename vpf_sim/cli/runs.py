"""Commands that read runs: `vpf-sim report`, `results` and `score`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.api.arguments import output_file
from vpf_sim.cli.options import JsonOption, RunArgument, RunsArgument, located, print_json, prints_on_stderr
from vpf_sim.files import write_text

OtherArgument = Annotated[
    Path | None, typer.Argument(metavar="[OTHER]", help="A run folder to compare with RUN.", callback=located)
]
FileOption = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="FILE", help="The .html to write; by default RUN/report.html, of two OTHER/compare.html."
    ),
]
ClipsOption = Annotated[
    int, typer.Option("--clips", min=0, max=20, metavar="N", help="Number of failures, or of changes, with a video.")
]
PageOption = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="The .md to write; by default standard output.")
]
if TYPE_CHECKING:
    from vpf_sim.evaluation.analysis.rescore import Rescored

MOST = 20  # listed changed records


def report(
    run: RunArgument,
    other: OtherArgument = None,
    out: FileOption = None,
    clips: ClipsOption = 4,
    json: JsonOption = False,
) -> None:
    """Write a run, or two compared, as one HTML page.

    It opens offline, and has the findings with intervals, videos of failures or changes, tables and charts.
    """
    from vpf_sim.api.report import report as write
    from vpf_sim.reporting.two_runs import open_two

    with prints_on_stderr():
        written = write(run, other, out=out, clips=clips)
    if not json:
        print(written.page)
        return
    found = written.summary() if other is None else open_two(run, other).as_json()
    print_json({"out": str(written.path), "report": str(written.page), **found})


def results(runs: RunsArgument, out: PageOption = None) -> None:
    """Write the scores of runs as one Markdown page.

    It has their seeds, commands and sources.
    """
    from vpf_sim.reporting.results_page import make

    out = output_file("out", out)
    page = make(runs)
    if out is None:
        print(page, end="")
    else:
        write_text(out, page)
        print(out)


def score(run: RunArgument, json: JsonOption = False) -> None:
    """Recompute a run's scores from its stored steps.

    Nothing is driven; records whose scores changed are stored.
    """
    from vpf_sim.evaluation.analysis.rescore import rescore

    with prints_on_stderr():
        done = rescore(run)
    if json:
        changed = [{"id": name, "keys": keys} for name, keys in sorted(done.changed.items())]
        print_json({"out": str(run), "scored": len(done.records), "changed": changed, **done.summary.as_json()})
    else:
        _print_scores(done)


def _print_scores(done: "Rescored") -> None:
    from vpf_sim.cli.sweep_tables import print_benchmark, print_comparisons, print_rows

    if done.command == "benchmark":
        print_benchmark(done.summary.rows, done.seeds)
    else:
        print_rows(done.summary.rows)
        print_comparisons(done.summary.comparisons)
    print(f"\n{len(done.records)} of {done.planned} planned episodes rescored, {len(done.changed)} changed")
    for name, keys in sorted(done.changed.items())[:MOST]:
        print(f"  {name}: {', '.join(keys)}")
    if len(done.changed) > MOST:
        print(f"  and {len(done.changed) - MOST} more")
