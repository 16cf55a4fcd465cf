"""A driver on a recorded drive: it sees the frames and says what it would do, and nobody does it."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from math import nan
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numpy as np

from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.files import file_name
from vpf_sim.geometry import distance_m
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.egomotion.focus_of_expansion import LEAST_CONFIDENCE
from vpf_sim.planning import variant
from vpf_sim.replay import doubts, driver_error, frame_table, glass_points, road_speed, scores
from vpf_sim.replay.driver_error import DriverError
from vpf_sim.replay.film import Film
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.model_vehicle import Interval
from vpf_sim.replay.obstacles_ahead import LeadBody, is_in_the_way
from vpf_sim.replay.own_derotation import OwnDerotation, OwnMotion
from vpf_sim.replay.pilot import Decision, Pilot, pilot
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.run_files import film_file, table_file
from vpf_sim.replay.segments import Segment, goal_words, route, segments
from vpf_sim.types import Command, Driver, DriverSetup, Floats, Image, Observation, VehicleModel

OWN_VARIANT = "robust"  # whose flow serves for what is told of no rotation
LEAST_SPEED_MPS = 2.0  # of a car whose flow must show where it goes
NO_IMAGE = np.zeros((0, 0, 3), np.uint8)

Progress = Callable[[int, int], None]
Store = Callable[[dict[str, Any], dict[str, Any]], None]


@dataclass(slots=True)
class Clock:
    """What a clock measured, ms a frame: of CPU time, so that a busy machine tells the same."""

    driver_ms: list[float] = field(default_factory=list)
    reading_ms: list[float] = field(default_factory=list)
    began_s: float = field(default_factory=perf_counter)

    def entry(self, recording: Recording) -> dict[str, Any]:
        """The drive's line of timing.jsonl; real_time is how often faster than the recording the driver is."""
        period_ms = 1e3 / recording.rate_hz
        driver, reading = (float(np.mean(times)) if times else nan for times in (self.driver_ms, self.reading_ms))
        worst = float(np.percentile(self.driver_ms, 95.0)) if self.driver_ms else nan
        entry = {
            "driver_ms": driver,
            "driver_p95_ms": worst,
            "reading_ms": reading,
            "period_ms": period_ms,
            "real_time": period_ms / (driver + reading),
            "wall_s": perf_counter() - self.began_s,
        }
        return {"name": recording.name, **{key: scores.rounded(value) for key, value in entry.items()}}


@dataclass(slots=True)
class Gathered:
    """What is found frame by frame and told of the whole drive."""

    riding: glass_points.RidingPoints
    rows: list[FrameRow] = field(default_factory=list)
    error: DriverError | None = None  # that ended the drive
    speed_votes: list[tuple[float, Floats]] = field(default_factory=list)  # (time s, m/s)
    lane_widths_m: list[float] = field(default_factory=list)  # where a lane was found
    faults: list[str] = field(default_factory=list)  # why pictures are missing

    def notes(self) -> list[str]:
        """Why there are gaps, in a line."""
        if not self.faults:
            return []
        more = len(self.faults) - 1
        return [f"gaps: {self.faults[0]}" + (f", and {more} more" if more else "")]


def run(
    recording: Recording,
    driver_name: str,
    out: Path,
    progress: Progress = lambda *_: None,
    filmed: bool = True,
    store: Store = lambda *_: None,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Drive along; write frames/NAME.parquet and videos/NAME.mp4 into `out`; the drive's record and its timing.

    Both are given to `store`, too, before the film is finished: a disk without room for the film costs the film alone.
    Where pictures are missing that the driver needs, only the signals are stored and checked. Where the driver fails,
    the record is of the frames before, and says so.
    """
    driver = drivers.create(driver_name)
    asked = pilot(driver, _setup(recording, driver))
    clock = Clock()
    with ExitStack() as stack:
        film = None
        if filmed and not recording.no_images:
            film = stack.enter_context(
                Film(film_file(out, recording.name), recording.camera, recording.rate_hz, _human(recording))
            )
        can_drive = not recording.no_images or not drivers.sees(driver)
        gathered = Gathered(glass_points.RidingPoints(recording.camera))
        try:
            for row in _rows(recording, asked if can_drive else None, film, clock, gathered, progress):
                gathered.rows.append(row)
        except DriverError as error:
            gathered.error = error
        table = FrameTable.of(gathered.rows)
        table = table.replaced("flow_speed_mps", road_speed.speed(table.time_s, gathered.speed_votes))
        frame_table.write(table, table_file(out, recording.name))
        record = _record(recording, driver_name, asked, table)
        record["notes"] += gathered.notes()
        record["error"] = gathered.error.entry() if gathered.error else None
        record["doubts"] = doubts.lines(recording, record, gathered.riding, gathered.lane_widths_m)
        timing = clock.entry(recording)
        store(record, timing)
    return record, timing


def _human(recording: Recording) -> dict[str, str]:
    """How to name the commands beside the driver's: those that were not recorded are told apart."""
    kinds = {"throttle": recording.origins["throttle"].kind, "steering": recording.origins["steering_rad"].kind}
    return {name: "human" if kind == "recorded" else f"human ({kind})" for name, kind in kinds.items()}


def _rows(
    recording: Recording,
    asked: Pilot | None,
    film: Film | None,
    clock: Clock,
    gathered: Gathered,
    progress: Progress,
) -> Iterator[FrameRow]:
    """One a frame; nobody is asked where pictures are missing that the driver needs."""
    parts = iter(segments(recording))
    own = OwnDerotation(recording.camera, variant.load(OWN_VARIANT), recording.rate_hz)
    lead = LeadBody(recording.camera, recording.rate_hz)
    segment, number, moved_m = Segment(0, 0, (0.0, 0.0), 0.0), -1, 0.0
    last = Decision(Command(0.0, 0.0) if asked else Command(nan, nan))
    for k, image, taken_s in _images(recording, clock, gathered.faults):
        if k == segment.stop:
            segment, number = next(parts), number + 1
            if asked is not None:
                with driver_error.at_frame(k):
                    asked.begin(segment)
        moved_m += _step_m(recording, k)
        row = _recorded(recording, k, number)
        if image is not None and asked is not None:
            began = thread_time()
            with driver_error.at_frame(k):
                decision = asked.decide(_observation(recording, k, image, taken_s, segment), _interval(recording, k))
            clock.driver_ms.append(1e3 * (thread_time() - began))
            last = _unless_doubtful(decision, last, row.speed_mps)
            row = row._replace(image=1.0, **_seen(last))
            if decision.road_found and decision.plan is not None:
                gathered.lane_widths_m.append(decision.plan.perception.road.lane_width_m)
            if image.size:
                picture = grey(image)
                row = row._replace(ttc_s=lead.ttc_s(picture, row.lead_gap_m))
                motion = own.update(picture, moved_m)
                gathered.speed_votes.append((row.time_s, motion.speed_votes))
                if row.speed_mps > LEAST_SPEED_MPS:
                    gathered.riding.add(motion.flow)
                row, moved_m = row._replace(**_own(motion)), 0.0
        row = row._replace(throttle=last.command.throttle, steering=last.command.steering)
        if film is not None:
            film.write(image, last, row)
        progress(k + 1, len(recording))
        yield row


def _unless_doubtful(decision: Decision, last: Decision, speed_mps: float) -> Decision:
    """The decision with the last command, where the car moves and the flow is not to be trusted."""
    if decision.plan is None or last.plan is None or not speed_mps > LEAST_SPEED_MPS:
        return decision  # at the first frame nothing has moved yet
    doubtful = decision.plan.perception.expansion.confidence < LEAST_CONFIDENCE
    return replace(decision, command=last.command, is_held=True) if doubtful else decision


def _images(recording: Recording, clock: Clock, faults: list[str]) -> Iterator[tuple[int, Image | None, float]]:
    """Every frame with its number and when it was taken, s; None for a gap.

    Where the recording has no pictures at all, frames have none.
    """
    if recording.no_images:
        yield from ((k, NO_IMAGE, float(recording.times_s[k])) for k in range(len(recording)))
        return
    frames = recording.frames()
    for k in range(len(recording)):
        began = thread_time()
        frame = next(frames, None)
        clock.reading_ms.append(1e3 * (thread_time() - began))
        if frame is not None and frame.fault:
            faults.append(frame.fault)
        taken_s = float(recording.times_s[k]) if frame is None or frame.time_s is None else frame.time_s
        yield k, frame.image if frame is not None else None, taken_s


def _setup(recording: Recording, driver: Driver) -> DriverSetup:
    """The goal is that of the last segment, the speed to keep that of the start, as in the paper."""
    if driver.privileged == "world":
        raise InputError(f"{recording.name}: the driver asks for the world, a recording has none")
    parts = segments(recording)
    return DriverSetup(
        camera=recording.camera,
        vehicle=VehicleModel(),
        rate_hz=recording.rate_hz,
        speed_reference_mps=parts[0].speed_mps,
        goal_m=parts[-1].goal_m,
        seed=0,
        route=route(recording.poses) if driver.privileged == "route" else None,
    )


def _observation(recording: Recording, k: int, image: Image, taken_s: float, segment: Segment) -> Observation:
    x, y, yaw = (float(value) for value in recording.poses[k])
    return Observation(
        image=image,
        time_s=float(recording.times_s[k]),
        x_m=x,
        y_m=y,
        yaw_rad=yaw,
        speed_mps=max(float(recording.speed_mps[k]), 0.0),  # no driver here knows of reverse
        yaw_rate_radps=float(recording.yaw_rate_radps[k]),
        goal_m=segment.goal_m,
        frame_time_s=taken_s,
    )


def _interval(recording: Recording, k: int) -> Interval:
    """To the next frame; the last is taken to go on as the one before it."""
    before, after = (k, k + 1) if k + 1 < len(recording) else (k - 1, k)
    poses, times = recording.poses, recording.times_s
    return Interval(poses[before], poses[after], float(times[after] - times[before]))


def _step_m(recording: Recording, k: int) -> float:
    return 0.0 if k == 0 else distance_m(recording.poses[k], recording.poses[k - 1])


def _recorded(recording: Recording, k: int, segment: int) -> FrameRow:
    return FrameRow(
        frame=k,
        time_s=recording.times_s[k],
        segment=segment,
        image=0.0,
        speed_mps=recording.speed_mps[k],
        yaw_rate_radps=recording.yaw_rate_radps[k],
        recorded_throttle=recording.throttle[k],
        recorded_steering=np.clip(recording.steering_rad[k] / VehicleModel().steering_limit_rad, -1.0, 1.0),
        obstacle_labelled=recording.obstacle[k],
        lead_gap_m=recording.lead_gap_m[k],
        true_foe_x_px=recording.foe_px[k, 0],
        true_foe_y_px=recording.foe_px[k, 1],
    )


def _seen(decision: Decision) -> dict[str, float]:
    """The columns of what a driver shows of its perception."""
    if decision.plan is None:
        return {}
    seen = decision.plan.perception
    usable = seen.expansion.confidence > 0.0
    return {
        "road_found": nan if decision.road_found is None else float(decision.road_found),
        "road_confidence": seen.road.lane_confidence,
        "obstacle_seen": float(is_in_the_way(seen)),
        "bodies": len(seen.obstacles),
        "foe_x_px": seen.expansion.x_px if usable else nan,
        "foe_y_px": seen.expansion.y_px if usable else nan,
        "foe_confidence": seen.expansion.confidence,
        "held": float(decision.is_held),
    }


def _own(motion: OwnMotion) -> dict[str, float]:
    usable = motion.expansion.confidence > 0.0
    return {
        "own_foe_x_px": motion.expansion.x_px if usable else nan,
        "own_foe_y_px": motion.expansion.y_px if usable else nan,
        "flow_yaw_rate_radps": motion.yaw_rate_radps,
    }


def _added(recording: Recording) -> str | None:
    """What was added to what the sensors told; such a drive stands in no recorded cell."""
    origins = [recording.origins[name] for name in ("weather", "sensor_faults") if name in recording.origins]
    return "; ".join(origin.how for origin in origins if origin.kind != "recorded") or None


def _record(recording: Recording, driver_name: str, asked: Pilot, table: FrameTable) -> dict[str, Any]:
    """All that is told of a drive; a function of the recording, the driver and the code."""
    camera = recording.camera
    labelled = bool(np.isfinite(recording.obstacle).any())
    return {
        "name": recording.name,
        "file": file_name(recording.name),
        "driver": driver_name,
        "layout": recording.layout,
        "weather": recording.weather,
        "added": _added(recording),
        "frames": len(table),
        "held": int(np.count_nonzero(table.held == 1.0)),
        "gaps": int(np.count_nonzero(table.image == 0.0)),
        "rate_hz": scores.rounded(recording.rate_hz),
        "foe_median_error_px": scores.foe_error(table, "foe"),
        "foe_median_error_own_derotation_px": scores.foe_error(table, "own_foe"),
        "accuracy": scores.accuracies(table, recording),
        "perception": scores.perception(table, recording),
        "signal_checks": scores.signal_checks(recording),
        "derived": list(recording.derived),
        "origins": {name: {"kind": origin.kind, "how": origin.how} for name, origin in recording.origins.items()},
        "obstacles_by": "label" if labelled else "own detection" if np.isfinite(table.obstacle_seen).any() else None,
        "goal": goal_words(recording),
        "protocol": asked.protocol,
        "segments": int(table.segment.max(initial=-1.0)) + 1,
        "restarts": asked.restarts,
        "camera": {
            "width_px": camera.width_px,
            "height_px": camera.height_px,
            "focal_px": scores.rounded(camera.fx_px),
            "height_m": scores.rounded(camera.height_m),
        },
        "mounting": doubts.mounting(recording) or None,
        "notes": [*recording.notes, *scores.doubts(table, recording)],
        "driven": bool(np.isfinite(table.throttle).any()),
        "no_images": recording.no_images or None,
    }
