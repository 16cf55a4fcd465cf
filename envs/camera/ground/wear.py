"""Wear of the asphalt: polished tracks, repaired patches, cracks, skid marks, manhole covers.

Every mark is a ribbon between two sides of `STATIONS` points, at stations s and lateral positions right of the lane's
middle.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.layout import LaneShape, Line, interpolated
from vpf_sim.types import Floats

STATIONS = 7
SHARES = np.linspace(0.0, 1.0, STATIONS)
WEAR_RANGE_M = 28.0  # not shown on levels that begin beyond
FLAKE_SPACING_M = 0.5  # mean spacing of missing pieces of paint
FLAKE_RANGE_M = 20.0

# Bands along every lane, polished by tyres or stained by oil: lateral position, half width, tone in palette values.
TRACKS = (
    (-0.85, 0.32, 2),
    (0.85, 0.32, 2),
    (0.0, 0.5, -2),
    (0.0, 0.28, -4),
)

Marks = tuple[Floats, Floats, NDArray[np.int64]]  # (n, 2 STATIONS) stations m, lateral positions m, (n,) tones


def coarse_wear(shapes: list[LaneShape], rng: np.random.Generator) -> tuple[Floats, NDArray[np.int64]]:
    """(n, 2 STATIONS, 2) patches and skid marks, and (n,) their tones relative to the asphalt."""
    return _placed(shapes, (_patches, _skids), rng)


def fine_wear(shapes: list[LaneShape], rng: np.random.Generator) -> tuple[Floats, NDArray[np.int64]]:
    """(n, 2 STATIONS, 2) cracks and manhole covers, and (n,) their tones relative to the asphalt."""
    return _placed(shapes, (_cracks_along, _cracks_across, _manhole_covers), rng)


def tracks(shapes: list[LaneShape]) -> list[tuple[Floats, Floats, int]]:
    """Left side (M, 2), right side and tone of each polished band."""
    return [
        (shape.at(middle - half), shape.at(middle + half), tone)
        for middle, half, tone in TRACKS
        for shape in shapes
        if shape.width_m > 2.6
    ]


def flakes(lines: list[Line], rng: np.random.Generator) -> Floats:
    """(n, 4, 2) missing pieces of the markings: small irregular diamonds."""
    result = [np.empty((0, 4, 2))]
    for line in lines:
        first, last = float(line.s_m[0]), float(line.s_m[-1])
        s = rng.uniform(first, last, int((last - first) / FLAKE_SPACING_M))
        order = np.argsort(s)  # interpolation of sorted stations is several times as fast
        places = (interpolated(s[order] + shift, line.s_m, line.points_m) for shift in (0.0, 0.05))
        middle, ahead = (place[np.argsort(order)] for place in places)
        along = ahead - middle
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        middle = middle + rng.uniform(-0.08, 0.08, (len(s), 1)) * across
        askew = rng.uniform(0.5, 1.5, (len(s), 4, 1))[..., 0]
        long, wide = rng.uniform(0.02, 0.10, len(s)), rng.uniform(0.008, 0.022, len(s))
        polygons = np.empty((len(s), 4, 2))
        for i, (ahead_share, lateral_share) in enumerate(((-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0))):
            a, b = ahead_share * askew[:, i] * long, lateral_share * askew[:, i] * wide
            for axis in range(2):
                polygons[:, i, axis] = middle[:, axis] + a * along[:, axis] + b * across[:, axis]
        result.append(polygons)
    return np.concatenate(result)


def _placed(
    shapes: list[LaneShape],
    kinds: tuple[Callable[[LaneShape, np.random.Generator], Marks], ...],
    rng: np.random.Generator,
) -> tuple[Floats, NDArray[np.int64]]:
    polygons, tones = [], []
    for shape in shapes:
        for kind in kinds:
            s, lateral, tone = kind(shape, rng)
            polygons.append(shape.points(s, lateral))
            tones.append(tone)
    return np.concatenate(polygons), np.concatenate(tones)


def _starts(shape: LaneShape, spacing_m: float, rng: np.random.Generator) -> Floats:
    """(n,) random stations of marks, `spacing_m` apart on average."""
    first, last = float(shape.s_m[0]), float(shape.s_m[-1])
    return np.asarray(rng.uniform(first, last, rng.poisson((last - first) / spacing_m)))


def _ribbons(s: Floats, lateral: Floats, half_s: Floats | float, half_lateral: Floats | float, tone: Floats) -> Marks:
    """Marks along middles (n, STATIONS) with half widths in s and lateral: up one side, down the other."""
    stations = np.concatenate([s - half_s, (s + half_s)[:, ::-1]], axis=1)
    places = np.concatenate([lateral - half_lateral, (lateral + half_lateral)[:, ::-1]], axis=1)
    return stations, places, np.rint(tone).astype(np.int64)


def _patches(shape: LaneShape, rng: np.random.Generator) -> Marks:
    """Rectangles of other asphalt with a seam of tar."""
    start = _starts(shape, 60.0, rng)[:, None]
    long, half = rng.uniform(0.8, 6.0, start.shape), rng.uniform(0.3, 0.45 * shape.width_m, start.shape)
    middle = rng.uniform(-1.0, 1.0, start.shape) * np.maximum(0.5 * shape.width_m - 0.15 - half, 0.0)
    tone = rng.choice([-9.0, -7.0, -5.0, 5.0], len(start))
    seam = _ribbons(start - 0.04 + (long + 0.08) * SHARES, middle + 0 * SHARES, 0.0, half + 0.04, tone - 9.0)
    inside = _ribbons(start + long * SHARES, middle + 0 * SHARES, 0.0, half, tone)
    return _concatenated(seam, inside)


def _skids(shape: LaneShape, rng: np.random.Generator) -> Marks:
    """Two parallel tyre marks, faint at both ends, with a lateral drift."""
    start = _starts(shape, 140.0, rng)[:, None]
    long, drift = rng.uniform(5.0, 20.0, start.shape), rng.normal(0.0, 0.6, start.shape)
    middle, half = rng.uniform(-0.3, 0.3, start.shape), rng.uniform(0.07, 0.1, start.shape)
    tone = rng.uniform(-15.0, -6.0, len(start))
    marks = []
    for side in (-0.75, 0.75):
        for first, last, share in ((0.0, 0.25, 0.5), (0.25, 0.8, 1.0), (0.8, 1.0, 0.5)):
            along = first + (last - first) * SHARES
            marks.append(_ribbons(start + long * along, middle + side + drift * along**2, 0.0, half, share * tone))
    return _concatenated(*marks)


def _cracks_along(shape: LaneShape, rng: np.random.Generator) -> Marks:
    start = _starts(shape, 30.0, rng)[:, None]
    long = rng.uniform(1.5, 9.0, start.shape)
    wander = np.cumsum(rng.normal(0.0, 0.06, (len(start), STATIONS)), axis=1)
    middle = rng.uniform(-0.5, 0.5, start.shape) * shape.width_m
    half = rng.uniform(0.008, 0.03, start.shape) * np.sin(np.pi * (0.1 + 0.8 * SHARES))
    return _ribbons(start + long * SHARES, middle + wander, 0.0, half, rng.uniform(-22.0, -12.0, len(start)))


def _cracks_across(shape: LaneShape, rng: np.random.Generator) -> Marks:
    start = _starts(shape, 25.0, rng)[:, None]
    ends = np.sort(rng.uniform(-0.6, 0.6, (len(start), 2)), axis=1) * shape.width_m
    wander = np.cumsum(rng.normal(0.0, 0.08, (len(start), STATIONS)), axis=1)
    lateral = np.clip(ends[:, :1] + np.diff(ends, axis=1) * SHARES, -0.5 * shape.width_m, 0.5 * shape.width_m)
    half = rng.uniform(0.01, 0.04, start.shape)
    return _ribbons(start + wander, lateral, half, 0.0, rng.uniform(-20.0, -10.0, len(start)))


def _manhole_covers(shape: LaneShape, rng: np.random.Generator) -> Marks:
    """Round manhole covers in a dark frame."""
    start = _starts(shape, 120.0, rng)[:, None]
    middle = rng.uniform(-0.8, 0.8, start.shape)
    marks = []
    for radius, tone in ((0.36, -18.0), (0.31, -8.0)):
        s, half = start - radius * np.cos(np.pi * SHARES), radius * np.sin(np.pi * SHARES)
        marks.append(_ribbons(s, middle + 0 * SHARES, 0.0, half, np.full(len(start), tone)))
    return _concatenated(*marks)


def _concatenated(*marks: Marks) -> Marks:
    stations, places, tones = zip(*marks, strict=True)
    return np.concatenate(stations), np.concatenate(places), np.concatenate(tones)
