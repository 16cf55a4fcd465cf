"""Estimates the height of a camera by the width of the lanes.

On a flat road all distances scale with the assumed height, the lane width too. So heights are tried until lines one
lane width apart explain most of the road markings.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.birds_eye import BirdsEye, ridge
from vpf_sim.perception.road.markings import RidgeMap, comb, noise_threshold
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.image_files import Frame
from vpf_sim.types import Camera, Floats, Image

HEIGHTS_M = 0.9 * 1.04 ** np.arange(24)  # up to 2.2
FRAMES, APART_S = 12, 1.0  # frames that are used, and the time between them
LEAST_SCORE = 0.7  # share of rows with a line; two lines in each row are 2
MOST_DOUBLED = 0.93  # share of the score at twice the lane width: above this no line lies between
LEAST_PROMINENCE = 1.45  # ratio of best to median score: kerbs and shadows have less


def height_m(
    frames: Iterator[Frame],
    camera: Camera,
    times_s: Floats,
    config: RoadEdgeConfig,
    fixed: FixedStructure | None = None,
) -> float | None:
    """m above the road by the lanes in the frames, None if ambiguous; the camera's own height is ignored."""
    images = [image if fixed is None else fixed.filled(image) for image in _spread(frames, times_s)]
    if not images:
        return None
    width_m = config.lane_width_m
    scores = np.array(
        [_score(images, replace(camera, height_m=float(height)), config, width_m) for height in HEIGHTS_M]
    )
    best = int(np.argmax(scores))
    if scores[best] < max(LEAST_SCORE, LEAST_PROMINENCE * float(np.median(scores))):
        return None
    at_best = replace(camera, height_m=float(HEIGHTS_M[best]))
    if _score(images, at_best, config, 2.0 * width_m) > MOST_DOUBLED * scores[best]:
        return None
    return float(np.round(_peak(scores, best), 3))


def _spread(frames: Iterator[Frame], times_s: Floats) -> list[Image]:
    """Grey images spread over the drive."""
    apart = min(APART_S, float(times_s[-1] - times_s[0]) / FRAMES)
    taken: list[Image] = []
    due = float(times_s[0])
    for frame in frames:
        if frame.image is not None and times_s[frame.index] >= due:
            taken.append(grey(frame.image))
            due = float(times_s[frame.index]) + apart
        if len(taken) == FRAMES:
            break
    return taken


def _score(images: Sequence[Image], camera: Camera, config: RoadEdgeConfig, width_m: float) -> float:
    """Mean share of rows with a line where lanes of this width have one."""
    view = BirdsEye(camera, config.patch)
    found = []
    for image in images:
        response = ridge(view.warp(image), round(config.ridge_reach_m / config.column_m))
        lines = RidgeMap(
            view, response, noise_threshold(response, config.least_contrast), view.visible, config.centroid_m
        )
        found.append(comb(lines, np.array([width_m]), width_m, config.comb).score)
    return float(np.mean(found))


def _peak(scores: Floats, best: int) -> float:
    """Height at the top of the parabola through the best score and its neighbours."""
    if not 0 < best < len(scores) - 1:
        return float(HEIGHTS_M[best])
    before, middle, after = scores[best - 1 : best + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * middle + after)
    return float(HEIGHTS_M[best] * (HEIGHTS_M[1] / HEIGHTS_M[0]) ** shift)
