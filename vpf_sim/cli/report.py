"""`vpf-sim report`: a run as one HTML page."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from vpf_sim.cli.options import check_output, prints_on_stderr
from vpf_sim.cli.video import RunArgument
from vpf_sim.files import write_text

FileOption = Annotated[
    Path | None, typer.Option("--out", help="The .html to write; by default report.html in the run folder.")
]
ClipsOption = Annotated[
    int, typer.Option("--clips", min=0, max=20, metavar="N", help="Number of failures with a video.")
]
CLIPS = 4


def report(folder: RunArgument, out: FileOption = None, clips: ClipsOption = CLIPS) -> None:
    """Write a run's report: one offline HTML file with tables, charts and videos of failures."""
    print(write(folder, out, clips))


def write(folder: Path, out: Path | None = None, clips: int = CLIPS) -> Path:
    """Write the report of a run folder; returns its path."""
    from vpf_sim.evaluation.processes.threads import limit_opencv
    from vpf_sim.reporting import page
    from vpf_sim.reporting.stored_run import open_run

    limit_opencv()
    check_output("--out", out)
    path = out or folder / "report.html"
    run = open_run(folder)
    with prints_on_stderr():
        html = page.make(run, clips, lambda line: print(line, file=sys.stderr, flush=True))
    write_text(path, html)
    return path
