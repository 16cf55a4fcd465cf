"""Symbols painted on the road: arrows and words in the lanes, stop lines, zebra crossings. The seed places them."""

from collections.abc import Iterator, Sequence

import numpy as np

from vpf_sim.envs.camera.ground.words import WORDS, word
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.types import Floats

SYMBOLS_EVERY_M, CROSSINGS_EVERY_M = 45.0, 140.0  # mean distances
BUS_EVERY_M, CLEAR_OF_CROSSING_M = 40.0, 6.0
WORD_SHARE = 0.3  # of the symbols, the rest are arrows
ARROW_M = 5.0  # length
STOP_LINE_M, BEFORE_CROSSING_M = 0.5, 1.5  # width of a stop line, and its distance from the crossing
BAR_M, BARS_EVERY_M, CROSSING_M = 0.5, 1.0, 3.0  # bars of a zebra crossing: width, spacing, length along the road

# Convex parts of an arrow as (ahead, right) in m, from its foot: shaft, and head or heads.
SHAFT = [(0.0, -0.08), (0.0, 0.08), (3.4, 0.08), (3.4, -0.08)]
STRAIGHT = [(3.2, -0.4), (3.2, 0.4), (ARROW_M, 0.0), (ARROW_M, 0.0)]
BENT = [(0.0, -0.08), (0.0, 0.08), (2.7, 0.08), (2.5, -0.08)]
TURNING = [(2.6, 0.9), (3.9, 0.9), (3.25, 1.7), (3.25, 1.7)]
CURVE = [(2.3, 0.0), (3.1, 0.95), (3.4, 0.95), (2.7, 0.0)]
ARROWS = ((SHAFT, STRAIGHT), (BENT, CURVE, TURNING), (SHAFT, STRAIGHT, CURVE, TURNING))


def road_marks(shapes: list[LaneShape], rng: np.random.Generator, bus_lanes: Sequence[LaneShape] = ()) -> Floats:
    """(n, 4, 2) m, polygons of all symbols; bus lanes have none but BUS."""
    first, last = (max(s.s_m[0] for s in shapes), min(s.s_m[-1] for s in shapes))
    places = _places(first, last, CROSSINGS_EVERY_M, rng)
    polygons = []
    for lane in shapes:
        shape = lane.as_driven
        starts = _places(first, last, SYMBOLS_EVERY_M, rng)
        crossings = places
        if lane.oncoming:
            starts, crossings = [-s for s in starts], [-s - CROSSING_M for s in places]
        symbols = [part for s in starts for part in _symbol(s, rng)]
        if any(lane is one for one in bus_lanes):
            symbols = list(_bus_words(shape, crossings))
        bars = [part for s in crossings for part in _crossing(shape, s)]
        polygons += [shape.points(*np.array(part).T) for part in (*symbols, *bars)]
    return np.array(polygons).reshape(-1, 4, 2)


def bus_words(shapes: Sequence[LaneShape]) -> Floats:
    """(n, 4, 2) m, polygons of BUS along lanes without other symbols."""
    parts = [shape.points(*np.array(part).T) for shape in shapes for part in _bus_words(shape, [])]
    return np.array(parts).reshape(-1, 4, 2)


def _bus_words(shape: LaneShape, crossings: list[float]) -> Iterator[list[tuple[float, float]]]:
    """The parts of BUS along a lane, as (s, lateral) m, but not on crossings and their stop lines."""
    for start in np.arange(shape.s_m[0], shape.s_m[-1], BUS_EVERY_M).tolist():
        if all(abs(start - s) > CLEAR_OF_CROSSING_M for s in crossings):
            yield from ([(start + ahead, right) for ahead, right in part] for part in word("BUS"))


def _places(first: float, last: float, every_m: float, rng: np.random.Generator) -> list[float]:
    return sorted(rng.uniform(first, last, rng.poisson((last - first) / every_m)).tolist())


def _symbol(s: float, rng: np.random.Generator) -> Iterator[list[tuple[float, float]]]:
    """The parts of a random word or arrow as (s, lateral) m."""
    if rng.random() < WORD_SHARE:
        text = WORDS[int(rng.integers(len(WORDS)))]
        yield from ([(s + ahead, right) for ahead, right in part] for part in word(text))
    else:
        yield from _arrow(s, rng)


def _arrow(s: float, rng: np.random.Generator) -> Iterator[list[tuple[float, float]]]:
    """The parts of a random arrow as (s, lateral) m; turning ones point to either side."""
    side = 1.0 if rng.random() < 0.5 else -1.0
    for part in ARROWS[int(rng.integers(len(ARROWS)))]:
        yield [(s + ahead, side * right) for ahead, right in part]


def _crossing(shape: LaneShape, s: float) -> Iterator[list[tuple[float, float]]]:
    """A lane's bars of a zebra crossing, and its stop line."""
    half = 0.5 * shape.width_m
    for left in np.arange(-half + 0.25, half - BAR_M, BARS_EVERY_M).tolist():
        yield [(s, left), (s, left + BAR_M), (s + CROSSING_M, left + BAR_M), (s + CROSSING_M, left)]
    line = s - BEFORE_CROSSING_M - STOP_LINE_M
    yield [(line, -half), (line, half), (line + STOP_LINE_M, half), (line + STOP_LINE_M, -half)]
