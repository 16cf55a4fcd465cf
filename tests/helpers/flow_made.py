"""The flow of a made street in closed form: a car that drives straight past walls, and points that ride along."""

import numpy as np

from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow

CAMERA = Camera(640, 360, 554.0, 554.0, 319.5, 179.5, forward_m=0.0)
GAP_S = 0.1


def street(count: int, seed: int = 0) -> Floats:
    """(count, 3) m: the road and what stands on it, walls 8 m aside."""
    rng = stream(seed, "street")
    forward = rng.uniform(6.0, 40.0, count)
    right = np.where(rng.random(count) < 0.5, rng.uniform(-4.0, 4.0, count), 8.0 * rng.choice([-1.0, 1.0], count))
    return np.column_stack([forward, right, rng.uniform(0.0, 2.5, count)])


def flow_of(points_px: Floats, past_px: Floats, moved_m: float, on_glass: Bools | None = None) -> Flow:
    """Points (N, 2) where they are, and where they were a window before, of a car that is told to have moved so far.

    Which of them are `on_glass` (N,) the tracker has recognised by their lives.
    """
    count = len(points_px)
    past = np.tile([-moved_m, 0.0, 0.0], (count, 1))
    return Flow(
        points_px=points_px,
        displacement_px=points_px - past_px,
        gap_s=np.full(count, GAP_S),
        past_pose=past,
        pose=np.zeros(3),
        identity=np.arange(count),
        first_px=past_px,
        first_pose=past,
        age_frames=np.full(count, 3),
        structure=np.tile(np.eye(2), (count, 1, 1)),
        on_glass=np.zeros(count, np.bool_) if on_glass is None else on_glass,
    )


def driving(speed_mps: float, count: int, stuck_px: Floats, told_mps: float = 10.0) -> Flow:
    """`count` points of the street, and others (M, 2) that stay; the way is taken to be that of `told_mps`."""
    scene, past = street(4 * count), np.array([-speed_mps * GAP_S, 0.0, 0.0])
    here = np.zeros((len(scene), 3))
    now, before = (past_image(CAMERA, scene, pose, np.zeros(3)) for pose in (here, np.tile(past, (len(scene), 1))))
    inside = np.flatnonzero(np.all((now >= 0) & (now < [CAMERA.width_px, CAMERA.height_px]), axis=1))[:count]
    points = np.concatenate([now[inside], stuck_px])
    rides = np.arange(len(points)) >= len(inside)
    return flow_of(points, np.concatenate([before[inside], stuck_px]), told_mps * GAP_S, rides)


def anywhere(count: int, seed: int = 3) -> Floats:
    """(count, 2) px all over the picture."""
    return stream(seed, "drops").uniform([0.0, 0.0], [CAMERA.width_px, CAMERA.height_px], (count, 2))
