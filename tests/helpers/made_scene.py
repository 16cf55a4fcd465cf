"""Scenes made by hand: a road of constant curvature with three lanes of 3.5 m, and objects on it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.motion import Motion
from vpf_sim.planning.spacetime.planner import SpacetimePlanner
from vpf_sim.scene import EgoState, Road, Scene, Tracks
from vpf_sim.types import VehicleModel

LANE_M, EDGE_M = 3.5, 5.25
STEP_M = 0.5


def road(curvature_per_m: float = 0.0, oncoming_lanes: int = 0) -> Road:
    """From s = -60 to 300 m; it begins at the origin in the direction of x, with d = 0 in the middle lane."""
    s = np.arange(-60.0, 300.0, STEP_M)
    heading = curvature_per_m * s
    if curvature_per_m:
        x, y = np.sin(heading) / curvature_per_m, (1.0 - np.cos(heading)) / curvature_per_m
    else:
        x, y = s, np.zeros_like(s)
    same = np.ones_like(s)
    own_left = -EDGE_M + LANE_M * oncoming_lanes
    lanes = np.array([middle * same for middle in (-LANE_M, 0.0, LANE_M) if middle > own_left])
    return Road(
        s, x, y, heading, curvature_per_m * same, -EDGE_M * same, EDGE_M * same, own_left * same, lanes,
        lane_width_m=LANE_M,
        route_m=0.0,
    )  # fmt: skip


def tracks(on: Road, *objects: tuple[float, ...]) -> Tracks:
    """Each (s, d, heading relative to the road, speed, length, width)."""
    count = len(objects)
    s, d, relative, speed, length, width = np.array(objects, float).reshape(count, 6).T
    x, y, heading = on.world(s, d)
    none, covariance = np.zeros(count), np.zeros((count, 4, 4))
    return Tracks(x, y, heading + relative, speed, none, length, width, s, d, covariance)


def scene(
    on: Road, seen: Tracks, s_m: float = 0.0, d_m: float = 0.0, speed_mps: float = 5.5, reference_mps: float = 5.5
) -> Scene:
    """The ego drives along the road at (s, d), with its rear axle in the road's direction if d = 0."""
    x, y, heading = (float(value) for value in on.world(np.array(s_m), np.array(d_m)))
    curvature = on.direction_at(s_m)[1]
    heading -= curvature * VehicleModel().l_r_m
    ego = EgoState(x, y, heading, speed_mps, speed_mps * curvature / (1.0 - curvature * d_m), s_m, d_m)
    return Scene(0.0, ego, on, seen, reference_mps)


def followed(now: Scene, motion: Motion, time_s: float) -> Scene:
    """The scene at a time until which the car followed a motion exactly, on a straight road."""
    rear_m, arm_m = motion.s_at(time_s), VehicleModel().l_r_m
    yaw_rad = motion.course_at(now.road, rear_m)
    s_m, d_m = rear_m + arm_m * np.cos(yaw_rad), motion.path_at(rear_m)[0] + arm_m * np.sin(yaw_rad)
    ego = scene(now.road, now.tracks, s_m, d_m, motion.speed_at(time_s)).ego._replace(yaw_rad=yaw_rad)
    return replace(now, time_s=time_s, ego=ego)


def planner() -> SpacetimePlanner:
    return SpacetimePlanner(settings.load(), VehicleModel())


def driven(now: Scene, plans: SpacetimePlanner, steps: int) -> Iterator[Scene]:
    """The scene after each tenth of a second in which the car follows the plan of that moment."""
    for _ in range(steps):
        now = followed(now, plans.plan(now), now.time_s + 0.1)
        yield now
