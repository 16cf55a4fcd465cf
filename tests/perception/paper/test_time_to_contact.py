"""Time to contact: looming patches whose time is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import ROBUST
from flow_between import ORIGIN, flow_between

from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.perception.paper.time_to_contact import as_printed, time_to_contact
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow

CAMERA = Camera()
CONTACT = ROBUST.time_to_contact
SPEED_MPS = 5.55


def expansion(x_px: float = CAMERA.cx_px) -> Expansion:
    return Expansion(x_px, CAMERA.cy_px, np.eye(2), np.ones(0, np.bool_), 1.0)


def flow_of(scene_m: Floats, gap_s: float = 0.1, turn_rad: float = 0.0, noise_px: float = 0.0) -> Flow:
    """Points (N, 3) in the axes of the car now, after a window driven straight, or on an arc of `turn_rad`."""
    count, way = len(scene_m), SPEED_MPS * gap_s
    past = np.array([-way, 0.0, 0.0])
    if turn_rad:
        past = np.array([-np.sin(turn_rad), 1.0 - np.cos(turn_rad), 0.0]) * way / turn_rad - [0.0, 0.0, turn_rad]
    now, before = (past_image(CAMERA, scene_m, np.tile(pose, (count, 1)), ORIGIN) for pose in (ORIGIN, past))
    before = before + stream(3, "contact").normal(0.0, noise_px, (count, 2))
    return flow_between(now, before, past, gap_s=gap_s)


def patch(distance_m: float, count: int = 40) -> Floats:
    """A flat body's face, `distance_m` ahead of the camera."""
    rng = stream(4, "patch")
    forward = np.full(count, distance_m + CAMERA.forward_m)
    return np.column_stack([forward, rng.uniform(-1.0, 1.0, count), rng.uniform(0.2, 2.4, count)])


@pytest.mark.parametrize("distance_m", [6.0, 12.0, 24.0])
@pytest.mark.parametrize("gap_s", [1.0 / 60.0, 0.1])
def test_radial_motion_gives_depth_over_speed_at_the_window_s_end(distance_m: float, gap_s: float) -> None:
    ttc = time_to_contact(flow_of(patch(distance_m), gap_s), expansion(), CAMERA, replace(CONTACT, floor_px=1e-6))
    assert ttc == pytest.approx(distance_m / SPEED_MPS, rel=1e-6)


def test_the_printed_formula_is_one_window_too_long() -> None:
    config = replace(CONTACT, method="as_printed", floor_px=1e-9)
    assert as_printed(flow_of(patch(12.0)), expansion(), config) == pytest.approx(12.0 / SPEED_MPS + 0.1, rel=1e-6)


def test_the_printed_formula_needs_the_floor_and_the_cap() -> None:
    far = flow_of(np.array([[1e5, 0.5, 1.5]]))
    assert as_printed(far, expansion(), replace(CONTACT, method="as_printed")) == pytest.approx([0.032], abs=0.2)
    assert as_printed(far, expansion(), replace(CONTACT, method="as_printed", floor_px=1e-9)) == pytest.approx([20.0])
    assert np.isinf(time_to_contact(far, expansion(), CAMERA, CONTACT))[0]


def test_a_turn_is_taken_out() -> None:
    turn = 0.1 * SPEED_MPS / 80.0
    flow = flow_of(patch(12.0), turn_rad=turn)
    foe = expansion(CAMERA.cx_px + CAMERA.fx_px * CAMERA.forward_m / 80.0)
    away = np.abs(flow.points_px[:, 0] - foe.x_px) > 10.0
    robust = time_to_contact(flow, foe, CAMERA, CONTACT)[away]
    printed = as_printed(flow, foe, replace(CONTACT, method="as_printed"))[away]
    assert robust == pytest.approx(12.0 / SPEED_MPS, rel=0.05)
    assert np.median(np.abs(printed - 12.0 / SPEED_MPS)) > 0.3


def test_a_cluster_s_expansion_needs_no_focus_and_averages_the_noise() -> None:
    flow = flow_of(patch(12.0), noise_px=0.1)
    labels = np.zeros(len(flow), np.int64)
    together = time_to_contact(flow, expansion(), CAMERA, CONTACT, labels)
    assert together == pytest.approx(12.0 / SPEED_MPS, rel=0.1)
    single = time_to_contact(flow, expansion(), CAMERA, CONTACT)
    assert abs(together[0] - 12.0 / SPEED_MPS) < np.median(np.abs(single - 12.0 / SPEED_MPS))


def test_clusters_are_told_apart_and_small_ones_fall_back_to_their_points() -> None:
    flow = flow_of(np.concatenate([patch(9.0, 10), patch(18.0, 10) + np.array([0.0, 4.0, 0.0]), [[30.0, -5.0, 0.0]]]))
    labels = np.repeat([0, 1, 2], [10, 10, 1])
    ttc = time_to_contact(flow, expansion(), CAMERA, replace(CONTACT, floor_px=1e-6), labels)
    assert ttc[:10] == pytest.approx(9.0 / SPEED_MPS, rel=1e-3)
    assert ttc[10:20] == pytest.approx(18.0 / SPEED_MPS, rel=1e-3)
    assert ttc[20] == pytest.approx((30.0 - CAMERA.forward_m) / SPEED_MPS, rel=1e-3)


def test_no_points_give_no_times() -> None:
    flow = flow_of(np.empty((0, 3)))
    for method in ("as_printed", "robust"):
        assert len(time_to_contact(flow, expansion(), CAMERA, replace(CONTACT, method=method))) == 0


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match=r"floor_px: expected > 0, got -1\.0"):
        replace(CONTACT, floor_px=-1.0)
