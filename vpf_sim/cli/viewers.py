"""Those who look on while an episode is driven: a video file, a window."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

from vpf_sim.evaluation.episode import Watcher
from vpf_sim.types import Camera, Image, Plan

RATE_HZ = 60.0


@contextmanager
def attached(video: Path | None, watch: bool) -> Iterator[Watcher | None]:
    """The function to show each frame and plan to, or None where nobody looks on."""
    camera = Camera()
    with ExitStack() as stack:
        sinks: list[Callable[[Image], None]] = []
        if watch:
            from vpf_sim.envs.window import Window, require_display

            require_display()
            sinks.append(stack.enter_context(closing(Window(camera.width_px, camera.height_px, RATE_HZ))).show)
        if video is not None:
            from vpf_sim.report.video import Writer

            sinks.append(stack.enter_context(Writer(video, (camera.width_px, camera.height_px), RATE_HZ)).write)

        def show(frame: Image, plan: Plan | None) -> None:
            from vpf_sim.report import overlay

            drawn = frame if plan is None else overlay.draw(frame, plan, camera)
            for sink in sinks:
                sink(drawn)

        yield show if sinks else None
