"""`vpf-sim report`: a run as one HTML page."""

from pathlib import Path
from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, RunArgument, print_json, prints_on_stderr

FileOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="The .html to write; by default report.html in the run folder."),
]
ClipsOption = Annotated[
    int, typer.Option("--clips", min=0, max=20, metavar="N", help="Number of failures with a video.")
]


def report(run: RunArgument, out: FileOption = None, clips: ClipsOption = 4, json: JsonOption = False) -> None:
    """Write a run as one offline HTML page.

    It has tables, charts and videos of failures.
    """
    from vpf_sim.api.report import report as write

    with prints_on_stderr():
        written = write(run, out=out, clips=clips)
    if json:
        print_json({"out": str(written.path), "report": str(written.page), **written.summary()})
    else:
        print(written.page)
