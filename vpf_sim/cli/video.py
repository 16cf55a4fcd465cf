"""`vpf-sim video`: a video of a stored episode."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import check_output, prints_on_stderr

if TYPE_CHECKING:
    from vpf_sim.report.redraw import Redrawing

RunArgument = Annotated[Path, typer.Argument(metavar="DIR", help="A run folder.")]
IdOption = Annotated[str, typer.Option("--id", help="The episode, such as town04.clear.vpf.1003.")]
OverlayOption = Annotated[
    bool, typer.Option("--overlay/--no-overlay", help="Draw the driver's perception and plan, recomputed.")
]
FileOption = Annotated[
    Path | None, typer.Option("--out", help="The .mp4 to write; by default videos/ID.mp4 in the run folder.")
]


def video(folder: RunArgument, id: IdOption, overlay: OverlayOption = True, out: FileOption = None) -> None:  # noqa: A002
    """Re-render an episode from its steps and seed: camera, top view and signals."""
    from vpf_sim.evaluation.processes.threads import limit_opencv
    from vpf_sim.report.redraw import redrawing
    from vpf_sim.report.stored_run import open_run
    from vpf_sim.report.video import require

    require("video")
    check_output("--out", out)
    limit_opencv()
    run = open_run(folder)
    with prints_on_stderr():
        drawn = redrawing(run, id, overlay)
        path = out or folder / "videos" / f"{id}.mp4"
        _write(drawn, path)
    for remark in drawn.remarks:
        print(f"vpf-sim: {id}: {remark}", file=sys.stderr)
    print(path)


def _write(drawn: "Redrawing", path: Path) -> None:
    """Write all frames into a file."""
    from vpf_sim.report import episode_view
    from vpf_sim.report.video import Writer

    with Writer(path, episode_view.size_px(drawn.camera), drawn.rate_hz) as writer:
        for index, frame in episode_view.frames(drawn):
            writer.write(frame)
            _show_progress(index + 1, len(drawn.table) + 1)


def _show_progress(done: int, total: int) -> None:
    if sys.stderr.isatty():
        print(f"\r{done}/{total} frames", end="\n" if done == total else "", file=sys.stderr, flush=True)
