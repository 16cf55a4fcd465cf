"""A smooth line close to a map's points: over gaps, corners and the noise of many short geometries.

The line's curvature is linear between knots. The knots' curvatures minimise the squared distances beside the points
plus h^6 times the integral of the squared change of curvature, by Gauss and Newton's method. Waves shorter than about
h are smoothed out, while an arc of any length stays an arc.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.geometry import unwrapped
from vpf_sim.scenarios.opendrive.clothoid_line import ALONG_M, TOLERANCE_M, Line
from vpf_sim.scenarios.opendrive.geometry import Complexes
from vpf_sim.scenarios.opendrive.spans import Element, Piece
from vpf_sim.types import Floats

KNOT_M = 0.75
MOST_KNOTS = 800
STEPS_OF_A_KNOT = 4
ROUNDS = 16
RIDGE = 1e-9
WANTED_M = 0.9 * TOLERANCE_M  # while a point is farther beside the line, far points count more with each round
CLOSE_M = 1e-5  # the change of the line at which the search ends


def smoothed(pieces: Sequence[Piece], wave_m: float) -> Line:
    """The line near the points of the pieces, without waves shorter than about `wave_m`.

    Raises InputError where a gap is wider than any line may be from its sides.
    """
    gaps = [abs(after.points[0] - before.points[-1]) for before, after in pairwise(pieces)]
    if max(gaps, default=0.0) > 2.0 * ALONG_M:
        raise InputError(f"{pieces[0].where}: planView: expected a line that goes on, got a gap of {max(gaps):.2f} m")
    points = np.concatenate([piece.points for piece in pieces])
    along = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(points)))])
    knots = np.linspace(0.0, along[-1], 2 + min(int(along[-1] / KNOT_M), MOST_KNOTS))
    start = complex(points[0])
    heading, curvature = _first_guess(points, along, knots, wave_m)
    weights = np.sqrt(np.gradient(along) + 1e-9)
    jumps = wave_m**3 * np.diff(np.eye(len(knots)), axis=0) / np.sqrt(np.diff(knots))[:, None]
    rough = np.hstack([np.zeros((len(jumps), 2)), jumps])
    for _ in range(ROUNDS):
        line = Line(start, heading, _elements(knots, curvature), [along])
        along = np.maximum.accumulate(np.maximum(along + line.apart(along, points).real, 0.0))
        slopes, lateral = _slopes(knots, curvature, along), line.apart(along, points).imag
        if (farthest_m := np.abs(lateral).max()) > WANTED_M:
            weights *= 1.0 + np.abs(lateral) / farthest_m
            weights /= np.sqrt(np.mean(weights**2))
        wanted = np.concatenate([weights * lateral, -jumps @ curvature])
        rows = np.vstack([weights[:, None] * slopes, rough])
        change = np.linalg.solve(rows.T @ rows + RIDGE * np.eye(len(knots) + 2), rows.T @ wanted)
        start += 1j * np.exp(1j * heading) * change[0]
        heading += float(change[1])
        curvature = curvature + change[2:]
        if np.abs(slopes @ change).max() < CLOSE_M:
            break
    ends = np.cumsum([len(piece.points) for piece in pieces])[:-1]
    return Line(start, heading, _elements(knots, curvature), np.split(along, ends))


def _first_guess(points: Complexes, along: Floats, knots: Floats, wave_m: float) -> tuple[float, Floats]:
    """The heading at the start and the curvature at each knot, from chords as long as the waves."""
    half_m = 0.5 * max(wave_m, KNOT_M)
    back, ahead = (np.interp(np.clip(knots + side, 0.0, along[-1]), along, points) for side in (-half_m, half_m))
    headings = unwrapped(np.angle(ahead - back))
    return float(headings[0]), np.gradient(headings, knots)


def _elements(knots: Floats, curvature: Floats) -> tuple[Element, ...]:
    ends = zip(np.diff(knots), curvature[:-1], curvature[1:], strict=True)
    return tuple(Element(float(length), float(first), float(last)) for length, first, last in ends)


def _slopes(knots: Floats, curvature: Floats, along: Floats) -> Floats:
    """(N, 2 + K) lateral displacement of points of the line by its start's place, its heading and the curvatures."""
    fine = np.linspace(0.0, knots[-1], STEPS_OF_A_KNOT * (len(knots) - 1) + 1)
    hats = np.stack([np.interp(fine, knots, one) for one in np.eye(len(knots))], axis=1)
    turns = np.hstack([np.zeros((len(fine), 1)), np.ones((len(fine), 1)), _integral(hats, fine[1])])
    headings = _integral(np.interp(fine, knots, curvature), fine[1])
    moved = _integral(1j * np.exp(1j * headings)[:, None] * turns, fine[1])
    moved[:, 0] = 1j
    index = np.clip((along / fine[1]).astype(int), 0, len(fine) - 2)
    share = (along / fine[1] - index)[:, None]
    there = moved[index] + share * (moved[index + 1] - moved[index])
    return np.asarray((there * np.exp(-1j * np.interp(along, fine, headings))[:, None]).imag)


def _integral(values: Floats, step: float) -> Floats:
    """The running integral by the trapezoidal rule, along the first axis."""
    sums = np.cumsum(0.5 * step * (values[1:] + values[:-1]), axis=0)
    return np.concatenate([np.zeros((1, *values.shape[1:]), values.dtype), sums])
