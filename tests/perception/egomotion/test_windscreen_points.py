"""Points on the windscreen: recognised by the motion that they lack."""

import numpy as np
import pytest
from driver_settings import ROBUST
from flow_made import street

from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.perception.egomotion.windscreen_points import least_motion, on_glass, scene_motion
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

CAMERA = Camera(forward_m=0.0)
HERE = np.zeros(3)
CONFIG = ROBUST.flow.windscreen_points


def seen(past_pose: Floats, count: int = 300) -> tuple[Floats, Floats, Floats]:
    """Pixels of the street now and before, and the pose of then for each, of those in both pictures."""
    scene, past = street(count), np.tile(past_pose, (count, 1))
    now = past_image(CAMERA, scene, np.tile(HERE, (count, 1)), HERE)
    before = past_image(CAMERA, scene, past, HERE)
    inside = np.all((now >= 0) & (now < [640, 480]), axis=1)
    return now[inside], before[inside], past[inside]


@pytest.mark.parametrize("past", [(-3.0, 0.0, 0.0), (-3.0, 0.05, -0.05), (-3.0, -0.1, 0.08)])
def test_scenery_moves_at_least_as_far_as_is_said(past: tuple[float, float, float]) -> None:
    now, before, poses = seen(np.array(past))
    least = least_motion(*scene_motion(CAMERA, now, poses, HERE))
    assert np.all(np.hypot(*(now - before).T) > 0.85 * least - 0.5)
    assert not on_glass(CAMERA, now, before, poses, HERE, CONFIG).any()


def test_the_road_moves_exactly_so() -> None:
    road = street(50) * [1.0, 0.5, 0.0]
    past = np.tile([-2.0, 0.1, 0.03], (50, 1))
    now = past_image(CAMERA, road, np.tile(HERE, (50, 1)), HERE)
    before = past_image(CAMERA, road, past, HERE)
    by_way, by_turn = scene_motion(CAMERA, now, past, HERE)
    np.testing.assert_allclose(by_way + by_turn, now - before, atol=1e-6)


def test_drops_on_the_glass_are_found_where_scenery_would_have_moved() -> None:
    rng = stream(1, "spots")
    drops = rng.uniform([0.0, 0.0], [640.0, 480.0], (400, 2))
    past = np.tile([-3.0, 0.0, 0.0], (400, 1))
    found = on_glass(CAMERA, drops, drops + rng.normal(0.0, 0.15, (400, 2)), past, HERE, CONFIG)
    far = np.abs(drops[:, 1] - CAMERA.cy_px) < 15.0  # near the horizon the scene hardly moves
    assert found[drops[:, 1] > CAMERA.cy_px + 60.0].all()
    assert not found[far & (np.abs(drops[:, 0] - CAMERA.cx_px) < 60.0)].any()
    assert found.mean() > 0.7


@pytest.mark.parametrize(("turn_rad", "found"), [(0.0, False), (-0.05, True)], ids=["stands", "turns"])
def test_a_turn_alone_shows_drops_and_standing_does_not(turn_rad: float, found: bool) -> None:
    drops = stream(3, "spots").uniform([0.0, 0.0], [640.0, 480.0], (100, 2))
    past = np.tile([0.0, 0.0, turn_rad], (100, 1))
    assert (on_glass(CAMERA, drops, drops, past, HERE, CONFIG) == found).all()
