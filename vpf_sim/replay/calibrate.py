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
from vpf_sim.replay import own_derotation, road_speed, series
from vpf_sim.replay.recording import Frame
from vpf_sim.replay.rectify import Mounting, mounting_seeing
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Flow

VARIANT = "robust"  # whose flow is used
ROUNDS = 2  # the turn needs the mounting, the mounting the turn
ENOUGH = 100  # looks after which more change nothing
HELD = 900  # looks that the mounting is told from at most: the rest of a long drive is only looked at as it passes
LEAST_LOOKS = 5
STILL_PX = 3.0  # a second: what moves by less stands
STRAIGHT_RADPS, LEAST_SPEED_MPS, SHARP_RAD = 0.03, 2.0, 0.03  # a look tells if its focus is as sharp as this
FREE_RADPS = 0.5  # usual size of a yaw rate of which nothing is known
ASSUMED_SPEED_MPS = 10.0  # of the first look, where none is recorded: the flow's scale only


@dataclass(frozen=True, slots=True)
class OwnWay:
    """What the pictures say. Arrays are (N,), nan where nothing was found."""

    mounting: Mounting
    looks: int  # straight ahead
    spread_px: tuple[float, float]  # half the distance between the quartiles of the focus of expansion, x and y
    speed_mps: Floats
    yaw_rate_radps: Floats


@dataclass(frozen=True, slots=True)
class _Look:
    index: int
    flow: Flow
    speed_mps: float  # inf where it is not told
    yaw_rate_radps: float  # as told; nan where it is not


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
    focus of expansion, at every frame; then the frames on which the car goes straight say it more sharply.
    """
    looks = _looks(frames, camera, times_s, speed_mps, yaw_rate_radps)
    held = list(islice(looks, HELD))
    mounting, best = Mounting(height_m=camera.height_m), np.empty((0, 2))
    moving = [one for one in held if not _stands(one.flow)]
    chosen = moving[:: max(1, len(moving) // ENOUGH)]
    for turn in range(1 + ROUNDS):
        seen = _seen(chosen, camera, mounting if turn else None, ahead_m)
        if len(seen) >= LEAST_LOOKS:
            mounting, best = _mounted(camera, np.median(seen, axis=0)), seen
    spread = np.subtract(*np.percentile(best, [75, 25], axis=0)) / 2.0 if len(best) else np.full(2, np.nan)
    # A median of n values of a normal distribution errs by 1.25 sd / sqrt(n), sd is 1.48 half quartile ranges. A yaw
    # that is not twice as large is none: to turn the picture by it would only blur it.
    if abs(camera.fx_px * np.tan(mounting.yaw_rad)) < 2.0 * 1.25 * 1.48 * spread[0] / np.sqrt(max(len(best), 1)):
        mounting = replace(mounting, yaw_rad=0.0)
    return OwnWay(
        mounting,
        len(best),
        (float(spread[0]), float(spread[1])),
        *_motion(chain(held, looks), camera, mounting, times_s),
    )


def _looks(
    frames: Iterator[Frame], camera: Camera, times_s: Floats, speed_mps: Floats | None, yaw_rate_radps: Floats | None
) -> Iterator[_Look]:
    rate_hz = 1.0 / float(np.median(np.diff(times_s)))
    config = variant.load(VARIANT).flow
    tracker, last = FlowTracker(camera, config, rate_hz), -1
    told = np.full(len(times_s), np.nan) if speed_mps is None else speed_mps
    speed = series.filled(told)[0] if np.isfinite(told).any() else np.full(len(times_s), ASSUMED_SPEED_MPS)
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
        known = np.isfinite(told[frame.index])
        yield _Look(frame.index, flow, float(speed[frame.index]) if known else np.inf, rate)
        straight += abs(rate) < STRAIGHT_RADPS
        if both and (straight >= ENOUGH or yielded >= HELD):
            return


def _seen(looks: list[_Look], camera: Camera, mounting: Mounting | None, ahead_m: float) -> Floats:
    """(M, 2) px where the looks put straight ahead: those on a straight, given a mounting, else all of them."""
    config = replace(variant.load(VARIANT).expansion, direction_sd_rad=(np.inf, np.inf))
    pitch, yaw, roll = config.rotation_sd_radps
    random = stream(0, "mounting")
    seen = []
    for one in looks:
        told = np.isfinite(one.yaw_rate_radps)
        rate = 0.0 if mounting is None and not told else _rate(one, camera, mounting or Mounting())
        if mounting is not None and abs(rate) >= STRAIGHT_RADPS:
            continue
        rough = FREE_RADPS if mounting is None else pitch  # a turn by the flow is as rough as the pitch rate
        known = replace(config, rotation_sd_radps=(pitch, yaw if told else rough, roll))
        found = expansion.estimate(own_derotation.turning(one.flow, rate), camera, known, random)
        if found.confidence > 0.0 and np.sqrt(found.covariance_px2.trace()) < SHARP_RAD * camera.fx_px:
            outward = camera.fx_px * ahead_m * rate / one.speed_mps
            seen.append((found.x_px - outward, found.y_px))
    return np.reshape(np.array(seen), (-1, 2))


def _rate(one: _Look, camera: Camera, mounting: Mounting) -> float:
    """rad/s, as told, or by the flow away from where the mounting puts straight ahead."""
    if np.isfinite(one.yaw_rate_radps):
        return one.yaw_rate_radps
    ahead = camera.cx_px - camera.fx_px * np.tan(mounting.yaw_rad) / np.cos(mounting.pitch_rad)
    return own_derotation.yaw_rate(one.flow, replace(camera, cx_px=ahead, pitch_rad=mounting.pitch_rad))


def _mounted(camera: Camera, foe_px: Floats) -> Mounting:
    """The camera that sees the way of the car there. Its roll is taken to be none."""
    right, down = (foe_px[0] - camera.cx_px) / camera.fx_px, (foe_px[1] - camera.cy_px) / camera.fy_px
    return mounting_seeing(np.array([right, down, 1.0]), camera.height_m)


def _stands(flow: Flow) -> bool:
    """Whether the whole picture stays where it is."""
    return bool(np.median(np.hypot(*flow.displacement_px.T)) < STILL_PX * np.median(flow.gap_s))


def _motion(looks: Iterable[_Look], camera: Camera, mounting: Mounting, times_s: Floats) -> tuple[Floats, Floats]:
    """(N,) speed m/s and yaw rate rad/s by the flow; nan where no road was tracked."""
    rate, voted = np.full(len(times_s), np.nan), []
    stands = np.zeros(len(times_s), np.bool_)
    for one in looks:
        stands[one.index] = _stands(one.flow)
        rate[one.index] = _rate(one, camera, mounting)
        flow = own_derotation.turning(one.flow, rate[one.index])
        voted.append((float(times_s[one.index]), road_speed.votes(flow, camera, mounting)))
    return np.where(stands, 0.0, road_speed.speed(times_s, voted)), np.where(stands, 0.0, _steadied(rate))


def _steadied(values: Floats) -> Floats:
    """(N,) medians of five: a frame of few points may give any turn."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(values, 2, constant_values=np.nan), 5)
    result, known = values.copy(), np.isfinite(around).any(axis=1)
    result[known] = np.nanmedian(around[known], axis=1)
    return result
