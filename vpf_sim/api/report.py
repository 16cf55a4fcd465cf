"""A run, or two compared, as one HTML page."""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.api.arguments import StrPath, output_file, text
from vpf_sim.api.run import Run
from vpf_sim.errors import InputError, option, shown, unknown_name
from vpf_sim.files import write_text
from vpf_sim.system import one_thread

CLIPS = 4
if TYPE_CHECKING:
    from vpf_sim.datasets.export import Exported

FORMATS = ("lerobot", "minari")


def report(
    run: Run | StrPath, other: Run | StrPath | None = None, *, out: StrPath | None = None, clips: int = CLIPS
) -> Run:
    """Write a run's report: one offline HTML file with tables, charts and videos of failures.

    >>> vpf_sim.report("runs/latest").page
    PosixPath('runs/20260301-101500-sweep/report.html')

    With an `other` run, the page compares it with the first, episode by episode: what got better, what got worse, and
    pictures of what changed.

    `out` is the file, by default report.html in the run folder, or compare.html in that of `other`; `clips` is the
    number of videos, or of changed episodes. Returns the run, or `other`, whose `page` is the file. Raises InputError
    where a folder holds no run, and where two runs share no episode.
    """
    from vpf_sim.reporting import compare_page, page
    from vpf_sim.reporting.run_data import open_run
    from vpf_sim.reporting.two_runs import open_two

    if type(clips) is not int or clips < 0:
        raise InputError(f"{option('clips')}: expected a whole number >= 0, got {shown(clips)}")
    file = output_file("out", out, ".html")
    found = _opened(run)
    with one_thread():
        if other is None:
            html = page.make(open_run(found.path), clips, _notify)
        else:
            first, found = found.path, _opened(other)
            html = compare_page.make(open_two(first, found.path), clips, _notify)
    file = file or found.path / ("report.html" if other is None else "compare.html")
    write_text(file, html)
    return Run(found.path, file)


def _opened(run: Run | StrPath) -> Run:
    return run if isinstance(run, Run) else Run(run)


def _notify(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def export(
    run: Run | StrPath,
    format: str = "lerobot",  # noqa: A002
    *,
    out: StrPath | None = None,
    size: tuple[int, int] | None = None,
    grey: bool = False,
    truth: Iterable[str] = (),
    status: Iterable[str] = (),
    workers: int | None = None,
) -> "Exported":
    """Write a run's episodes as a data set for imitation learning or offline reinforcement learning.

    >>> vpf_sim.export("runs/latest", "minari", size=(84, 84), grey=True, truth=["depth"]).path
    PosixPath('runs/20260301-101500-sweep/minari')

    `format` is "lerobot" (LeRobot v3: video and Parquet) or "minari" (HDF5 of arrays). The frames are drawn again, of
    the camera's size or of `size` (width, height) in pixels; actions are those recorded. `truth` names ground truth of
    `FourLane`, for minari alone. `status` chooses episodes by how they ended, such as ["success"]; by default all
    driven ones are exported. `out` is a new folder, by default one of the format's name in the run folder.

    Returns the folder as `path`, the numbers of `episodes` and `frames`, which episodes are `left_out`, and `remarks`.
    An interrupted export leaves nothing. Raises InputError where the run has no driven episode, the folder exists, or
    the extra `export` is not installed.
    """
    from vpf_sim.datasets import export as sets
    from vpf_sim.datasets.lerobot import LeRobot
    from vpf_sim.datasets.minari_format import Minari
    from vpf_sim.datasets.played_episode import Contents
    from vpf_sim.evaluation.sweeps.sweep import default_workers
    from vpf_sim.reporting.run_data import RunData, open_run

    if format not in FORMATS:
        raise unknown_name("format", str(format), FORMATS)
    if workers is not None and (type(workers) is not int or workers < 1):
        raise InputError(f"{option('workers')}: expected a whole number >= 1, got {shown(workers)}")
    contents, form = Contents.of(size, grey, truth), LeRobot() if format == "lerobot" else Minari()
    found = run if isinstance(run, Run) else Run(run)
    folder = _folder(out) or found.path / format
    data = RunData.of(open_run(found.path))
    statuses = _names("status", status)
    return sets.export(data, format, form, folder, contents, statuses, workers or default_workers(), _export_notify)


def _folder(out: StrPath | None) -> Path | None:
    if out is None:
        return None
    path = Path(text("out", out))
    if not path.absolute().parent.is_dir():
        raise InputError(f"{option('out')}: {path}: expected a folder that exists, found no {path.parent}")
    return path


def _names(what: str, given: Iterable[str]) -> tuple[str, ...]:
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(f"{option(what)}: expected names, such as ('success',), got {shown(given)}")
    return tuple(map(str, given))


def _export_notify(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
