"""`vpf-sim video`: a video of a stored episode."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.api.arguments import output_file
from vpf_sim.cli.options import JsonOption, RunArgument, print_json, prints_on_stderr

if TYPE_CHECKING:
    from vpf_sim.reporting.redraw import Redrawing

IdOption = Annotated[str, typer.Option("--id", metavar="ID", help="The episode, such as town04.clear.vpf.1003.")]
OverlayOption = Annotated[
    bool, typer.Option("--overlay/--no-overlay", help="Draw the driver's perception and plan, recomputed.")
]
FileOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="The .mp4 to write; by default videos/ID.mp4 in the run folder."),
]


def video(
    run: RunArgument,
    id: IdOption,  # noqa: A002
    overlay: OverlayOption = True,
    out: FileOption = None,
    json: JsonOption = False,
) -> None:
    """Re-render an episode: camera, top view and signals."""
    from vpf_sim.reporting.redraw import redrawing
    from vpf_sim.reporting.run_data import open_run
    from vpf_sim.reporting.video import require
    from vpf_sim.system import limit_opencv

    require("video")
    out = output_file("out", out)
    limit_opencv()
    path = out or run / "videos" / f"{id}.mp4"
    with prints_on_stderr():
        drawn = redrawing(open_run(run), id, overlay)
        _write(drawn, path)
    for remark in drawn.remarks:
        print(f"vpf-sim: {id}: {remark}", file=sys.stderr)
    if json:
        print_json({"out": str(run), "id": id, "video": str(path), "remarks": drawn.remarks})
    else:
        print(path)


def _write(drawn: "Redrawing", path: Path) -> None:
    """Write all frames into a file."""
    from vpf_sim.reporting import episode_view
    from vpf_sim.reporting.video import Writer

    with Writer(path, episode_view.size_px(drawn.camera), drawn.rate_hz) as writer:
        for index, frame in episode_view.frames(drawn):
            writer.write(frame)
            _show_progress(index + 1, len(drawn.table) + 1)


def _show_progress(done: int, total: int) -> None:
    if not sys.stderr.isatty():
        if done % max(total // 4, 1) == 0:
            print(f"{done}/{total} frames", file=sys.stderr, flush=True)
    else:
        print(f"\r{done}/{total} frames", end="\n" if done == total else "", file=sys.stderr, flush=True)
