"""The flow of a street in closed form: a car drives straight past walls, some points are fixed to the camera."""

from dataclasses import replace

import numpy as np
from flow_between import flow_between

from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow

CAMERA = Camera(640, 360, 554.0, 554.0, 319.5, 179.5, forward_m=0.0)
GAP_S = 0.1


def street(count: int, seed: int = 0) -> Floats:
    """(count, 3) m: the road, objects on it, and walls 8 m to each side."""
    rng = stream(seed, "street")
    forward = rng.uniform(6.0, 40.0, count)
    right = np.where(rng.random(count) < 0.5, rng.uniform(-4.0, 4.0, count), 8.0 * rng.choice([-1.0, 1.0], count))
    return np.column_stack([forward, right, rng.uniform(0.0, 2.5, count)])


def flow_of(points_px: Floats, past_px: Floats, moved_m: float, on_glass: Bools | None = None) -> Flow:
    """The flow of points (N, 2) between two windows, of a car that moved `moved_m` by its odometer.

    `on_glass` (N,) are those that the tracker has recognised as fixed to the camera.
    """
    flow = flow_between(points_px, past_px, [-moved_m, 0.0, 0.0], gap_s=GAP_S, age_frames=3)
    return flow if on_glass is None else replace(flow, on_glass=on_glass)


def driving(speed_mps: float, count: int, stuck_px: Floats, odometer_mps: float = 10.0) -> Flow:
    """`count` points of the street, and others (M, 2) fixed to the camera; the odometer has `odometer_mps`."""
    scene, past = street(4 * count), np.array([-speed_mps * GAP_S, 0.0, 0.0])
    here = np.zeros((len(scene), 3))
    now, before = (past_image(CAMERA, scene, pose, np.zeros(3)) for pose in (here, np.tile(past, (len(scene), 1))))
    inside = np.flatnonzero(np.all((now >= 0) & (now < [CAMERA.width_px, CAMERA.height_px]), axis=1))[:count]
    points = np.concatenate([now[inside], stuck_px])
    is_fixed = np.arange(len(points)) >= len(inside)
    return flow_of(points, np.concatenate([before[inside], stuck_px]), odometer_mps * GAP_S, is_fixed)


def anywhere(count: int, seed: int = 3) -> Floats:
    """(count, 2) px all over the picture."""
    return stream(seed, "drops").uniform([0.0, 0.0], [CAMERA.width_px, CAMERA.height_px], (count, 2))
