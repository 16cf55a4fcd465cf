"""A camera whose mounting is not known, calibrated on the way: by the focus of expansion while the car drives straight.

Where speed and yaw rate were not recorded either, they too follow from the flow: the turn of the picture, and how fast
the road comes nearer, which fixes the speed as far as the camera's height is known.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.planning import variant
from vpf_sim.replay import glass_points, own_derotation, road_speed, series
from vpf_sim.replay.mounting_estimate import PRIOR_SD_RAD, Angle, angle, angles_seen
from vpf_sim.replay.recording import Frame
from vpf_sim.replay.rectify import Mounting
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow

VARIANT = "robust"  # whose flow is used
ROUNDS = 2  # the turn needs the mounting, the mounting the turn
ENOUGH = 100  # looks after which more change nothing
HELD = 900  # looks that the mounting is told from at most: the rest of a long drive is only looked at as it passes
LEAST_LOOKS = 5
STRAIGHT_RADPS, LEAST_SPEED_MPS, SHARP_RAD = 0.03, 2.0, 0.03  # a look tells if its focus is as sharp as this
FREE_RADPS = 0.5  # usual size of a yaw rate of which nothing is known
ASSUMED_SPEED_MPS = 10.0  # of the first look, where none is recorded: the flow's scale only


@dataclass(frozen=True, slots=True)
class OwnWay:
    """What the pictures say. Arrays are (N,), nan where nothing was found."""

    mounting: Mounting  # as far as it is known well enough
    pitch: Angle
    yaw: Angle
    looks: int  # straight ahead
    speed_mps: Floats
    yaw_rate_radps: Floats


@dataclass(frozen=True, slots=True)
class _Look:
    index: int
    flow: Flow  # of the scene
    speed_mps: float  # inf where it is not told
    yaw_rate_radps: float  # as told; nan where it is not
    moves: bool


@dataclass(frozen=True, slots=True)
class _Sightings:
    """Where M looks saw the car go."""

    foe_px: Floats  # (M, 2)
    sd_px: Floats  # (M, 2) by the fit of each
    speed_mps: Floats  # (M,) nan where neither told nor seen
    tells_yaw: Bools  # (M,) its turn is known or none: else a turn and a yaw look alike

    def __len__(self) -> int:
        return len(self.foe_px)


def look(
    frames: Iterator[Frame],
    camera: Camera,
    times_s: Floats,
    speed_mps: Floats | None,
    yaw_rate_radps: Floats | None,
    ahead_m: float = 0.0,
) -> OwnWay:
    """Watch the drive, all of it if speed or yaw rate (N,) are asked for, else until enough was seen.

    `camera` is taken to look straight ahead and level; its height is believed. It sits `ahead_m` before the rear axle:
    in a bend it moves to the outside by the yaw rate times this. First the turn of the picture is fitted along with the
    focus of expansion, at every frame, to find the frames on which the car goes straight. These tell the mounting;
    bends tell its yaw, too, where the yaw rate was recorded.
    """
    looks = _looks(frames, camera, times_s, speed_mps, yaw_rate_radps)
    held = list(islice(looks, HELD))
    moving = [one for one in held if one.moves]
    stride = max(1, len(moving) // ENOUGH)
    second_s = stride * float(np.median(np.diff(times_s)))  # of way that a look stands for
    guess, looked = Mounting(height_m=camera.height_m), 0
    pitch, yaw = (Angle(prior) for prior in PRIOR_SD_RAD)
    for turn in range(1 + ROUNDS):
        seen = _seen(moving[::stride], camera, guess, turn > 0, ahead_m)
        if len(seen) >= LEAST_LOOKS:
            angles, looked = _angles(camera, seen, second_s), len(seen)
            guess = replace(guess, pitch_rad=angles[0].rad, yaw_rad=angles[1].rad)
            pitch, yaw = (
                new if new.is_used or not old.is_used else old for new, old in zip(angles, (pitch, yaw), strict=True)
            )
    mounting = Mounting(pitch.used_rad, _significant(yaw), height_m=camera.height_m)
    motion = _motion(chain(held, looks), camera, mounting, times_s)
    return OwnWay(mounting, pitch, yaw, looked, *motion)


def _looks(
    frames: Iterator[Frame],
    camera: Camera,
    times_s: Floats,
    speed_mps: Floats | None,
    yaw_rate_radps: Floats | None,
) -> Iterator[_Look]:
    """Of every frame with flow; what rides along with the camera is left out first."""
    rate_hz = 1.0 / float(np.median(np.diff(times_s)))
    config = variant.load(VARIANT).flow
    tracker, last = FlowTracker(camera, config, rate_hz), -1
    told = np.full(len(times_s), np.nan) if speed_mps is None else speed_mps
    speed = series.filled(times_s, told)[0] if np.isfinite(told).any() else np.full(len(times_s), ASSUMED_SPEED_MPS)
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times_s))])
    both, straight = speed_mps is not None and yaw_rate_radps is not None, 0
    for yielded, frame in enumerate(frames):
        if frame.image is None:
            continue
        if frame.index != last + 1:  # tracks over a gap would look twice as fast
            tracker = FlowTracker(camera, config, rate_hz)
        last = frame.index
        flow = tracker.update(grey(frame.image), np.array([along[frame.index], 0.0, 0.0]))
        rate = float("nan") if yaw_rate_radps is None else float(yaw_rate_radps[frame.index])
        if speed[frame.index] < LEAST_SPEED_MPS or not len(flow):
            continue
        steps = np.rint(flow.gap_s * rate_hz).astype(np.intp)
        flow = replace(flow, gap_s=times_s[frame.index] - times_s[frame.index - steps])  # whatever the rate was there
        moves = glass_points.moves(flow, camera)
        if moves:
            flow = glass_points.without(flow, flow.stuck)
        known = np.isfinite(told[frame.index])
        yield _Look(frame.index, flow, float(speed[frame.index]) if known else np.inf, rate, moves)
        straight += abs(rate) < STRAIGHT_RADPS
        if both and (straight >= ENOUGH or yielded >= HELD):
            return


def _seen(looks: list[_Look], camera: Camera, mounting: Mounting, straight_only: bool, ahead_m: float) -> _Sightings:
    """Where the looks put straight ahead: those on a straight, by a mounting as far as it is known, or all of them."""
    config = replace(variant.load(VARIANT).focus_of_expansion, direction_sd_rad=(np.inf, np.inf))
    pitch, yaw, roll = config.rotation_sd_radps
    random = stream(0, "mounting")
    rows: list[tuple[float, ...]] = []
    for one in looks:
        told = bool(np.isfinite(one.yaw_rate_radps))
        rate = _rate(one, camera, mounting) if told or straight_only else 0.0
        if straight_only and abs(rate) >= STRAIGHT_RADPS:
            continue
        rough = pitch if straight_only else FREE_RADPS  # a turn by the flow is as rough as the pitch rate
        known = replace(config, rotation_sd_radps=(pitch, yaw if told else rough, roll))
        flow = own_derotation.turning(one.flow, rate)
        found = expansion.estimate(flow, camera, known, random)
        if found.confidence > 0.0 and np.sqrt(found.covariance_px2.trace()) < SHARP_RAD * camera.fx_px:
            outward = camera.fx_px * ahead_m * rate / one.speed_mps
            spread = np.sqrt(found.covariance_px2.diagonal())
            speed = one.speed_mps if np.isfinite(one.speed_mps) else _speed(flow, camera, mounting)
            rows.append((found.x_px - outward, found.y_px, *spread, speed, float(told or straight_only)))
    seen = np.reshape(np.array(rows), (-1, 6))
    return _Sightings(seen[:, :2], seen[:, 2:4], seen[:, 4], seen[:, 5] > 0.0)


def _speed(flow: Flow, camera: Camera, mounting: Mounting) -> float:
    """m/s, roughly; nan where no road is seen."""
    votes = road_speed.votes(flow, camera, mounting)
    return float(np.median(votes[:, 0])) if len(votes) else float("nan")


def _angles(camera: Camera, seen: _Sightings, second_s: float) -> tuple[Angle, Angle]:
    """Pitch and yaw, by sightings that stand for so many seconds of way each."""
    known = seen.speed_mps[np.isfinite(seen.speed_mps)]
    speed = float(np.median(known)) if len(known) else 0.0
    focal = np.array([camera.fx_px, camera.fy_px])
    seen_rad = angles_seen(camera, seen.foe_px)
    ways_s = (second_s * len(seen), second_s * float(np.count_nonzero(seen.tells_yaw)))
    sds_rad = (seen.sd_px / focal).T[::-1]
    pitch, yaw = (
        angle(values, sd, prior, seconds, seconds * speed)
        for values, sd, prior, seconds in zip(seen_rad, sds_rad, PRIOR_SD_RAD, ways_s, strict=True)
    )
    return pitch, yaw


def _significant(yaw: Angle) -> float:
    """rad; none where it is no larger than twice its error: to turn the picture by it would only blur it."""
    return yaw.used_rad if abs(yaw.rad) > 2.0 * yaw.sd_rad else 0.0


def _rate(one: _Look, camera: Camera, mounting: Mounting) -> float:
    """rad/s, as told, or by the flow away from where the mounting puts straight ahead."""
    if np.isfinite(one.yaw_rate_radps):
        return one.yaw_rate_radps
    if not len(one.flow):
        return 0.0
    ahead = camera.cx_px - camera.fx_px * np.tan(mounting.yaw_rad) / np.cos(mounting.pitch_rad)
    return own_derotation.yaw_rate(one.flow, replace(camera, cx_px=ahead, pitch_rad=mounting.pitch_rad))


def _motion(looks: Iterable[_Look], camera: Camera, mounting: Mounting, times_s: Floats) -> tuple[Floats, Floats]:
    """(N,) speed m/s and yaw rate rad/s by the flow; nan where no road was tracked."""
    rate, voted = np.full(len(times_s), np.nan), []
    stands = np.zeros(len(times_s), np.bool_)
    for one in looks:
        stands[one.index] = not one.moves
        rate[one.index] = _rate(one, camera, mounting)
        flow = own_derotation.turning(one.flow, rate[one.index])
        voted.append((float(times_s[one.index]), road_speed.votes(flow, camera, mounting)))
    return road_speed.speed(times_s, voted, stands), np.where(stands, 0.0, _steadied(rate))


def _steadied(values: Floats) -> Floats:
    """(N,) medians of five: a frame of few points may give any turn."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(values, 2, constant_values=np.nan), 5)
    result, known = values.copy(), np.isfinite(around).any(axis=1)
    result[known] = np.nanmedian(around[known], axis=1)
    return result
