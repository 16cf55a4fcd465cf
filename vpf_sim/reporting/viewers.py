"""Viewers of a running episode: a video file, a window, a recording for the Rerun viewer."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.evaluation.episode.episode import Watcher
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.files import Draft
from vpf_sim.geometry import distort
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.reporting.overlay import EDGE, OBSTACLE_LENGTH_M, ROAD_AHEAD_M, road_line, ttc_colour
from vpf_sim.reporting.plan_view import PATH
from vpf_sim.reporting.top_view import OBSTACLE, REFERENCE, ROAD, TARGET
from vpf_sim.types import Camera, Floats, Force, Image, Perception, Plan, VehicleModel

RATE_HZ = 60.0
SIGNALS = ("throttle", "steering", "pid_throttle", "pid_steering", "speed_mps", "lane_offset_m", "clearance_m", "ttc_s")
MISSING = "--rerun: expected the Rerun SDK, which is not installed: pip install 'vpf_sim[viewer]'"
JPEG_QUALITY = 85
TIME = "time"
FORCE_M = 5.0  # the length of a force of 1
FORCES = {"target": TARGET, "obstacle": OBSTACLE, "road": ROAD, "total": REFERENCE}


class RerunLog:
    """A context that writes the file from frames with plans (`show`) and final signals."""

    def __init__(self, path: Path, camera: Camera) -> None:
        self._rr = _rerun()
        self._camera = camera
        try:
            self._draft = Draft(path)
        except OSError as error:
            raise InputError(f"--rerun: {path}: expected a file that can be written, got: {error.strerror}") from None
        self._stream = self._rr.RecordingStream("vpf_sim")
        self._stream.save(self._draft.file)

    def __enter__(self) -> "RerunLog":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stream.flush()
        self._stream.disconnect()
        if kind is None:
            self._draft.commit()
        else:
            self._draft.discard()

    def show(self, time_s: float, frame: Image, plan: Plan | None) -> None:
        """Log one step: the frame (H, W, 3) RGB, and the driver's plan if it has one."""
        self._stream.set_time(TIME, duration=time_s)
        self._log("camera", self._picture(frame))
        if plan is not None and plan.perception is not None:
            self._perceived(plan.perception)
            self._scene(plan.perception, plan.force)
            if isinstance(plan.extra, MotionPlan):
                self._log("scene/motion", self._rr.LineStrips2D([_up(plan.extra.points_m())], colors=[PATH]))

    def signals(self, time_s: Floats, columns: dict[str, Floats]) -> None:
        """Log (N,) values over time; nan and inf are left out."""
        for name, values in columns.items():
            finite = np.isfinite(values)
            times = self._rr.TimeColumn(TIME, duration=time_s[finite])
            entity = f"signals/{name}"
            self._stream.send_columns(entity, [times], self._rr.Scalars.columns(scalars=values[finite]))

    def trajectory(self, positions_m: Floats) -> None:
        """Log the vehicle's trajectory, (N, 2) m in the world."""
        self._stream.log("trajectory", self._rr.LineStrips2D([positions_m]), static=True)

    def _log(self, entity: str, what: Any) -> None:
        self._stream.log(entity, what)

    def _picture(self, frame: Image) -> Any:
        return self._rr.Image(frame).compress(jpeg_quality=JPEG_QUALITY)

    def _perceived(self, perception: Perception) -> None:
        """Log flow coloured by time to contact, focus of expansion, and obstacle points."""
        rr = self._rr
        now = distort(self._camera, perception.flow.points_px)
        past = distort(self._camera, perception.flow.points_px - perception.flow.displacement_px)
        colours = [ttc_colour(float(ttc)) for ttc in perception.features.ttc_s]
        self._log("camera/flow", rr.Arrows2D(origins=past, vectors=now - past, colors=colours))
        self._log(
            "camera/obstacle_map",
            rr.Points2D(now[perception.features.obstacle_map.on_obstacle], colors=[OBSTACLE], radii=3.0),
        )
        foe = np.array([[perception.expansion.x_px, perception.expansion.y_px]])
        self._log("camera/foe", rr.Points2D(foe[np.isfinite(foe).all(axis=1)], radii=6.0))

    def _scene(self, perception: Perception, force: Force) -> None:
        """Log road edges, obstacles and forces in the top view."""
        rr, road, obstacles = self._rr, perception.road, perception.obstacles
        edges = [_up(road_line(road, side, ROAD_AHEAD_M)) for side in (road.left_m, road.right_m)]
        self._log("scene/edges", rr.LineStrips2D(edges, colors=[EDGE]))
        corners = np.stack([obstacles.left_m, -obstacles.forward_m - OBSTACLE_LENGTH_M], axis=1)
        sizes = np.stack([obstacles.right_m - obstacles.left_m, np.full(len(obstacles), OBSTACLE_LENGTH_M)], axis=1)
        self._log("scene/obstacles", rr.Boxes2D(mins=corners, sizes=sizes, colors=[OBSTACLE]))
        ego = VehicleModel()
        self._log("scene/ego", rr.Boxes2D(centers=[[0.0, 0.0]], sizes=[[ego.width_m, ego.length_m]]))
        for name, colour in FORCES.items():
            arrow = FORCE_M * _up(getattr(force, name)[None])
            self._log(f"scene/force/{name}", rr.Arrows2D(origins=[[0.0, 0.0]], vectors=arrow, colors=[colour]))


def _up(places_m: Floats) -> Floats:
    """(..., 2) viewer coordinates (x to the right, y down) of points in vehicle axes."""
    return np.stack([places_m[..., 1], -places_m[..., 0]], axis=-1)


def _rerun() -> Any:
    try:
        import rerun
    except ImportError:
        raise InputError(MISSING) from None
    return rerun


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
            from vpf_sim.window import Window, require_display

            require_display()
            window = stack.enter_context(closing(Window(camera.width_px, camera.height_px, RATE_HZ)))
            watchers.append(_drawn(window.show, camera))
        if video is not None:
            from vpf_sim.reporting.video import Writer

            writer = stack.enter_context(Writer(video, (camera.width_px, camera.height_px), RATE_HZ))
            watchers.append(_drawn(writer.write, camera))
        log = None
        if rerun is not None:
            log = stack.enter_context(RerunLog(rerun, camera))
            watchers.append(_timed(log))
        yield Viewers(_all(watchers) if watchers else None, log)


def _drawn(sink: Callable[[Image], None], camera: Camera) -> Watcher:
    """A watcher that passes on frames with the driver's perception and plan drawn in."""

    def show(frame: Image, plan: Plan | None) -> None:
        from vpf_sim.reporting import overlay

        sink(overlay.draw(frame, plan, camera))

    return show


def _timed(log: "RerunLog") -> Watcher:
    steps = count()
    return lambda frame, plan: log.show(next(steps) / RATE_HZ, frame, plan)


def _all(watchers: list[Watcher]) -> Watcher:
    def show(frame: Image, plan: Plan | None) -> None:
        for watcher in watchers:
            watcher(frame, plan)

    return show
