"""Estimates the mounting of an unknown camera by the focus of expansion on straight road.

Speed and yaw rate, where not recorded, also follow from the flow. The scale of the speed is the camera's height.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.planning import variant
from vpf_sim.replay import flow_derotation, road_speed, series
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.image_files import Frame
from vpf_sim.replay.mounting_estimate import PRIOR_SD_RAD, Angle, angle, observed_angles
from vpf_sim.replay.rectify import Mounting
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow, Image

VARIANT = "robust"  # its flow settings are used
ROUNDS = 2  # yaw rate and mounting depend on each other
ENOUGH = 100  # observations; more do not change the result
MOST_STORED = 900  # observations that the mounting is estimated from
LEAST_OBSERVATIONS = 5
STRAIGHT_RADPS, LEAST_SPEED_MPS, MOST_FOE_SD_RAD = 0.03, 2.0, 0.03  # largest sd of a usable focus of expansion
UNKNOWN_YAW_RATE_SD_RADPS = 0.5
ASSUMED_SPEED_MPS = 10.0  # sets only the scale of the flow


@dataclass(frozen=True, slots=True)
class FlowCalibration:
    """The images' estimates; arrays are (N,), nan where nothing was found."""

    mounting: Mounting  # 0 for angles that are too uncertain
    pitch: Angle
    yaw: Angle
    observations: int  # on straight road
    speed_mps: Floats
    yaw_rate_radps: Floats
    is_blind: Bools  # too few points show the scene to tell whether the car moves


@dataclass(frozen=True, slots=True)
class _Observation:
    index: int
    flow: Flow  # of the scene
    speed_mps: float  # inf if not recorded
    yaw_rate_radps: float  # as recorded; nan if not
    moves: bool | None  # None: too few points show the scene


@dataclass(frozen=True, slots=True)
class _Directions:
    """Directions of travel in M observations."""

    foe_px: Floats  # (M, 2)
    sd_px: Floats  # (M, 2) by each fit
    gives_yaw: Bools  # (M,) whether the yaw rate is known; else a yaw rate looks like a yaw angle

    def __len__(self) -> int:
        return len(self.foe_px)


def estimate(
    frames: Iterator[Frame],
    camera: Camera,
    times_s: Floats,
    speed_mps: Floats | None,
    yaw_rate_radps: Floats | None,
    ahead_m: float = 0.0,
    fixed: FixedStructure | None = None,
) -> FlowCalibration:
    """Estimate mounting and motion from the frames.

    All frames are processed if speed or yaw rate (N,) are needed, else only until there are enough. `camera` is
    assumed to look straight ahead and level; its height is trusted. It is `ahead_m` before the rear axle, so in a
    bend it moves outward by the yaw rate times this. Points on what is `fixed` to the camera are left out; where too
    few others are left, nothing is known.

    First, the yaw rate and the focus of expansion are fitted in every frame, to find straight road. Straight road
    then gives the mounting. Bends also give its yaw, if the yaw rate was recorded.
    """
    observations = _observations(frames, camera, times_s, speed_mps, yaw_rate_radps, fixed)
    stored = list(islice(observations, MOST_STORED))
    moving = [one for one in stored if one.moves]
    stride = max(1, len(moving) // ENOUGH)
    second_s = stride * float(np.median(np.diff(times_s)))  # driving time that an observation covers
    guess, count = Mounting(height_m=camera.height_m), 0
    pitch, yaw = (Angle(prior) for prior in PRIOR_SD_RAD)
    for turn in range(1 + ROUNDS):
        directions = _travel_directions(moving[::stride], camera, guess, turn > 0, ahead_m)
        if len(directions) >= LEAST_OBSERVATIONS:
            angles, count = _angles(camera, directions, second_s), len(directions)
            guess = replace(guess, pitch_rad=angles[0].rad, yaw_rad=angles[1].rad)
            pitch, yaw = (
                new if new.is_used or not old.is_used else old for new, old in zip(angles, (pitch, yaw), strict=True)
            )
    mounting = Mounting(pitch.used_rad, _significant(yaw), height_m=camera.height_m)
    motion = _motion(chain(stored, observations), camera, mounting, times_s)
    return FlowCalibration(mounting, pitch, yaw, count, *motion)


def _observations(
    frames: Iterator[Frame],
    camera: Camera,
    times_s: Floats,
    speed_mps: Floats | None,
    yaw_rate_radps: Floats | None,
    fixed: FixedStructure | None,
) -> Iterator[_Observation]:
    """Each frame with flow, without points that move with the camera."""
    rate_hz = 1.0 / float(np.median(np.diff(times_s)))
    config = replace(variant.load(VARIANT).flow, from_road=False)  # the motion is not known yet
    tracker, last = FlowTracker(camera, config, rate_hz), -1
    recorded = np.full(len(times_s), np.nan) if speed_mps is None else speed_mps
    speed = (
        series.filled(times_s, recorded)[0] if np.isfinite(recorded).any() else np.full(len(times_s), ASSUMED_SPEED_MPS)
    )
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times_s))])
    both, straight = speed_mps is not None and yaw_rate_radps is not None, 0
    for yielded, frame in enumerate(frames):
        if frame.image is None:
            continue
        if frame.index != last + 1:  # tracks across a gap would seem too fast
            tracker = FlowTracker(camera, config, rate_hz)
        last = frame.index
        flow = _scene_flow(tracker, grey(frame.image), along[frame.index], fixed)
        rate = float("nan") if yaw_rate_radps is None else float(yaw_rate_radps[frame.index])
        if speed[frame.index] < LEAST_SPEED_MPS:
            continue
        steps = np.rint(flow.gap_s * rate_hz).astype(np.intp)
        flow = replace(flow, gap_s=times_s[frame.index] - times_s[frame.index - steps])  # true times of uneven frames
        moves = _moves(flow, camera, fixed)
        if moves:
            flow = flow.select(np.flatnonzero(~flow.on_glass))
        known = np.isfinite(recorded[frame.index])
        yield _Observation(frame.index, flow, float(speed[frame.index]) if known else np.inf, rate, moves)
        straight += abs(rate) < STRAIGHT_RADPS
        if both and (straight >= ENOUGH or yielded >= MOST_STORED):
            return


def _scene_flow(tracker: FlowTracker, image: Image, along_m: float, fixed: FixedStructure | None) -> Flow:
    """The flow of points that are not on what is fixed to the camera."""
    pose = np.array([along_m, 0.0, 0.0])
    if fixed is None:
        return tracker.update(image, pose)
    flow = tracker.update(fixed.filled(image), pose, fixed.hidden)
    return flow.select(np.flatnonzero(fixed.scene(flow.points_px)))


def _moves(flow: Flow, camera: Camera, fixed: FixedStructure | None) -> bool | None:
    """Whether the car moves; None where a stationary scene looks the same as what is fixed to the camera."""
    if flow_derotation.moves(flow, camera):
        return True
    is_visible = fixed is not None and fixed.leaves_scene and len(flow) >= flow_derotation.LEAST_POINTS
    return False if is_visible else None


def _travel_directions(
    observations: list[_Observation], camera: Camera, mounting: Mounting, straight_only: bool, ahead_m: float
) -> _Directions:
    """Directions of travel by the observations, all of them or those on straight road only."""
    config = variant.load(VARIANT).focus_of_expansion
    assert config.fit is not None  # of the robust variant
    usual = config.fit.rotation
    random = stream(0, "mounting")
    rows: list[tuple[float, ...]] = []
    for one in observations:
        recorded = bool(np.isfinite(one.yaw_rate_radps))
        rate = _rate(one, camera, mounting) if recorded or straight_only else 0.0
        if straight_only and abs(rate) >= STRAIGHT_RADPS:
            continue
        # A yaw rate by the flow is as rough as the pitch rate.
        rough = usual.tilt_sd_radps if straight_only else UNKNOWN_YAW_RATE_SD_RADPS
        rotation = usual if recorded else replace(usual, yaw_sd_radps=rough)
        known = replace(config, fit=replace(config.fit, direction_prior=None, rotation=rotation))
        flow = flow_derotation.turning(one.flow, rate)
        found = expansion.estimate(flow, camera, known, random)
        if found.confidence > 0.0 and np.sqrt(found.covariance_px2.trace()) < MOST_FOE_SD_RAD * camera.fx_px:
            shift = camera.fx_px * ahead_m * rate / one.speed_mps
            spread = np.sqrt(found.covariance_px2.diagonal())
            rows.append((found.x_px - shift, found.y_px, *spread, float(recorded or straight_only)))
    directions = np.reshape(np.array(rows), (-1, 5))
    return _Directions(directions[:, :2], directions[:, 2:4], directions[:, 4] > 0.0)


def _angles(camera: Camera, directions: _Directions, second_s: float) -> tuple[Angle, Angle]:
    """Pitch and yaw by directions that cover `second_s` of driving each."""
    focal = np.array([camera.fx_px, camera.fy_px])
    observed_rad = observed_angles(camera, directions.foe_px)
    durations_s = (second_s * len(directions), second_s * float(np.count_nonzero(directions.gives_yaw)))
    sds_rad = (directions.sd_px / focal).T[::-1]
    pitch, yaw = (
        angle(values, sd, prior, seconds)
        for values, sd, prior, seconds in zip(observed_rad, sds_rad, PRIOR_SD_RAD, durations_s, strict=True)
    )
    return pitch, yaw


def _significant(yaw: Angle) -> float:
    """rad; 0 below twice its error, since rotating the image would only blur it."""
    return yaw.used_rad if abs(yaw.rad) > 2.0 * yaw.sd_rad else 0.0


def _rate(one: _Observation, camera: Camera, mounting: Mounting) -> float:
    """rad/s as recorded, or by the flow for the given mounting."""
    if np.isfinite(one.yaw_rate_radps):
        return one.yaw_rate_radps
    if not len(one.flow):
        return 0.0
    ahead = camera.cx_px - camera.fx_px * np.tan(mounting.yaw_rad) / np.cos(mounting.pitch_rad)
    return flow_derotation.yaw_rate(one.flow, replace(camera, cx_px=ahead, pitch_rad=mounting.pitch_rad))


def _motion(
    observations: Iterable[_Observation], camera: Camera, mounting: Mounting, times_s: Floats
) -> tuple[Floats, Floats, Bools]:
    """(N,) speed m/s and yaw rate rad/s by the flow, nan where no road was tracked; and where nothing is known."""
    rate, voted = np.full(len(times_s), np.nan), []
    standing, blind = np.zeros((2, len(times_s)), np.bool_)
    for one in observations:
        standing[one.index], blind[one.index] = one.moves is False, one.moves is None
        if one.moves is None:
            continue
        rate[one.index] = _rate(one, camera, mounting)
        flow = flow_derotation.turning(one.flow, rate[one.index])
        voted.append((float(times_s[one.index]), road_speed.votes(flow, camera, mounting)))
    return road_speed.speed(times_s, voted, standing), np.where(standing, 0.0, _median_filtered(rate)), blind


def _median_filtered(values: Floats) -> Floats:
    """(N,) running medians of five, since frames with few points give outliers."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(values, 2, constant_values=np.nan), 5)
    result, known = values.copy(), np.isfinite(around).any(axis=1)
    result[known] = np.nanmedian(around[known], axis=1)
    return result
