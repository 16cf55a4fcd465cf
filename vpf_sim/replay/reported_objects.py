"""What a driver reports in one frame, counted by where the objects are: measures that need no labels."""

import numpy as np

from vpf_sim.types import Camera, Floats, Perception, RoadEdges

LINE_M = 0.5  # an object whose middle is nearer to a line of the own lane is on that line
WIDE_M = 4.0  # no vehicle is as wide


def columns(perception: Perception, camera: Camera) -> dict[str, float]:
    """The columns of the frame table for the objects that are reported, and the number of flow points.

    An object is in the own lane, on one of its two lines, or beside them. Its distance is from the camera.
    """
    obstacles, road = perception.obstacles, perception.road
    from_line_m = np.abs(obstacles.middle_m - lane_middle_m(road, obstacles.forward_m)) - 0.5 * road.lane_width_m
    in_lane = from_line_m < -LINE_M
    return {
        "obstacles": len(obstacles),
        "obstacles_standing": int(np.count_nonzero(obstacles.identity >= 0)),
        "obstacles_in_lane": int(np.count_nonzero(in_lane)),
        "obstacles_on_line": int(np.count_nonzero(np.abs(from_line_m) <= LINE_M)),
        "obstacles_wide": int(np.count_nonzero(obstacles.width_m > WIDE_M)),
        "nearest_in_lane_m": float(np.min(obstacles.forward_m[in_lane], initial=np.inf)) - camera.forward_m,
        "flow_points": len(perception.flow),
    }


def lane_middle_m(road: RoadEdges, forward_m: Floats) -> Floats:
    """(K,) lateral position of the own lane's middle at distances ahead of the pose."""
    return np.asarray(road.lane_m + forward_m * np.sin(road.heading_rad) + 0.5 * road.curvature_per_m * forward_m**2)
