"""A run as a data set."""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.api.paths import StrPath, text
from vpf_sim.api.run import Run
from vpf_sim.errors import InputError, option, shown, unknown_name

if TYPE_CHECKING:
    from vpf_sim.datasets.export import Exported

FORMATS = ("lerobot", "minari")


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
    from vpf_sim.datasets.contents import Contents
    from vpf_sim.datasets.lerobot import LeRobot
    from vpf_sim.datasets.minari_format import Minari
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
    return sets.export(data, format, form, folder, contents, statuses, workers or default_workers(), _notify)


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


def _notify(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
