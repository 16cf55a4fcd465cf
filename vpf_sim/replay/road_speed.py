"""Estimates the speed from the flow of the road and the height of the camera.

Points that may lie on the road vote. The speed is the path over the drive with most votes, within what engine and
brakes allow (Viterbi 1967). So a window with outliers, or without agreement, causes no jump.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import solveh_banded

from vpf_sim.geometry import ground_from_pixels
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.replay.rectify import Mounting
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers

NEAR_M, FAR_M, HALF_M = 3.0, 25.0, 4.0  # used part of the road, from the camera
MOST_LATERAL_M = 0.3  # of a road point in a window
LEAST_FLOW_PX, LEAST_SPEED_MPS, MOST_SPEED_MPS = 1.0, 1.0, 70.0
WINDOW_S = 0.6  # of votes that are counted together
LEAST_VOTES = 5
BRIDGED_S = 0.6  # from a window with enough votes, over which the path holds
WIDTH = 0.1  # of the kernel, of the speed's logarithm
KNOT_S = 0.2  # between the knots of the path
STEP_MPS = 0.2
GRID_MPS = np.arange(0.0, MOST_SPEED_MPS, STEP_MPS)
MOST_GAIN_MPS2, MOST_LOSS_MPS2 = 5.0, 9.0  # limits of a strong engine, of emergency braking
USUAL_MPS2 = 3.0  # standard deviation of an acceleration
CLUTTER = 0.05  # floor of the density, for windows without road
UNLIKELY_REST = 0.01  # likelihood of a moving car whose image does not move
JUMP, REST_JUMP = 20.0, 12.0  # cost in log likelihood of a cut in the video, and of one to or from a standing car
LEAST_DENSE = 30.0  # votes for full weight
SMOOTH_S = 0.4  # changes shorter than this are noise


def votes(flow: Flow, camera: Camera, mounting: Mounting) -> Floats:
    """(M, 2) m/s and weight of each point that may lie on the road; the flow's poses must have the rotation.

    A point at Z before and Z' now, both on a flat road, gives (Z - Z') / gap; its error grows with Z^2.
    """
    straight = replace(
        camera, cx_px=camera.cx_px - camera.fx_px * np.tan(mounting.yaw_rad), pitch_rad=mounting.pitch_rad
    )
    shift = expansion.derotate(flow, straight)
    now, past = (ground_from_pixels(straight, points) for points in (flow.points_px, flow.points_px - shift))
    ahead = now[:, 0] - straight.forward_m
    with np.errstate(invalid="ignore"):
        road = (ahead > NEAR_M) & (ahead < FAR_M) & (np.abs(now[:, 1]) < HALF_M)
        road &= np.abs(now[:, 1] - past[:, 1]) < MOST_LATERAL_M
    road &= (np.hypot(*shift.T) > LEAST_FLOW_PX) & (flow.gap_s > 0.0)
    speed = (past[road, 0] - now[road, 0]) / flow.gap_s[road]
    return np.stack([speed, flow.gap_s[road] / ahead[road] ** 2], axis=1)


def speed(times_s: Floats, voted: list[tuple[float, Floats]], standing: Bools | None = None) -> Floats:
    """(N,) m/s with most votes; 0 where the car is `standing` (N,), nan with too few votes.

    Densities count, not medians: points that slide along a line of the road lag behind and do not agree.
    """
    if not len(times_s):
        return np.empty(0)
    result = np.full(len(times_s), np.nan)
    is_standing = np.zeros(len(times_s), np.bool_) if standing is None else standing
    parts = [(time, part[(part[:, 0] > LEAST_SPEED_MPS) & (part[:, 0] < MOST_SPEED_MPS)]) for time, part in voted]
    ballots = np.concatenate([np.empty((0, 3)), *[np.column_stack([np.full(len(p), t), p]) for t, p in parts]])
    knots = np.arange(times_s[0], times_s[-1] + KNOT_S, KNOT_S)
    first, last = (np.searchsorted(ballots[:, 0], knots + side * 0.5 * WINDOW_S) for side in (-1.0, 1.0))
    known = last - first >= LEAST_VOTES
    at_rest = np.interp(knots, times_s, is_standing.astype(float)) > 0.5
    if (known | at_rest).any():
        path = _path(np.stack([_support(ballots[a:b], rest) for a, b, rest in zip(first, last, at_rest, strict=True)]))
        at_rest &= GRID_MPS[path] < 0.5 * LEAST_SPEED_MPS
        refined = np.array([_mean(ballots[a:b], GRID_MPS[i]) for a, b, i in zip(first, last, path, strict=True)])
        smooth = _smoothed(np.where(at_rest, 0.0, refined), np.where(known | at_rest, 1.0, 1e-3))
        smooth = np.where(at_rest, 0.0, np.maximum(smooth, 0.0))
        sure = knots[known | at_rest]
        after = np.clip(np.searchsorted(sure, times_s), 1, len(sure) - 1) if len(sure) > 1 else np.zeros(1, np.intp)
        away = np.minimum(np.abs(times_s - sure[after]), np.abs(times_s - sure[after - 1]))
        result = np.where(away <= BRIDGED_S, np.interp(times_s, knots, smooth), np.nan)
    return result


def _support(ballots: Floats, at_rest: bool) -> Floats:
    """(S,) log likelihood of each speed of the grid, by votes (M, 3) of time, speed and weight."""
    if at_rest:
        return np.where(GRID_MPS < 0.5 * LEAST_SPEED_MPS, 0.0, np.log(UNLIKELY_REST))
    if not len(ballots):
        return np.zeros(len(GRID_MPS))
    _, voted_mps, weight = ballots.T
    near = (np.log(np.maximum(GRID_MPS, 0.5 * LEAST_SPEED_MPS))[:, None] - np.log(voted_mps)) / WIDTH
    density = np.exp(-0.5 * near**2) @ weight / weight.sum()
    count: Floats = min(1.0, len(ballots) / LEAST_DENSE) * np.log(CLUTTER + (1.0 - CLUTTER) * density)
    return count


def _path(support: Floats) -> Integers:
    """(K,) grid indices of the likeliest path through K knots (K, S), within the limits of a car."""
    gains = np.arange(-int(MOST_LOSS_MPS2 * KNOT_S / STEP_MPS), int(MOST_GAIN_MPS2 * KNOT_S / STEP_MPS) + 1)
    # The cost is that of a window, since knots share its votes.
    unlikely = 0.5 * (gains * STEP_MPS / (USUAL_MPS2 * KNOT_S)) ** 2 * KNOT_S / WINDOW_S
    size, reach = support.shape[1], int(max(-gains[0], gains[-1]))
    came = np.zeros(support.shape, np.int64)
    best = support[0]
    for k in range(1, len(support)):
        padded = np.pad(best, reach, constant_values=-np.inf)
        options = np.stack([padded[reach - gain : reach - gain + size] for gain in gains]) - unlikely[:, None]
        chosen = options.argmax(axis=0)
        value, origin = options[chosen, np.arange(size)], np.arange(size) - gains[chosen]
        _allow_jump(value, origin, int(best.argmax()), float(best.max()) - JUMP)
        _allow_jump(value, origin, 0, float(best[0]) - REST_JUMP)
        _allow_jump(value[:1], origin[:1], int(best.argmax()), float(best.max()) - REST_JUMP)
        came[k], best = origin, value + support[k]
    path = np.zeros(len(support), np.int64)
    path[-1] = int(best.argmax())
    for k in range(len(support) - 1, 0, -1):
        path[k - 1] = came[k, path[k]]
    return path


def _allow_jump(value: Floats, origin: Integers, index: int, worth: float) -> None:
    """Replace values below `worth` by a jump from the grid `index`."""
    less = value < worth
    value[less], origin[less] = worth, index


def _mean(ballots: Floats, about_mps: float) -> float:
    """m/s, mean of the votes near a speed; that speed without votes."""
    _, voted_mps, weight = ballots.T
    near = weight * np.exp(-0.5 * (np.log(max(about_mps, 0.5 * LEAST_SPEED_MPS) / voted_mps) / WIDTH) ** 2)
    total = float(near.sum())
    if not total > 0.01 * float(weight.sum()):
        return about_mps
    return float(np.exp(np.sum(near * np.log(voted_mps)) / total))


def _smoothed(values: Floats, weight: Floats) -> Floats:
    """(K,) series with the least change of slope near values (K,) (Whittaker 1923)."""
    if len(values) < 3:
        return values
    second, inner = np.array([1.0, -2.0, 1.0]), len(values) - 2
    bands = np.zeros((3, len(values)))  # lower bands of the sum of outer products
    for apart in range(3):
        for i in range(3 - apart):
            bands[apart, i : i + inner] += (SMOOTH_S / KNOT_S) ** 4 * second[i] * second[i + apart]
    bands[0] += weight
    return np.asarray(solveh_banded(bands, weight * values, lower=True))
