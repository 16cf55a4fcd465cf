"""Runs a driver over a recorded drive in open loop: its commands are recorded, not carried out."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from math import nan
from pathlib import Path
from time import perf_counter, thread_time

import numpy as np

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
from vpf_sim.errors import InputError
from vpf_sim.geometry import distance_m
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.egomotion.focus_of_expansion import LEAST_CONFIDENCE
from vpf_sim.planning import variant
from vpf_sim.replay import drive_record, frame_table, road_speed, scores
from vpf_sim.replay.drive_record import Accumulated
from vpf_sim.replay.drive_video import DriveVideo
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.flow_derotation import EgoMotion, FlowDerotation
from vpf_sim.replay.frame_table import FrameRow, FrameTable, table_path, video_path
from vpf_sim.replay.model_vehicle import Interval, Segment, route, segments
from vpf_sim.replay.obstacles_ahead import LeadVehicle, has_obstacle_in_corridor
from vpf_sim.replay.open_loop_driver import Decision, DriverError, OpenLoopDriver, at_frame, open_loop_driver
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.records import DriveRecord, Timing
from vpf_sim.types import Camera, Image, VehicleModel

OWN_VARIANT = "robust"  # its flow is used without recorded rotation
LEAST_SPEED_MPS = 2.0  # above this the flow must show a direction
NO_IMAGE = np.zeros((0, 0, 3), np.uint8)

Progress = Callable[[int, int], None]
Store = Callable[[DriveRecord, Timing], None]


@dataclass(slots=True)
class Clock:
    """Measured CPU times, ms a frame, so that the load of the machine does not matter."""

    driver_ms: list[float] = field(default_factory=list)
    reading_ms: list[float] = field(default_factory=list)
    began_s: float = field(default_factory=perf_counter)

    def timing(self, recording: Recording) -> Timing:
        period_ms = 1e3 / recording.rate_hz
        driver, reading = (float(np.mean(times)) if times else nan for times in (self.driver_ms, self.reading_ms))
        worst = float(np.percentile(self.driver_ms, 95.0)) if self.driver_ms else nan
        values = {
            "driver_ms": driver,
            "driver_p95_ms": worst,
            "reading_ms": reading,
            "period_ms": period_ms,
            "real_time": period_ms / (driver + reading),
            "wall_s": perf_counter() - self.began_s,
        }
        return Timing(name=recording.name, **{key: scores.rounded(value) for key, value in values.items()})


def run(
    recording: Recording,
    driver_name: str,
    out: Path,
    progress: Progress = lambda *_: None,
    with_video: bool = True,
    store: Store = lambda *_: None,
) -> tuple[DriveRecord, Timing]:
    """Drive along a recording and return the drive's record and its timing.

    Writes frames/NAME.parquet and videos/NAME.mp4 into `out`. `store` gets record and timing before the video is
    finished, so a full disk costs only the video. If the images that a driver needs are missing, only the signals are
    stored and checked. If the driver fails, the record has the frames before and the error.
    """
    driver = drivers.create(driver_name)
    fixed = recording.fixed_to_camera()
    replayed = open_loop_driver(driver, _setup(recording, driver), fixed)
    clock = Clock()
    with ExitStack() as stack:
        video = None
        if with_video and not recording.no_images:
            video = stack.enter_context(
                DriveVideo(video_path(out, recording.name), recording.camera, recording.rate_hz, _human(recording))
            )
        can_drive = not recording.no_images or not drivers.uses_images(driver)
        accumulated = Accumulated()
        try:
            for row in _rows(recording, replayed if can_drive else None, fixed, video, clock, accumulated, progress):
                accumulated.rows.append(row)
        except DriverError as error:
            accumulated.error = error
        table = FrameTable.of(accumulated.rows)
        table = table.replaced("flow_speed_mps", road_speed.speed(table.time_s, accumulated.speed_votes))
        frame_table.write(table, table_path(out, recording.name))
        record = drive_record.of(recording, driver_name, replayed, table, accumulated, fixed)
        timing = clock.timing(recording)
        store(record, timing)
    return record, timing


def _human(recording: Recording) -> dict[str, str]:
    """Labels for the recorded commands; those that are not recorded say so."""
    kinds = {"throttle": recording.origins["throttle"].kind, "steering": recording.origins["steering_rad"].kind}
    return {name: "human" if kind == "recorded" else f"human ({kind})" for name, kind in kinds.items()}


def _rows(
    recording: Recording,
    driver: OpenLoopDriver | None,
    fixed: FixedStructure | None,
    video: DriveVideo | None,
    clock: Clock,
    accumulated: Accumulated,
    progress: Progress,
) -> Iterator[FrameRow]:
    """One row a frame; without a driver only the recorded columns."""
    parts = iter(segments(recording))
    ego = FlowDerotation(recording.camera, variant.load(OWN_VARIANT), recording.rate_hz, fixed)
    lead = LeadVehicle(recording.camera, recording.rate_hz)
    segment, number, moved_m = Segment(0, 0, (0.0, 0.0), 0.0), -1, 0.0
    last = Decision(Command(0.0, 0.0) if driver else Command(nan, nan))
    for k, image, taken_s in _images(recording, clock, accumulated.faults):
        if k == segment.stop:
            segment, number = next(parts), number + 1
            if driver is not None:
                with at_frame(k):
                    driver.begin(segment)
        moved_m += _step_m(recording, k)
        row = _recorded(recording, k, number)
        if image is not None and driver is not None:
            began = thread_time()
            with at_frame(k):
                decision = driver.decide(_observation(recording, k, image, taken_s, segment), _interval(recording, k))
            clock.driver_ms.append(1e3 * (thread_time() - began))
            last = _hold_if_uncertain(decision, last, row.speed_mps)
            row = row._replace(image=1.0, **_perception_columns(last, recording.camera))
            if image.size:
                grey_image = grey(image)
                motion, moved_m = ego.update(grey_image, moved_m), 0.0
                accumulated.speed_votes.append((row.time_s, motion.speed_votes))
                row = row._replace(ttc_s=lead.ttc_s(grey_image, row.lead_gap_m), **_ego_columns(motion))
        row = row._replace(throttle=last.command.throttle, steering=last.command.steering)
        if video is not None:
            video.write(image, last, row)
        progress(k + 1, len(recording))
        yield row


def _hold_if_uncertain(decision: Decision, last: Decision, speed_mps: float) -> Decision:
    """The decision, with the last command where the car moves and the flow is unreliable."""
    perceived = None if decision.plan is None else decision.plan.perception
    if perceived is None or last.plan is None or not speed_mps > LEAST_SPEED_MPS:
        return decision  # there is no flow at the first frame
    uncertain = perceived.expansion.confidence < LEAST_CONFIDENCE
    return replace(decision, command=last.command, is_held=True) if uncertain else decision


def _images(recording: Recording, clock: Clock, faults: list[str]) -> Iterator[tuple[int, Image | None, float]]:
    """Frame numbers, images (None for a gap, empty without images), and their times, s."""
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
    """Driver setup with the goal of the last segment and the initial speed, as in the paper."""
    if driver.privileged == "world":
        raise InputError(f"{recording.name}: the driver needs the world, which a recording does not have")
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
        speed_mps=max(float(recording.speed_mps[k]), 0.0),  # drivers do not support reverse
        yaw_rate_radps=float(recording.yaw_rate_radps[k]),
        goal_m=segment.goal_m,
        frame_time_s=taken_s,
    )


def _interval(recording: Recording, k: int) -> Interval:
    """Motion to the next frame; the last frame repeats the motion before it."""
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


def _perception_columns(decision: Decision, camera: Camera) -> dict[str, float]:
    """The columns of a driver's perception."""
    perceived = None if decision.plan is None else decision.plan.perception
    if perceived is None:
        return {}
    usable = perceived.expansion.confidence > 0.0
    return {
        "road_found": nan if decision.road_found is None else float(decision.road_found),
        "road_confidence": perceived.road.lane_confidence,
        "obstacle_detected": float(has_obstacle_in_corridor(perceived)),
        **frame_table.columns(perceived, camera),
        "lane_m": perceived.road.lane_m if decision.road_found else nan,
        "lane_width_m": perceived.road.lane_width_m if decision.road_found else nan,
        "foe_x_px": perceived.expansion.x_px if usable else nan,
        "foe_y_px": perceived.expansion.y_px if usable else nan,
        "foe_confidence": perceived.expansion.confidence,
        "held": float(decision.is_held),
    }


def _ego_columns(motion: EgoMotion) -> dict[str, float]:
    usable = motion.expansion.confidence > 0.0
    return {
        "own_foe_x_px": motion.expansion.x_px if usable else nan,
        "own_foe_y_px": motion.expansion.y_px if usable else nan,
        "flow_yaw_rate_radps": motion.yaw_rate_radps,
    }
