"""`vpf-sim results`: the scores of several runs on one Markdown page."""

from pathlib import Path
from typing import Annotated

import typer

from vpf_sim.api.paths import output_file
from vpf_sim.cli.options import RunsArgument
from vpf_sim.files import write_text

FileOption = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="The .md to write; by default standard output.")
]


def results(runs: RunsArgument, out: FileOption = None) -> None:
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
