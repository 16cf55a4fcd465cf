"""What years of traffic leave on the asphalt: repaired patches, cracks filled with tar."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.layout import LaneShape, Line, interpolated
from vpf_sim.types import Floats

SPACING_M = 22.0  # of faults along each lane, on average
REPAIR_RANGE_M = 60.0  # nothing of this is drawn farther ahead
FLAKE_SPACING_M = 0.5  # of missing pieces along each line, on average
FLAKE_RANGE_M = 20.0
PATCH, ACROSS = 0.35, 0.75  # kinds of fault: below the first a patch, below the second a crack across, else along


def wear(shapes: list[LaneShape], asphalt: int, rng: np.random.Generator) -> tuple[Floats, NDArray[np.int64]]:
    """(n, 6, 2) polygons on the lanes, and their values of the palette."""
    lanes = [_lane_wear(shape, asphalt, rng) for shape in shapes]
    return np.concatenate([polygons for polygons, _ in lanes]), np.concatenate([values for _, values in lanes])


def flakes(lines: list[Line], rng: np.random.Generator) -> Floats:
    """(n, 4, 2) pieces that are missing from the markings: small diamonds, askew."""
    result = [np.empty((0, 4, 2))]
    for line in lines:
        first, last = float(line.s_m[0]), float(line.s_m[-1])
        s = rng.uniform(first, last, int((last - first) / FLAKE_SPACING_M))
        middle, ahead = (interpolated(s + shift, line.s_m, line.points_m) for shift in (0.0, 0.05))
        along = ahead - middle
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        middle = middle + rng.uniform(-0.08, 0.08, (len(s), 1)) * across
        corners = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]]) * rng.uniform(0.5, 1.5, (len(s), 4, 1))
        size = np.stack([rng.uniform(0.02, 0.10, len(s)), rng.uniform(0.008, 0.022, len(s))], axis=1)
        place = corners * size[:, None]
        result.append(middle[:, None] + place[..., :1] * along[:, None] + place[..., 1:] * across[:, None])
    return np.concatenate(result)


def _lane_wear(shape: LaneShape, asphalt: int, rng: np.random.Generator) -> tuple[Floats, NDArray[np.int64]]:
    first, last = float(shape.s_m[0]), float(shape.s_m[-1])
    start = np.sort(rng.uniform(first, last, int((last - first) / SPACING_M) + 1))
    count, half = len(start), 0.5 * shape.width_m
    kind = rng.random(count)
    patch, across = kind < PATCH, (kind >= PATCH) & (kind < ACROSS)
    long = np.select(
        [patch, across], [rng.uniform(1.0, 5.0, count), rng.uniform(0.04, 0.07, count)], rng.uniform(2, 9, count)
    )
    middle, wide = rng.uniform(-0.6, 0.6, count), rng.uniform(0.35, 0.95, count)
    ends = np.sort(rng.uniform(-half, half, (count, 2)), axis=1)
    left = np.select([patch, across], [middle - wide, ends[:, 0]], ends[:, 0])
    right = np.select([patch, across], [middle + wide, ends[:, 1]], ends[:, 0] + 0.05)
    skew = np.where(across, rng.uniform(-0.8, 0.8, count), 0.0)
    tone = np.select([patch, across], [rng.choice([-9, -7, -5, 5], count), np.full(count, -16)], -14)
    s = start[:, None] + long[:, None] * np.array([0.0, 0.5, 1.0])
    sides = [_along(shape, s, left), _along(shape, s + skew[:, None], right)]
    return np.concatenate([sides[0], sides[1][:, ::-1]], axis=1), asphalt + tone


def _along(shape: LaneShape, s: Floats, lateral: Floats) -> Floats:
    """(n, 3, 2) points at stations (n, 3), n lateral places to the right of the lane's middle."""
    left, right = (interpolated(s, shape.s_m, edge) for edge in (shape.left_m, shape.right_m))
    share = 0.5 + lateral / shape.width_m
    return left + share[:, None, None] * (right - left)
