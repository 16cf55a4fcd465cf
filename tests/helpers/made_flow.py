"""Point tracks of bodies with known places and velocities, projected while the car drives or turns."""

import numpy as np
from driver_settings import ROBUST, static_obstacles
from flow_between import flow_between

from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.perception.obstacles.point_motion import PointMotions, point_motions
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Flow

CAMERA = Camera()
GAP_S, SPEED_MPS = 0.1, 5.5


def body(forward_m: float, right_m: float, width_m: float, low_m: float, high_m: float, count: int = 30) -> Floats:
    """(count, 3) points of an upright face, its lowest and highest among them."""
    random = stream(3, "body")
    points = random.uniform([-0.5 * width_m, low_m], [0.5 * width_m, high_m], (count, 2))
    points[0, 1], points[1, 1] = low_m, high_m
    return np.column_stack([np.full(count, forward_m), right_m + points[:, 0], points[:, 1]])


def road(count: int = 150) -> Floats:
    random = stream(4, "road")
    return np.column_stack([random.uniform(4.0, 30.0, count), random.uniform(-6.0, 6.0, count), np.zeros(count)])


def flow(points_m: Floats, velocity_mps: Floats, yaw_rate_radps: float = 0.0, noise_px: float = 0.05) -> Flow:
    """Of points (N, 3), places now with velocities (N, 2), for a car at the origin that comes along x."""
    turn = yaw_rate_radps * GAP_S
    before = np.array([-SPEED_MPS * GAP_S * np.cos(0.5 * turn), SPEED_MPS * GAP_S * np.sin(0.5 * turn), -turn])
    past = points_m.copy()
    past[:, :2] = vehicle_from_world(points_m[:, :2] - GAP_S * velocity_mps, before)
    random, count = stream(5, "noise"), len(points_m)
    now_px, past_px = (project(CAMERA, place) + random.normal(0.0, noise_px, (count, 2)) for place in (points_m, past))
    return flow_between(now_px, past_px, before, gap_s=GAP_S, age_frames=2, structure=400.0)


def motions(points: Flow) -> PointMotions:
    return point_motions(points, CAMERA, ROBUST.flow.window_px, static_obstacles().noise)
