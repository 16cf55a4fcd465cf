"""A run, or two compared, as one HTML page."""

import sys

from vpf_sim.api.paths import StrPath, output_file
from vpf_sim.api.run import Run
from vpf_sim.errors import InputError, option, shown
from vpf_sim.evaluation.processes.threads import one_thread
from vpf_sim.files import write_text

CLIPS = 4


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
