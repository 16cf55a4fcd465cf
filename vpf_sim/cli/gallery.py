"""`vpf-sim weathers gallery`: a page with every weather at fixed poses."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import JsonOption, WeathersOption, WorkersOption, print_json

if TYPE_CHECKING:
    from vpf_sim.gallery.page import Entry

FolderOption = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder of the page; by default a new one under runs/.")
]


def gallery(
    weather: WeathersOption = None,
    workers: WorkersOption = None,
    out: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Render weathers at fixed poses, as a page.

    Each has ten places and a short drive; the folder has an index.html.
    """
    from vpf_sim.envs.camera import weather as weathers
    from vpf_sim.evaluation.sweeps import run_folder
    from vpf_sim.evaluation.sweeps.sweep import default_workers
    from vpf_sim.gallery import page as pictures

    loaded = list(dict.fromkeys(weathers.load(name) for name in weather or weathers.PRESETS))
    folder = out or run_folder.new_path("gallery")
    run_folder.check_name(folder)
    with _progress(len(loaded)) as notify:
        page = pictures.make(folder, loaded, workers or default_workers(), notify)
    if json:
        print_json({"out": str(folder), "page": str(page), "weathers": [one.name for one in loaded]})
    else:
        print(page)


@contextmanager
def _progress(total: int) -> "Iterator[Callable[[Entry], None]]":
    """A callback for each finished weather: a progress bar on a terminal, lines elsewhere."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True)) as bar:
            task = bar.add_task("weathers", total=total)
            yield lambda entry: bar.update(task, advance=1, description=entry.name)
        return
    count = 0

    def print_line(entry: "Entry") -> None:
        nonlocal count
        count += 1
        print(f"{count}/{total} {entry.name}", file=sys.stderr, flush=True)

    yield print_line
