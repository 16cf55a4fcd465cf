"""One episode."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from html import escape
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex

from vpf_sim import drivers
from vpf_sim.api import views
from vpf_sim.api.arguments import StrPath, output_file, text
from vpf_sim.api.views import Page, Picture, Video
from vpf_sim.drivers import DriverLike
from vpf_sim.errors import InputError, option, shown
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.system import one_thread
from vpf_sim.window import require_display

if TYPE_CHECKING:
    import pandas as pd

    from vpf_sim.drivers.keyboard import KeyboardDriver
    from vpf_sim.evaluation.sweeps.manifest import Manifest
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Episode:
    """A driven episode: its record and its steps.

    >>> episode = vpf_sim.drive("town04", weather="rain")
    >>> episode.status, episode.record["path_mse_m2"]
    >>> episode.picture(time_s=3.0), episode.plot(), episode.video()

    A notebook shows the plot of an episode, and what these three return.
    """

    result: episode.EpisodeResult
    path: Path | None = None  #: the run folder, if it is stored
    inputs: RunInputs = field(default_factory=RunInputs)  #: the scenario and weather that it was driven with

    def __repr__(self) -> str:
        last = f", {self.error.strip().splitlines()[-1]}" if self.error else ""
        return f"<Episode {self.result.record.id}: {self.status}{last}>"

    @property
    def record(self) -> dict[str, Any]:
        """Scores, as in episodes.jsonl of a run folder."""
        return self.result.record.as_json()

    @property
    def timing(self) -> dict[str, Any]:
        """`wall_s`, `steps_per_s`, `stages_ms`."""
        return self.result.timing.as_json()

    @property
    def status(self) -> str:
        """How it ended, such as "success", "collision" or "error"."""
        return self.result.record.status

    @property
    def error(self) -> str:
        """The traceback of an exception, of the driver's for example; empty without one."""
        return self.result.traceback or ""

    @property
    def steps(self) -> "pd.DataFrame":
        """A row a frame: state, commands, clearance, perception; NaN where there is no value."""
        return self.result.steps.data_frame()

    def picture(self, time_s: float | None = None) -> Picture:
        """The camera's frame at a time, by default the last, with what the driver perceives and plans.

        The drive is computed again up to this time.
        """
        return views.picture(self.result, self.inputs, time_s)

    def plot(self) -> Page:
        """The path over the road, throttle, steering and speed, and the main scores."""
        return views.plot(self.result, self.inputs)

    def video(self, file: StrPath | None = None) -> Video:
        """The drive as an .mp4: camera with the driver's view, the road from above, and signals.

        By default it is written into the folder `videos` of the run, or without one into the working folder. It needs
        the extra `video`.
        """
        name = f"{self.result.record.id}.mp4"
        default = Path(name) if self.path is None else self.path / "videos" / name
        return views.video(self.result, self.inputs, output_file("file", file, ".mp4") or default)

    def _repr_html_(self) -> str:
        return self.plot()._repr_html_() if len(self.result.steps) else f"<pre>{escape(repr(self))}</pre>"


def drive(
    scenario: StrPath,
    *,
    driver: DriverLike = "vpf",
    weather: StrPath = "clear",
    seed: int = 0,
    video: StrPath | None = None,
    out: StrPath | bool = False,
) -> Episode:
    """Drive one episode and score it.

    >>> vpf_sim.drive("town04", driver=MyDriver(), weather="rain", seed=3).status
    'success'

    Scenario and weather are names or TOML files. A driver is a name, as on the command line, a class or an instance;
    an exception that it raises ends the episode with the status "error". `video` is an .mp4 to write, with the
    driver's view. The episode is stored in a run folder if `out` names one; True stands for a new one under runs/.
    Raises InputError for an unknown name, an unusable file or a class that is no driver.
    """
    with driven(scenario, driver=driver, weather=weather, seed=seed, video=video, out=out) as done:
        return done


@contextmanager
def driven(
    scenario: StrPath,
    *,
    driver: DriverLike,
    weather: StrPath,
    seed: int,
    video: StrPath | None = None,
    watch: bool = False,
    rerun: StrPath | None = None,
    out: StrPath | bool = False,
    hands: "KeyboardDriver | None" = None,
) -> Iterator[Episode]:
    """The driven and stored episode; video and recording are completed when the context ends.

    Where they do not fit on the disk, all else is stored and can be shown. `hands` is the driver "keyboard" with more
    in its window.
    """
    from vpf_sim.reporting import viewers

    film, log = output_file("video", video), output_file("rerun", rerun)
    names = text("scenario", scenario), text("weather", weather)
    name, seed = _checked_name(driver), _checked_seed(seed)
    with ExitStack() as stack:
        stack.enter_context(one_thread())
        requested = _manifest(*names, name, seed) if out is not False else None
        attached = stack.enter_context(viewers.attached(film, watch, log))
        if requested is None:
            result, path = episode.run(*names, hands or driver, seed, attached.show, name), None
        else:
            with _stored(requested, out) as folder:
                result, path = episode.run(*names, hands or driver, seed, attached.show, name), folder.path
                _store(folder, result)
        yield Episode(result, path)
        attached.finish(result.steps)


def _checked_seed(seed: int) -> int:
    """The seed as Python's own number, also of numpy's."""
    from vpf_sim.evaluation.sweeps.plan import MOST_DIGITS

    if isinstance(seed, bool) or not isinstance(seed, SupportsIndex) or not 0 <= index(seed) < 10**MOST_DIGITS:
        raise InputError(f"{option('seed')}: expected a whole number of 1 to {MOST_DIGITS} digits, got {shown(seed)}")
    return index(seed)


def _checked_name(driver: DriverLike) -> str:
    """The driver's name, by which it is found in this process."""
    name = drivers.name_of(driver)
    drivers.admit(name, driver)
    if name == drivers.KEYBOARD:
        require_display()
    return name


def _manifest(scenario: str, weather: str, driver: str, seed: int) -> "Manifest":
    from vpf_sim.evaluation.sweeps.manifest import Manifest
    from vpf_sim.evaluation.sweeps.plan import Plan

    return Manifest.of("drive", Plan((scenario,), (weather,), (driver,), f"{seed}:{seed + 1}"))


@contextmanager
def _stored(requested: "Manifest", out: StrPath | bool) -> "Iterator[RunFolder]":
    """The run folder; without a complete episode, as after Ctrl-C or on a full disk, nothing is left of it."""
    from vpf_sim.evaluation.sweeps import run_folder

    path = run_folder.new_path("drive") if isinstance(out, bool) else Path(text("out", out))
    is_theirs = not isinstance(out, bool) and path.exists()
    folder = run_folder.RunFolder(path, requested)
    try:
        yield folder
    except BaseException:
        folder.discard(keep_folder=is_theirs)
        raise
    folder.close()


def _store(folder: "RunFolder", result: episode.EpisodeResult) -> None:
    from vpf_sim.evaluation import steps

    steps.write(result.steps, folder.path / "steps" / f"{result.record.id}.parquet")
    folder.add(result.record, result.timing, result.traceback)
