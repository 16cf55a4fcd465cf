"""A run as one HTML page."""

import sys

from vpf_sim.api.paths import StrPath, output_file
from vpf_sim.api.run import Run
from vpf_sim.errors import InputError, option, shown
from vpf_sim.evaluation.processes.threads import one_thread
from vpf_sim.files import write_text

CLIPS = 4


def report(run: Run | StrPath, *, out: StrPath | None = None, clips: int = CLIPS) -> Run:
    """Write a run's report: one offline HTML file with tables, charts and videos of failures.

    >>> vpf_sim.report("runs/latest").page
    PosixPath('runs/20260301-101500-sweep/report.html')

    `out` is the file, by default report.html in the run folder; `clips` is the number of videos. Returns the run, whose
    `page` is the file. Raises InputError where the folder holds no run.
    """
    from vpf_sim.reporting import page
    from vpf_sim.reporting.stored_run import open_run

    if type(clips) is not int or clips < 0:
        raise InputError(f"{option('clips')}: expected a whole number >= 0, got {shown(clips)}")
    file = output_file("out", out)
    found = run if isinstance(run, Run) else Run(run)
    with one_thread():
        html = page.make(open_run(found.path), clips, lambda line: print(line, file=sys.stderr, flush=True))
    file = file or found.path / "report.html"
    write_text(file, html)
    return Run(found.path, file)
