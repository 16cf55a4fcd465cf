"""`vpf-sim report`: a run, or two compared, as one HTML page."""

from pathlib import Path
from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, RunArgument, located, print_json, prints_on_stderr

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


def report(
    run: RunArgument,
    other: OtherArgument = None,
    out: FileOption = None,
    clips: ClipsOption = 4,
    json: JsonOption = False,
) -> None:
    """Write a run, or two compared, as one HTML page.

    It opens offline, and has the answer with intervals, videos of failures or changes, tables and charts.
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
