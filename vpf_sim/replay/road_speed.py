"""The speed by how fast the road comes nearer, as far as the camera's height above it is known."""

from dataclasses import replace

import numpy as np

from vpf_sim.geometry import ground_from_pixels
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.replay.rectify import Mounting
from vpf_sim.types import Camera, Floats, Flow

NEAR_M, FAR_M, HALF_M = 3.0, 25.0, 4.0  # of the road that is looked at, from the camera
ASTRAY_M = 0.3  # a point of the road does not move across by more in a window
LEAST_FLOW_PX, LEAST_SPEED_MPS, MOST_SPEED_MPS = 1.0, 1.0, 70.0
WINDOW_S = 1.0  # whose points vote together
LEAST_VOTES = 5
WIDTH = 0.1  # of the kernel, of the speed's logarithm
GRID = np.log(np.arange(LEAST_SPEED_MPS, MOST_SPEED_MPS, 0.25))


def votes(flow: Flow, camera: Camera, mounting: Mounting) -> Floats:
    """(M, 2) m/s and weight, of each point that could lie on the road; its turn must be known to the flow's poses.

    A point at Z before and Z' now, both by the flat road, says (Z - Z') / gap; its error grows with Z^2.
    """
    straight = replace(
        camera, cx_px=camera.cx_px - camera.fx_px * np.tan(mounting.yaw_rad), pitch_rad=mounting.pitch_rad
    )
    shift = expansion.derotate(flow, straight)
    now, past = (ground_from_pixels(straight, points) for points in (flow.points_px, flow.points_px - shift))
    ahead = now[:, 0] - straight.forward_m
    with np.errstate(invalid="ignore"):
        road = (ahead > NEAR_M) & (ahead < FAR_M) & (np.abs(now[:, 1]) < HALF_M)
        road &= np.abs(now[:, 1] - past[:, 1]) < ASTRAY_M
    road &= (np.hypot(*shift.T) > LEAST_FLOW_PX) & (flow.gap_s > 0.0)
    speed = (past[road, 0] - now[road, 0]) / flow.gap_s[road]
    return np.stack([speed, flow.gap_s[road] / ahead[road] ** 2], axis=1)


def speed(times_s: Floats, voted: list[tuple[float, Floats]]) -> Floats:
    """(N,) m/s where the votes of half a second before and after are densest; nan where there are too few.

    Points that slide along a line of the road stay behind and agree on nothing, so the mode is taken, not the median.
    """
    result = np.full(len(times_s), np.nan)
    if not voted:
        return result
    ballots = np.concatenate([np.column_stack([np.full(len(part), time), part]) for time, part in voted])
    ballots = ballots[(ballots[:, 1] > LEAST_SPEED_MPS) & (ballots[:, 1] < MOST_SPEED_MPS)]
    for k, time in enumerate(times_s):
        first, last = np.searchsorted(ballots[:, 0], [time - 0.5 * WINDOW_S, time + 0.5 * WINDOW_S])
        if last - first >= LEAST_VOTES:
            result[k] = _mode(ballots[first:last, 1], ballots[first:last, 2])
    return result


def _mode(speed_mps: Floats, weight: Floats) -> float:
    place = np.log(speed_mps)
    density = np.exp(-0.5 * ((GRID[:, None] - place) / WIDTH) ** 2) @ weight
    centre = GRID[np.argmax(density)]
    near = weight * np.exp(-0.5 * ((centre - place) / WIDTH) ** 2)
    return float(np.exp(np.sum(near * place) / np.sum(near)))
