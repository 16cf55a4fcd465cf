"""Looking for painted lines in a bird's-eye patch: about predicted places, and from scratch."""

from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.road_settings import CombConfig
from vpf_sim.types import Bools, Floats, Image, Integers, Singles


@dataclass(frozen=True, slots=True)
class RidgeMap:
    """The ridges of one frame and what counts as one."""

    view: BirdsEye
    response: Image  # (rows, columns)
    threshold: float  # grey levels
    visible: Bools  # (rows, columns) in the frame and not hidden by an obstacle
    centroid_m: float  # about the strongest response, whose centroid is the line


@dataclass(frozen=True, slots=True)
class RoadFeatures:
    """What one frame shows of the road."""

    ridges: RidgeMap  # painted lines
    steps: RidgeMap | None  # of colour, as at verges; None: they are not searched


class CombedRoad(NamedTuple):
    """The road that explains most of a frame, by lines a lane's width apart."""

    score: float  # lines that it meets, less what is unlikely: 1 is seen in every row, as bright as can be; steps count
    painted: float  # the same without the steps
    y: float  # m, the pose's place right of any one line
    heading: float  # rad
    curvature: float  # 1/m
    width: float  # m, of a lane


def noise_threshold(response: Image, least: float) -> float:
    """Grey levels that the grain of the road seldom reaches; lines are too few to move the quantile."""
    return max(least, 2.0 * quantile(response[::3, ::3], 0.9))


def sight(ridges: RidgeMap, expected_m: Floats, wanted: Bools, reach_m: float) -> tuple[Floats, Bools]:
    """(L, R) m, centre of mass of the strongest ridge within `reach_m` of each expected place, and whether one is."""
    view = ridges.view
    columns = (expected_m - view.right_m[0]) / view.column_m
    reach = round(reach_m / view.column_m)
    window = np.arange(-reach, reach + 1)
    last = ridges.response.shape[1] - 1
    inside = wanted & (columns >= reach) & (columns <= last - reach)
    centre = np.where(inside, np.rint(np.where(inside, columns, 0.0)), reach).astype(np.intp)
    row = np.arange(len(view.forward_m))[None, :]
    index = (row * ridges.response.shape[1] + centre)[..., None] + window
    response = ridges.response.ravel().take(index)
    peak, height = response.argmax(axis=-1), response.max(axis=-1)
    near = np.abs(window[:, None] - window) <= round(ridges.centroid_m / view.column_m)  # each column to the others
    mass = response * near.take(peak, axis=0)
    # Whole numbers, which floats hold: the products are exact in any order.
    sums = mass.astype(np.float32) @ np.stack([np.ones(len(window)), window], axis=1).astype(np.float32)
    total, moment = sums[..., 0].astype(np.float64), sums[..., 1].astype(np.float64)
    place = centre + moment / np.maximum(total, 1e-9)
    visible = ridges.visible[row, np.clip(np.rint(place), 0, last).astype(np.intp)]
    return view.right_m[0] + place * view.column_m, inside & visible & (height > ridges.threshold)


def comb(
    ridges: RidgeMap,
    widths_m: Floats,
    likely_m: float,
    config: CombConfig,
    likely_rad: float = 0.0,
    unlikely_per_m: float = 0.0,
    steps: RidgeMap | None = None,
    beside_m: float = 0.0,
) -> CombedRoad:
    """The road that explains most ridges of one frame.

    Each heading and curvature straightens the patch; parallel lines then stand out in the mean over its rows, and lines
    a lane apart in that taken modulo the lane's width. Of widths and headings, the likely one is taken unless another
    explains more, and the straight road: a single line fits any width, and mirror images lie askew. The clearest of the
    `steps` on either side, at least `beside_m` from the pose, counts as a line.
    """
    view = ridges.view
    rows = np.flatnonzero(view.forward_m < config.reach_m)
    fine = bright(ridges, rows)
    coarse = np.maximum(fine[:, 0:-1:2], fine[:, 1::2])
    column_m = 2.0 * view.column_m
    heading, curvature = (
        grid.ravel() for grid in np.meshgrid(config.headings_rad, config.curvatures_per_m, indexing="ij")
    )
    straight = _straightened(coarse, view.forward_m[rows], column_m, heading, curvature)
    unlikely = config.unlikely_per_rad * np.abs(heading - likely_rad) + config.unlikely_m * np.abs(curvature)
    beside = np.zeros(len(heading))
    if steps is not None:
        along = _straightened(bright(steps, rows), view.forward_m[rows], steps.view.column_m, heading, curvature)
        sharp = along - np.median(along, axis=1, keepdims=True)
        beside = np.sum(
            [sharp[:, side_m > beside_m].max(axis=1) for side_m in (-steps.view.right_m, steps.view.right_m)], axis=0
        )
    roads = []
    for width_m in widths_m.tolist():
        score, i, tooth = _best_tooth(straight, width_m / column_m, unlikely - beside)
        score -= unlikely_per_m * abs(width_m - likely_m)
        right_m = view.right_m[0] + 0.5 * view.column_m + tooth * column_m
        place_m = -right_m * float(np.cos(heading[i]))
        roads.append(
            CombedRoad(score, score - float(beside[i]), place_m, float(heading[i]), float(curvature[i]), width_m)
        )
    return max(roads, key=attrgetter("score"))


def bright(ridges: RidgeMap, rows: Integers) -> Singles:
    """(rows, columns) how bright the ridges are in these rows of the patch: 0, or half .. 1 as bright as can be."""
    share = np.minimum(ridges.response[rows], 2.0 * ridges.threshold) / (2.0 * ridges.threshold)
    return np.where(ridges.visible[rows] & (share > 0.5), share, 0.0).astype(np.float32)


def _best_tooth(straight: Singles, period: float, unlikely: Floats) -> tuple[float, int, int]:
    """The comb, its teeth `period` columns apart, that meets most lines: score, row of `straight`, column.

    Each row (H,) must meet so much more as it is `unlikely`.
    """
    teeth = round(period)
    phase = np.rint(np.mod(np.arange(straight.shape[1]), period)).astype(np.intp) % teeth
    lines = straight @ np.eye(teeth, dtype=np.float32)[phase]
    sharp = lines - np.median(lines, axis=1, keepdims=True) - unlikely[:, None]
    i, tooth = np.unravel_index(np.argmax(sharp), sharp.shape)
    return float(sharp[i, tooth]), int(i), int(tooth)


def _straightened(
    bright: Singles,
    forward_m: Floats,
    column_m: float,
    heading_rad: Floats,
    curvature_per_m: Floats,
) -> Singles:
    """(H, columns) mean over the rows, each shifted back by what H headings and curvatures move a line there."""
    shift_m = np.tan(heading_rad)[:, None] * forward_m + 0.5 * curvature_per_m[:, None] * forward_m**2
    width = bright.shape[1]
    start = width + np.clip(np.rint(shift_m / column_m), -width, width).astype(np.intp)  # (H, R)
    padded = np.pad(bright, ((0, 0), (width, width)))
    total = np.zeros((len(heading_rad), width), np.float32)
    for row in range(len(bright)):
        total += np.lib.stride_tricks.sliding_window_view(padded[row], width)[start[:, row]]
    return total / np.float32(len(bright))
