"""`vpf-sim export`: a run as a data set."""

import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from vpf_sim.cli.options import JsonOption, RunArgument, WorkersOption, print_json, prints_on_stderr
from vpf_sim.errors import InputError

FormatOption = Annotated[
    str, typer.Option("--format", metavar="FORMAT", help="lerobot (video and Parquet) or minari (HDF5 of arrays).")
]
FolderOption = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="A new folder; by default RUN/FORMAT.")]
SizeOption = Annotated[
    str | None, typer.Option("--size", metavar="WxH", help="Size of the pictures in pixels; by default 640x480.")
]
GreyOption = Annotated[bool, typer.Option("--grey", help="Grey pictures instead of RGB.")]
TruthOption = Annotated[
    str,
    typer.Option(
        "--truth", metavar="NAME,...", help="Ground truth: depth, flow, foe, ttc, instance, hidden; minari alone."
    ),
]
StatusOption = Annotated[
    list[str] | None,
    typer.Option("--status", metavar="STATUS", help="Only episodes that ended so, such as success; may be repeated."),
]


def export(
    run: RunArgument,
    format: FormatOption = "lerobot",  # noqa: A002
    out: FolderOption = None,
    size: SizeOption = None,
    grey: GreyOption = False,
    truth: TruthOption = "",
    status: StatusOption = None,
    workers: WorkersOption = None,
    json: JsonOption = False,
) -> None:
    """Write a run's episodes as a data set for learning.

    Frames are drawn again, actions are those recorded; README.md in the folder is its data sheet.
    """
    from vpf_sim.api.report import export as write
    from vpf_sim.datasets.export import as_json

    names = [name for name in truth.split(",") if name]
    with prints_on_stderr():
        found = write(
            run,
            format,
            out=out,
            size=_size(size),
            grey=grey,
            truth=names,
            status=status or (),
            workers=workers,
        )
    for line in [f"left out: {name}: {why}" for name, why in found.left_out.items()] + found.remarks:
        print(f"vpf-sim: {line}", file=sys.stderr)
    if json:
        print_json(as_json(found))
    else:
        print(found.path)


def _size(given: str | None) -> tuple[int, int] | None:
    if given is None:
        return None
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", given)
    if not found:
        raise InputError(f"--size: expected WIDTHxHEIGHT in pixels, such as 84x84, got '{given}'")
    return int(found[1]), int(found[2])
