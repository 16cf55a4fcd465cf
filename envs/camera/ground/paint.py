"""The flat surfaces of the ground as polygons of palette values: carriageway, shoulders, wear, markings.

They are static, so they are cut into polygons once per road; the rest is computed for polygons near the camera.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.ground import street
from vpf_sim.envs.camera.ground.hatching import hatching
from vpf_sim.envs.camera.ground.road_marks import bus_words, road_marks
from vpf_sim.envs.camera.ground.wear import (
    FLAKE_RANGE_M,
    WEAR_RANGE_M,
    coarse_wear,
    fine_wear,
    flakes,
    tracks,
)
from vpf_sim.envs.camera.layout import Edge, LaneShape, Line, interpolated, lines, outer_edges, stations_m, stripes
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

# Palette values: one ramp from grass over gravel and asphalt to paint, so that blending values blends colours.
GRASS, GRAVEL, ASPHALT, LINE = 45, 98, 150, 222

LINE_WIDTH_M, BROAD_LINE_M = 0.15, 0.3
FADED = 8  # typical loss of a stripe's brightness, palette values
PAVED_SHOULDER_M = 0.5
GRAVEL_SHOULDER_M = 1.3
RAGGED_STEP_M, RAGGED_RANGE_M = 0.7, 28.0
STUD_WIDTH_M, STUD_M = 0.12, 0.24  # of a marker between stripes; its length shows its height, as seen from a car
CUT = 512  # polylines whose cuts are kept
CHUNK, CHUNK_M = 10, 20.0  # most pieces in one polygon, and their length


@dataclass(frozen=True, slots=True)
class Batch:
    """Polygons with one vertex count; those of a strip are consecutive and do not overlap."""

    polygons_m: Floats  # (n, V, 2) world; a strip goes up its left and down its right edge
    values: NDArray[np.int64]  # (n,) palette values
    strips: NDArray[np.int64]  # (n,) index of the strip
    thin: bool  # lines, which need sub-pixel width
    range_m: float = inf  # not shown on levels that begin beyond


def painted(shapes: list[LaneShape], seed: int, look: RoadAppearance) -> list[Batch]:
    """All batches in drawing order."""
    rng, outer = stream(seed, "asphalt"), outer_edges(shapes)
    bus_lanes = street.outermost(shapes, outer, "right") if look.bus_lane else []
    batches = _surfaces(shapes, outer, bus_lanes, rng, look)
    batches += _markings(shapes, outer, bus_lanes, seed, rng, look)
    return [batch for batch in batches if len(batch.values)]


def _surfaces(
    shapes: list[LaneShape],
    outer: list[Edge],
    bus_lanes: list[LaneShape],
    rng: np.random.Generator,
    look: RoadAppearance,
) -> list[Batch]:
    """Shoulders, pavements, lanes with their wear, and tram rails."""
    beside_m = PAVED_SHOULDER_M + GRAVEL_SHOULDER_M
    far_shoulders = [(edge.at(-0.3), edge.at(beside_m), GRAVEL) for edge in outer]
    shoulders = [_ragged(edge, beside_m, 0.28, GRAVEL, rng) for edge in outer]
    kerbs = [strip for edge in outer for strip in street.kerbs(edge)] if look.kerbs else []
    tram_lanes = street.outermost(shapes, outer, "left") if look.tram_rails else []
    paved = [(edge.at(-0.3), edge.at(PAVED_SHOULDER_M), ASPHALT - 4) for edge in outer]
    lanes = [(shape.left_m, shape.right_m, ASPHALT + int(rng.integers(-2, 3))) for shape in shapes]
    lanes += [(shape.left_m, shape.right_m, street.BUS_LANE) for shape in bus_lanes]
    polished = [(left, right, ASPHALT + tone) for left, right, tone in tracks(shapes)]
    coarse, coarse_tones = coarse_wear(shapes, rng)
    fine, fine_tones = fine_wear(shapes, rng)
    return [
        _strips(far_shoulders, thin=False),
        _strips(shoulders, thin=False, range_m=RAGGED_RANGE_M),
        _strips(paved + lanes, thin=False),
        _strips(kerbs, thin=False),
        _strips(polished, thin=False, range_m=WEAR_RANGE_M),
        _separate(coarse, ASPHALT + coarse_tones, thin=False, range_m=WEAR_RANGE_M),
        _separate(fine, ASPHALT + fine_tones, thin=True, range_m=WEAR_RANGE_M),
        _strips([strip for shape in tram_lanes for strip in street.tram_rails(shape)], thin=True),
    ]


def _markings(
    shapes: list[LaneShape],
    outer: list[Edge],
    bus_lanes: list[LaneShape],
    seed: int,
    rng: np.random.Generator,
    look: RoadAppearance,
) -> list[Batch]:
    """Lines, symbols and hatched areas, with what has flaked off the lines."""
    marks = lines(shapes)
    solid = [ribbon for line in marks if not line.striped for ribbon in _solid(line, outer, look)]
    beside_bus = [Line(shape.s_m, shape.left_m, striped=False) for shape in bus_lanes]
    solid += [_ribbon(line, BROAD_LINE_M) for line in beside_bus if not street.is_outer(line.points_m, outer, 0.01)]
    striped = np.concatenate([np.empty((0, 6, 2)), *(_stripe_polygons(line, look) for line in marks if line.striped)])
    paint = LINE - np.minimum(np.abs(np.rint(rng.normal(0.0, FADED, len(striped)))), 3 * FADED).astype(np.int64)
    symbols = road_marks(shapes, stream(seed, "road marks"), bus_lanes) if look.marks else bus_words(bus_lanes)
    if look.hatching:
        symbols = np.concatenate(
            [symbols, hatching(outer, stream(seed, "hatching"), min(shape.width_range_m[0] for shape in shapes))]
        )
    return [
        _strips([(a, b, LINE) for a, b in solid], thin=True),
        _separate(striped, paint, thin=True),
        # each is a strip of its own: parts of a symbol overlap, and fillPoly would cut overlaps out
        Batch(symbols, np.full(len(symbols), LINE - FADED), np.arange(len(symbols)), thin=False),
        _separate(worn := flakes(marks, rng), np.full(len(worn), ASPHALT - 3), thin=False, range_m=FLAKE_RANGE_M),
    ]


def _ragged(
    edge: Edge, wide_m: float, rough_m: float, value: int, rng: np.random.Generator
) -> tuple[Floats, Floats, int]:
    """The two sides of a shoulder with a ragged outer outline."""
    fine = edge.resampled(RAGGED_STEP_M)
    outline = wide_m + rough_m * np.clip(rng.standard_normal(len(fine.points_m)), -2.0, 2.0)
    return fine.at(-0.3), fine.at(outline[:, None]), value


def _solid(line: Line, outer: list[Edge], look: RoadAppearance) -> list[tuple[Floats, Floats]]:
    """One ribbon for a solid line, or two with a gap of the same width."""
    if not look.double_lines or street.is_outer(line.points_m, outer, LINE_WIDTH_M):
        return [_ribbon(line, LINE_WIDTH_M)]
    (left, right), (inner_left, inner_right) = (_ribbon(line, width * LINE_WIDTH_M) for width in (3.0, 1.0))
    return [(left, inner_left), (inner_right, right)]


def _ribbon(line: Line, width_m: float) -> tuple[Floats, Floats]:
    """The two edges of a marking along a polyline."""
    direction = np.gradient(line.points_m, axis=0)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    right = 0.5 * width_m * np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    return line.points_m - right, line.points_m + right


def _stripe_polygons(line: Line, look: RoadAppearance) -> Floats:
    """(n, 6, 2) one polygon per stripe or stud: up its left edge, down its right edge."""
    span = stripes(line, look.stripe_m, look.gap_m)
    painted = _pieces(line, span, LINE_WIDTH_M)
    if not look.studs:
        return painted
    middle = span[:, 1] + 0.5 * look.gap_m
    middle = middle[middle + STUD_M < line.s_m[-1]]
    studs = np.stack([middle - 0.5 * STUD_M, middle + 0.5 * STUD_M], axis=1)
    return np.concatenate([painted, _pieces(line, studs, STUD_WIDTH_M)])


def _pieces(line: Line, span: Floats, width_m: float) -> Floats:
    """(n, 6, 2) one polygon per span (n, 2) of a line."""
    s = np.stack([span[:, 0], span.mean(axis=1), span[:, 1]], axis=1)
    left, right = (interpolated(s, line.s_m, edge) for edge in _ribbon(line, width_m))
    return np.concatenate([left, right[:, ::-1]], axis=1)


def _separate(polygons: Floats, values: NDArray[np.int64], thin: bool, range_m: float = inf) -> Batch:
    """Separate polygons, sorted by value so that equal values are drawn together."""
    order = np.argsort(values, kind="stable")
    return Batch(polygons[order], values[order], values[order], thin, range_m)


def _strips(strips: list[tuple[Floats, Floats, int]], thin: bool, range_m: float = inf) -> Batch:
    """Strips between two edges, cut into polygons of limited length and vertex count."""
    polygons, values, owners = [np.empty((0, 2 * CHUNK + 2, 2))], [], []
    for owner, (left, right, value) in enumerate(strips):
        cuts = _cuts(left.tobytes())
        index = np.minimum(cuts[:-1, None] + np.arange(CHUNK + 1), cuts[1:, None])
        polygons.append(np.concatenate([left[index], right[index[:, ::-1]]], axis=1))
        values += [value] * len(index)
        owners += [owner] * len(index)
    return Batch(np.concatenate(polygons), np.array(values, np.int64), np.array(owners, np.int64), thin, range_m)


@lru_cache(maxsize=CUT)
def _cuts(polyline: bytes) -> NDArray[np.int64]:
    """Indices at which a polyline, the bytes of (M, 2), is cut, including its ends. Cached: roads are drawn again."""
    points = np.frombuffer(polyline).reshape(-1, 2)
    along = np.concatenate([stations_m(points), np.full(CHUNK, np.inf)])
    last = len(points) - 1
    long = np.array([along[k + 1 :][:last] - along[:last] > CHUNK_M for k in range(1, CHUNK)])
    reach = np.where(long.any(axis=0), long.argmax(axis=0) + 1, CHUNK)  # pieces from each point to the next cut
    following = np.minimum(np.arange(last) + reach, last).tolist()
    cuts = [0]
    while cuts[-1] < last:
        cuts.append(following[cuts[-1]])
    return np.array(cuts)
