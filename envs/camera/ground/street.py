"""What a town adds to a road: kerbs with a pavement, tram rails, a bus lane, double lines. All of it is flat."""

import numpy as np

from vpf_sim.envs.camera.layout import Edge, LaneShape
from vpf_sim.types import Floats

Strip = tuple[Floats, Floats, int]  # two edges (M, 2) and the palette value between them

GUTTER, KERB, PAVEMENT, GROOVE, STEEL, BUS_LANE = 138, 182, 162, 138, 186, 140
KERB_FROM_M, KERB_M, GUTTER_M, PAVEMENT_M = 0.5, 0.15, 0.08, 1.7
GAUGE_M, RAIL_M, GROOVE_M = 1.435, 0.06, 0.04


def kerbs(edge: Edge) -> list[Strip]:
    """A pavement beside an outer edge, its kerb stones and the dark face below them."""
    stone_m = KERB_FROM_M + KERB_M
    return [
        (edge.at(stone_m), edge.at(stone_m + PAVEMENT_M), PAVEMENT),
        (edge.at(KERB_FROM_M), edge.at(stone_m), KERB),
        (edge.at(KERB_FROM_M - GUTTER_M), edge.at(KERB_FROM_M), GUTTER),
    ]


def tram_rails(shape: LaneShape) -> list[Strip]:
    """Two rails in a lane, each with a groove on its inner side."""
    strips = []
    for side in (-1.0, 1.0):
        inner_m, outer_m = side * 0.5 * GAUGE_M, side * (0.5 * GAUGE_M + RAIL_M)
        strips += [
            _between(shape, inner_m, outer_m, STEEL),
            _between(shape, inner_m - side * GROOVE_M, inner_m, GROOVE),
        ]
    return strips


def _between(shape: LaneShape, one_m: float, other_m: float, value: int) -> Strip:
    """A strip along a lane between two lateral positions."""
    return shape.at(min(one_m, other_m)), shape.at(max(one_m, other_m)), value


def outermost(shapes: list[LaneShape], edges: list[Edge], side: str) -> list[LaneShape]:
    """The lanes that have nothing beside them on a side, `left` or `right`."""
    borders = {tuple(point) for edge in edges for point in edge.points_m.tolist()}
    sides = [shape.left_m if side == "left" else shape.right_m for shape in shapes]
    return [shape for shape, points in zip(shapes, sides, strict=True) if tuple(points[len(points) // 2]) in borders]


def is_outer(points_m: Floats, edges: list[Edge], within_m: float) -> bool:
    """Whether a line (M, 2) runs along an outer edge."""
    middle = points_m[len(points_m) // 2]
    return any(float(np.hypot(*(edge.points_m - middle).T).min()) < within_m for edge in edges)
