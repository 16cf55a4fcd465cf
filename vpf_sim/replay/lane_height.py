"""How high a camera hangs of which nobody told: as high as makes the lanes of the road as wide as the driver's are.

On a flat road seen from a height that is taken too large by a factor, all distances are too large by it, the width of
the lanes among them. So the height is tried at which lines a lane's width apart explain most of what stands out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.birds_eye import BirdsEye, ridge
from vpf_sim.perception.road.edge_tracker import RIDGE_REACH_M, RoadEdgeConfig
from vpf_sim.perception.road.markings import RidgeMap, comb, noise_threshold
from vpf_sim.replay.recording import Frame
from vpf_sim.types import Camera, Floats, Image

HEIGHTS_M = 0.9 * 1.04 ** np.arange(24)  # up to 2.2
LOOKS, APART_S = 12, 1.0
LEAST_SCORE = 0.7  # share of the rows that have a line; two lines in each row are 2
MOST_DOUBLED = (
    0.93  # of the score, that lanes twice as wide have: then no line lies between, and these are no two lanes
)
LEAST_LEAD = 1.45  # of the best height's score over that of the middle one: kerbs and shadows lead by less


def height_m(frames: Iterator[Frame], camera: Camera, times_s: Floats, config: RoadEdgeConfig) -> float | None:
    """m above the road by the lanes in the frames, or None where they tell no height apart; its own is not believed."""
    looks = _spread(frames, times_s)
    if not looks:
        return None
    width_m = config.lane_width_m
    scores = np.array([_score(looks, replace(camera, height_m=float(height)), config, width_m) for height in HEIGHTS_M])
    best = int(np.argmax(scores))
    if scores[best] < max(LEAST_SCORE, LEAST_LEAD * float(np.median(scores))):
        return None
    at_best = replace(camera, height_m=float(HEIGHTS_M[best]))
    if _score(looks, at_best, config, 2.0 * width_m) > MOST_DOUBLED * scores[best]:
        return None
    return float(np.round(_peak(scores, best), 3))


def _spread(frames: Iterator[Frame], times_s: Floats) -> list[Image]:
    """Grey pictures a while apart, or all over a drive that is short."""
    apart = min(APART_S, float(times_s[-1] - times_s[0]) / LOOKS)
    taken: list[Image] = []
    due = float(times_s[0])
    for frame in frames:
        if frame.image is not None and times_s[frame.index] >= due:
            taken.append(grey(frame.image))
            due = float(times_s[frame.index]) + apart
        if len(taken) == LOOKS:
            break
    return taken


def _score(looks: Sequence[Image], camera: Camera, config: RoadEdgeConfig, width_m: float) -> float:
    """Mean share of the rows that have a line where lanes of a width would have one."""
    view = BirdsEye(camera, config.patch)
    found = []
    for look in looks:
        response = ridge(view.warp(look), round(RIDGE_REACH_M / config.column_m))
        lines = RidgeMap(response, noise_threshold(response, config.least_contrast), view.visible)
        found.append(comb(lines, view, np.array([width_m]), width_m)[0])
    return float(np.mean(found))


def _peak(scores: Floats, best: int) -> float:
    """The height at the top of the parabola through the best score and its neighbours."""
    if not 0 < best < len(scores) - 1:
        return float(HEIGHTS_M[best])
    before, middle, after = scores[best - 1 : best + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * middle + after)
    return float(HEIGHTS_M[best] * (HEIGHTS_M[1] / HEIGHTS_M[0]) ** shift)
