"""Looking for painted lines in a bird's-eye patch: about predicted places, and from scratch."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.birds_eye import BirdsEye
from vpf_sim.perception.lane_filter import Sightings
from vpf_sim.types import Bools, Camera, Floats, Image

CENTROID_M = 0.15  # about the strongest response, to this far on both sides
HEADINGS_RAD = np.radians(np.arange(-12.0, 12.01, 0.6))
CURVATURES = np.arange(-0.02, 0.0201, 0.00125)
COMB_REACH_M = 26.0  # rows ahead that take part in the first search


@dataclass(frozen=True, slots=True)
class RidgeMap:
    """The ridges of one frame and what counts as one."""

    response: Image  # (rows, columns)
    threshold: float  # grey levels
    visible: Bools  # (rows, columns) in the frame and not hidden by a body


def noise_threshold(response: Image, least: float) -> float:
    """Grey levels that the grain of the road seldom reaches; lines are too few to move the percentile."""
    return max(least, 2.0 * float(np.percentile(response[::3, ::3], 90)))


def sight(
    ridges: RidgeMap, view: BirdsEye, expected_m: Floats, wanted: Bools, offsets_m: Floats, reach_m: float, variance: Floats
) -> Sightings:
    """The strongest ridge within `reach_m` of each expected place (L, R), as its centre of mass."""
    columns = (expected_m - view.right_m[0]) / view.column_m
    reach = round(reach_m / view.column_m)
    window = np.arange(-reach, reach + 1)
    last = ridges.response.shape[1] - 1
    inside = wanted & (columns >= reach) & (columns <= last - reach)
    centre = np.where(inside, np.rint(np.where(inside, columns, 0.0)), reach).astype(np.intp)
    row = np.arange(len(view.forward_m))[None, :]
    index = centre[..., None] + window
    response = ridges.response[row[..., None], index].astype(np.float64)
    peak = np.argmax(response, axis=-1)
    height = np.take_along_axis(response, peak[..., None], axis=-1)[..., 0]
    near = np.abs(window - window[peak][..., None]) <= round(CENTROID_M / view.column_m)
    mass = np.where(near, response, 0.0)
    total = np.sum(mass, axis=-1)
    place = centre + np.sum(mass * window, axis=-1) / np.maximum(total, 1e-9)
    visible = ridges.visible[row, np.clip(np.rint(place), 0, last).astype(np.intp)]
    seen = inside & visible & (height > ridges.threshold)
    return Sightings(
        offsets_m=offsets_m,
        forward_m=view.forward_m,
        right_m=view.right_m[0] + place * view.column_m,
        variance_m2=np.broadcast_to(variance, seen.shape),
        seen=seen,
    )


def sighting_variance(camera: Camera, forward_m: Floats, sigma_m: float, sigma_px: float) -> Floats:
    """(R,) m^2 of one sighting at each row."""
    depth = forward_m - camera.forward_m
    variance: Floats = sigma_m**2 + (sigma_px * depth / camera.fx_px) ** 2
    return variance


def comb(ridges: RidgeMap, view: BirdsEye, lane_width_m: float) -> list[tuple[float, Floats]]:
    """Roads that explain the ridges of one frame, best first: (score, (y modulo a lane, heading, curvature)).

    Each heading and curvature straightens the patch; parallel lines then stand out in the sum over its rows, and lines
    a lane apart in the sum of that sum taken modulo the lane's width (0: only grain .. 1: a line in every row). The
    place y is that of the pose right of any one line.
    """
    rows = np.flatnonzero(view.forward_m < COMB_REACH_M)
    clipped = np.where(ridges.visible, np.minimum(ridges.response, 2.0 * ridges.threshold), 0.0)[rows]
    clipped = np.where(clipped > ridges.threshold, clipped, 0.0).astype(np.float32) / np.float32(2.0 * ridges.threshold)
    coarse = np.maximum(clipped[:, 0:-1:2], clipped[:, 1::2])
    column_m = 2.0 * view.column_m
    origin_m = view.right_m[0] + 0.5 * view.column_m
    period = lane_width_m / column_m
    forward = view.forward_m[rows]
    heading, curvature = (grid.ravel() for grid in np.meshgrid(HEADINGS_RAD, CURVATURES, indexing="ij"))
    shift_m = np.tan(heading)[:, None] * forward + 0.5 * curvature[:, None] * forward**2
    columns = np.arange(coarse.shape[1])
    margin = coarse.shape[1]
    padded = np.pad(coarse, ((0, 0), (margin, margin)))
    start = margin + np.clip(np.rint(shift_m / column_m), -margin, margin).astype(np.intp)  # (H, R)
    straight = np.zeros((len(heading), len(columns)), np.float32)
    for row in range(len(rows)):
        windows = np.lib.stride_tricks.sliding_window_view(padded[row], len(columns))
        straight += windows[start[:, row]]
    straight /= len(rows)
    bins = round(period)
    phase = np.rint(np.mod(columns, period)).astype(np.intp) % bins
    teeth = np.zeros((len(heading), bins), np.float32)
    for tooth in range(bins):
        teeth[:, tooth] = straight[:, phase == tooth].sum(axis=1)
    sharp = teeth - np.median(teeth, axis=1, keepdims=True)
    best = np.argmax(sharp, axis=1)
    score = sharp[np.arange(len(best)), best]
    order = np.argsort(-score)[:6]
    return [
        (float(score[i]), np.array([-(origin_m + best[i] * column_m) * np.cos(heading[i]), heading[i], curvature[i]]))
        for i in order
    ]
