"""Viewers of a running episode: a video file, a window, a recording for the Rerun viewer."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.evaluation.episode.episode import Watcher
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Camera, Image, Plan

if TYPE_CHECKING:
    from vpf_sim.reporting.rerun_log import RerunLog

RATE_HZ = 60.0
SIGNALS = ("throttle", "steering", "pid_throttle", "pid_steering", "speed_mps", "lane_offset_m", "clearance_m", "ttc_s")


@dataclass(frozen=True, slots=True)
class Viewers:
    """`show` receives each frame and plan, or is None without viewers; `finish` receives the steps."""

    show: Watcher | None
    log: "RerunLog | None"

    def finish(self, table: StepTable) -> None:
        if self.log is not None and len(table):
            self.log.signals(table.time_s, {name: getattr(table, name) for name in SIGNALS})
            self.log.trajectory(table.positions_m)


@contextmanager
def attached(video: Path | None, watch: bool, rerun: Path | None) -> Iterator[Viewers]:
    """The requested viewers; they close at the end of the context."""
    camera = Camera()
    with ExitStack() as stack:
        watchers: list[Watcher] = []
        if watch:
            from vpf_sim.envs.window import Window, require_display

            require_display()
            window = stack.enter_context(closing(Window(camera.width_px, camera.height_px, RATE_HZ)))
            watchers.append(_drawn(window.show, camera))
        if video is not None:
            from vpf_sim.reporting.video import Writer

            writer = stack.enter_context(Writer(video, (camera.width_px, camera.height_px), RATE_HZ))
            watchers.append(_drawn(writer.write, camera))
        log = None
        if rerun is not None:
            from vpf_sim.reporting.rerun_log import RerunLog

            log = stack.enter_context(RerunLog(rerun, camera))
            watchers.append(_timed(log))
        yield Viewers(_all(watchers) if watchers else None, log)


def _drawn(sink: Callable[[Image], None], camera: Camera) -> Watcher:
    """A watcher that passes on frames with the driver's perception and plan drawn in."""

    def show(frame: Image, plan: Plan | None) -> None:
        from vpf_sim.reporting import overlay

        sink(frame if plan is None else overlay.draw(frame, plan, camera))

    return show


def _timed(log: "RerunLog") -> Watcher:
    steps = count()
    return lambda frame, plan: log.show(next(steps) / RATE_HZ, frame, plan)


def _all(watchers: list[Watcher]) -> Watcher:
    def show(frame: Image, plan: Plan | None) -> None:
        for watcher in watchers:
            watcher(frame, plan)

    return show
