"""Hatched areas: wedges of slanting bars along the outer edges of the road, that no wheel should enter."""

import numpy as np

from vpf_sim.envs.camera.layout import Edge, interpolated, stations_m
from vpf_sim.types import Floats

EVERY_M = 90.0  # from one area to the next
TAPER_M, FULL_M, WIDE_M = 12.0, 10.0, 1.2  # the area widens, keeps its width and narrows; its largest width
BAR_M, BARS_EVERY_M = 0.4, 1.6  # along the road
BORDER_M, PIECE_M = 0.15, 2.0  # width of the line about it, and length of its pieces
LONG_M = 2.0 * TAPER_M + FULL_M
LEFT_M = 2.0  # of a lane, at least


def hatching(edges: list[Edge], rng: np.random.Generator, lane_m: float) -> Floats:
    """(n, 4, 2) m, polygons of the bars and of the line about them, for lanes of a width.

    The seed places the first area. The areas of one edge lie between those of the next.
    """
    wide_m = min(WIDE_M, lane_m - BORDER_M - LEFT_M)
    if wide_m < BORDER_M:
        return np.empty((0, 4, 2))
    first, parts = float(rng.uniform(0.0, EVERY_M)), []
    for number, edge in enumerate(edges):
        along = stations_m(edge.points_m)
        starts = np.arange((first + 0.5 * EVERY_M * number) % EVERY_M, along[-1] - LONG_M, EVERY_M).tolist()
        areas = [part for start in starts for part in (_bars(start, wide_m), _border(start, wide_m))]
        polygons = np.concatenate([np.empty((0, 4, 2)), *areas])
        foot, outward = (interpolated(polygons[..., 0], along, values) for values in (edge.points_m, edge.outward))
        parts.append(foot - polygons[..., 1:] * outward)
    return np.concatenate([np.empty((0, 4, 2)), *parts])


def _bars(start_m: float, wide_m: float) -> Floats:
    """(n, 4, 2) bars at 45 deg as (along the edge, inwards) m."""
    foot = np.arange(start_m, start_m + LONG_M - wide_m - BAR_M, BARS_EVERY_M)
    wide = _width(foot - start_m, wide_m)
    return np.stack(
        [
            _corner(foot, 0.0),
            _corner(foot + BAR_M, 0.0),
            _corner(foot + BAR_M + wide, wide),
            _corner(foot + wide, wide),
        ],
        axis=1,
    )


def _border(start_m: float, wide_m: float) -> Floats:
    """(n, 4, 2) pieces of the line between area and lane as (along the edge, inwards) m."""
    s = np.arange(0.0, LONG_M + 0.5 * PIECE_M, PIECE_M)
    inner, outer = (_corner(start_m + s, _width(s, wide_m) + line_m) for line_m in (BORDER_M, 0.0))
    return np.stack([outer[:-1], outer[1:], inner[1:], inner[:-1]], axis=1)


def _width(s_m: Floats, wide_m: float) -> Floats:
    return np.interp(s_m, [0.0, TAPER_M, TAPER_M + FULL_M, LONG_M], [0.0, wide_m, wide_m, 0.0])


def _corner(along_m: Floats, inwards_m: Floats | float) -> Floats:
    return np.stack(np.broadcast_arrays(along_m, inwards_m), axis=-1)
