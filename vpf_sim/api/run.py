"""A stored run as pandas data frames."""

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vpf_sim.api.arguments import StrPath, text
from vpf_sim.api.drive import Episode
from vpf_sim.errors import InputError
from vpf_sim.evaluation.episode.episode import EpisodeResult
from vpf_sim.evaluation.metrics.records import Timing
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.run_folder import located
from vpf_sim.reporting.run_data import open_run

if TYPE_CHECKING:
    import pandas as pd

NAMES = ("id", "scenario", "weather", "driver", "seed", "status", "of", "minus", "episodes", "success_rate")
SHOWN = (*NAMES[1:4], "episodes", "success_rate", "collisions", "min_clearance_m", "path_mse_m2")


class Run:
    """The run in a folder, such as "runs/latest".

    >>> run = vpf_sim.Run("runs/latest")
    >>> run.records.query("status == 'success'").groupby("driver")["path_mse_m2"].mean()
    >>> run.steps(run.records["id"][0]).plot(x="x_m", y="y_m")

    Keys of a table within a record are joined by dots: "comfort.comfortable". Raises InputError where the folder holds
    no run.
    """

    def __init__(self, path: StrPath, page: Path | None = None) -> None:
        self.path = located(Path(text("run", path)))
        self.page = page  # the report, if `vpf_sim.report` wrote it
        self._stored = open_run(self.path)

    def __repr__(self) -> str:
        return f"<Run {self.path}: {len(self._stored.records)} episodes>"

    def _repr_html_(self) -> str:
        table = self.table
        shown = table[[name for name in SHOWN if name in table]]
        return f"<p>{escape(repr(self))}</p>{shown.to_html(index=False, na_rep='-', float_format='{:.3g}'.format)}"

    @property
    def records(self) -> "pd.DataFrame":
        """A row an episode, sorted by id: names, seed, status and scores."""
        return _frame(record.as_json() for record in self._stored.records.values())

    @property
    def timing(self) -> "pd.DataFrame":
        """A row an episode: measured times."""
        return _frame(timing.as_json() for timing in self._stored.timing.values())

    @property
    def table(self) -> "pd.DataFrame":
        """A row for each scenario, weather and driver: shares, means and 95 % intervals."""
        return _frame(row.as_json() for row in self._stored.summary().rows)

    @property
    def comparisons(self) -> "pd.DataFrame":
        """A row for each difference between two drivers or weathers on the same seeds."""
        return _frame(one.as_json() for one in self._stored.summary().comparisons)

    def steps(self, episode: str) -> "pd.DataFrame":
        """A row a frame of the episode with this id; InputError where it has no steps."""
        self._stored.record(episode)
        table = self._stored.steps(episode)
        if table is None:
            raise InputError(
                f"{episode}: expected an episode with steps, got one that {self._stored.why_no_steps(episode)}"
            )
        return table.data_frame()

    def episode(self, episode: str) -> Episode:
        """The episode with this id, as `vpf_sim.drive` returns it; InputError where it is unknown."""
        record, folder = self._stored.record(episode), self.path
        table, timing = self._stored.steps(episode), self._stored.timing.get(episode, Timing(id=episode))
        traceback = folder / "errors" / f"{episode}.txt"
        error = traceback.read_text("utf-8", errors="replace") if traceback.exists() else None
        result = EpisodeResult(record, StepTable.of([]) if table is None else table, timing, error)
        return Episode(result, folder, self._stored.inputs)

    def summary(self) -> dict[str, Any]:
        """The rows and comparisons, as in summary.json of the folder."""
        return self._stored.summary().as_json()


def _frame(rows: Iterable[Json]) -> "pd.DataFrame":
    """A data frame with the names first."""
    import pandas as pd

    frame = pd.json_normalize(list(rows))
    return frame[[*(name for name in NAMES if name in frame), *(name for name in frame if name not in NAMES)]]
