"""Pictures, pages and videos of an episode, which a notebook shows."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from vpf_sim.api.arguments import StrPath, output_file
from vpf_sim.api.progress import say
from vpf_sim.errors import InputError
from vpf_sim.evaluation.episode.episode import EpisodeResult
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.files import write_bytes, write_text
from vpf_sim.types import Image

if TYPE_CHECKING:
    from vpf_sim.reporting.redraw import Redrawing

PAGE_PX = 620  # height of a page in a notebook


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Picture:
    """An (H, W, 3) RGB picture; `numpy.asarray(picture)` gives the pixels."""

    pixels: Image

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"<Picture {width} x {height}>"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return np.array(self.pixels, dtype=dtype, copy=copy)

    def _repr_png_(self) -> bytes:
        encoded: bytes = cv2.imencode(".png", self.pixels[:, :, ::-1])[1].tobytes()
        return encoded

    def save(self, file: StrPath) -> Path:
        """Write a .png, and return its path."""
        path = output_file("file", file, ".png")
        assert path is not None
        write_bytes(path, self._repr_png_())
        return path


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Page:
    """A page in HTML that loads nothing."""

    html: str

    def __repr__(self) -> str:
        return f"<Page of {len(self.html)} characters>"

    def _repr_html_(self) -> str:
        frame = f'style="width: 100%; height: {PAGE_PX}px; border: 0"'
        return f'<iframe {frame} srcdoc="{escape(self.html)}"></iframe>'

    def save(self, file: StrPath) -> Path:
        """Write an .html, and return its path."""
        path = output_file("file", file, ".html")
        assert path is not None
        write_text(path, self.html)
        return path


@dataclass(frozen=True, slots=True, eq=False)
class Video:
    """A video file."""

    path: Path

    def _repr_html_(self) -> str:
        from vpf_sim.reporting.kit.clip import data_uri

        source = data_uri("video/mp4", self.path.read_bytes())
        return f'<video controls muted loop style="max-width: 100%" src="{source}"></video>'


def picture(result: EpisodeResult, inputs: RunInputs, time_s: float | None) -> Picture:
    """The camera's frame at a time, with the driver's perception and plan, which are computed again."""
    from vpf_sim.reporting import overlay
    from vpf_sim.reporting.redraw import Redrawing
    from vpf_sim.system import one_thread

    row = _row(result, time_s)
    with one_thread():
        drawn = Redrawing(result.record, result.steps, replan=True, inputs=inputs)
        for moment in drawn.moments():
            if moment.index == row:
                _say(drawn)
                return Picture(overlay.draw(moment.image, moment.plan, drawn.camera))
    raise AssertionError("every row of the steps has a frame")


def plot(result: EpisodeResult, inputs: RunInputs) -> Page:
    """The path over the road, the commands, and the scores."""
    from vpf_sim.reporting.episode_page import page

    _check_steps(result)
    return Page(page(result.record, result.steps, inputs))


def video(result: EpisodeResult, inputs: RunInputs, file: Path) -> Video:
    """The drive as an .mp4: camera with the driver's view, the road from above, and signals."""
    from vpf_sim.reporting import episode_view
    from vpf_sim.reporting.redraw import Redrawing
    from vpf_sim.reporting.video import Writer
    from vpf_sim.system import one_thread

    _check_steps(result)
    with one_thread():
        drawn = Redrawing(result.record, result.steps, replan=True, inputs=inputs)
        with Writer(file, episode_view.size_px(drawn.camera), drawn.rate_hz) as writer:
            for _, frame in episode_view.frames(drawn):
                writer.write(frame)
    _say(drawn)
    return Video(file)


def _say(drawn: "Redrawing") -> None:
    """Print what differs from the drive on stderr."""
    for remark in drawn.remarks:
        say(f"{drawn.record.id}: {remark}")


def _check_steps(result: EpisodeResult) -> None:
    if not len(result.steps):
        raise InputError(f"{result.record.id}: expected an episode with steps, got one that never began")


def _row(result: EpisodeResult, time_s: float | None) -> int:
    """The step at a time, or the last one."""
    _check_steps(result)
    times = result.steps.time_s
    if time_s is None:
        return len(times) - 1
    if not isinstance(time_s, int | float) or not 0.0 <= time_s <= times[-1] + 1e-6:
        raise InputError(f"time_s: expected 0 to {times[-1]:.2f}, got {time_s!r}")
    return int(np.argmin(np.abs(times - time_s)))
