"""Where the carriageway's edges are ahead, where it leads, and what lies on or beside its edges' lines."""

from math import cos

import numpy as np

from vpf_sim.types import Floats, RoadEdges


def carriageway_offsets(forward_m: Floats, road: RoadEdges) -> tuple[Floats, Floats]:
    """Lateral positions (N,) of the left and right edge at `forward_m`, vehicle axes, by a parabola for each edge."""

    cosine = cos(road.heading_rad)
    along, aside = forward_m / cosine, np.tan(road.heading_rad) * forward_m
    square = along**2

    def edge(offset_m: float) -> Floats:
        curvature = road.curvature_per_m / (1.0 - road.curvature_per_m * offset_m)
        place: Floats = offset_m / cosine + aside + 0.5 * curvature * square / cosine
        return place

    return edge(road.left_m), edge(road.right_m)


def direction_rad(forward_m: Floats, road: RoadEdges) -> Floats:
    """(N,) rad to the right of ahead, the road's direction at `forward_m`; behind the pose that at the pose."""
    direction: Floats = road.heading_rad + road.curvature_per_m * np.maximum(forward_m, 0.0)
    return direction
