"""The focus of expansion: closed-form flows with a known one."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import ROBUST, expansion
from flow_between import flow_between

from vpf_sim.perception.egomotion.focus_of_expansion import as_printed, estimate, least_squares
from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Flow

CAMERA, CONFIG = Camera(), ROBUST.focus_of_expansion
FOE = np.array([330.0, 235.0])


def radial_flow(count: int, name: str) -> tuple[Floats, Floats]:
    rng = stream(1, name)
    points = np.column_stack([rng.uniform(0, 640, count), rng.uniform(0, 480, count)])
    return points, (points - FOE) * rng.uniform(0.01, 0.05, count)[:, None]


def flow_on_circle(radius_m: float, noise_px: float, outlier_share: float = 0.0, frames: int = 6) -> Flow:
    """A standing scene seen from the start and the end of a window driven on a circle about (0, radius)."""
    rng = stream(2, f"circle {radius_m}")
    turn = 5.55 * frames / 60.0 / radius_m
    pose = np.zeros(3)
    past = np.array([-radius_m * np.sin(turn), radius_m * (1.0 - np.cos(turn)), -turn])
    forward = rng.uniform(4.0, 40.0, 300)
    scene = np.column_stack([forward, rng.uniform(-0.9, 0.9, 300) * forward, rng.uniform(0.0, 2.5, 300)])
    still = np.zeros((300, 3))
    now = past_image(CAMERA, scene, still, pose)
    before = past_image(CAMERA, scene, np.tile(past, (300, 1)), pose) + rng.normal(0.0, noise_px, (300, 2))
    wrong = rng.random(300) < outlier_share
    before[wrong] = now[wrong] + rng.uniform(-6.0, 6.0, (np.count_nonzero(wrong), 2))
    return flow_between(now, before, past, pose, frames / 60.0, frames)


def foe_on_circle(radius_m: float) -> float:
    """x px: the camera, ahead of the pose, moves across the axis by its lever arm times the yaw rate."""
    return CAMERA.cx_px + CAMERA.fx_px * CAMERA.forward_m / radius_m


def test_least_squares_finds_the_focus_of_a_radial_flow_exactly() -> None:
    assert least_squares(*radial_flow(200, "radial")) == pytest.approx(FOE, abs=1e-6)


def test_the_printed_closed_form_is_right_after_its_two_repairs() -> None:
    points, flow = radial_flow(200, "repair")
    a0, a1 = flow[:, 1], -flow[:, 0]
    printed = np.sum(a0**2 * a1**2) - np.sum(a0 * a1) ** 2
    repaired = np.sum(a0**2) * np.sum(a1**2) - np.sum(a0 * a1) ** 2
    assert -as_printed(points, flow) * printed / repaired == pytest.approx(FOE, abs=1e-6)


@pytest.mark.parametrize("radius_m", [1e9, 200.0, -100.0, 50.0])
def test_turning_is_removed_with_the_chord_it_leaves(radius_m: float) -> None:
    found = estimate(flow_on_circle(radius_m, 0.0), CAMERA, CONFIG, stream(0, "foe"))
    assert found.x_px == pytest.approx(foe_on_circle(radius_m), abs=0.2)
    assert found.y_px == pytest.approx(CAMERA.cy_px, abs=0.2)
    assert found.confidence > 0.8


def test_without_derotation_a_bend_moves_the_focus() -> None:
    found = estimate(flow_on_circle(100.0, 0.1), CAMERA, expansion("least_squares"), stream(0, "foe"))
    assert found.x_px - foe_on_circle(100.0) > 3.0


@pytest.mark.parametrize("share", [0.1, 0.3, 0.4])
def test_outliers_leave_the_robust_estimate_in_place(share: float) -> None:
    flow = flow_on_circle(-100.0, 0.1, share)
    found = estimate(flow, CAMERA, CONFIG, stream(0, "foe"))
    assert np.hypot(found.x_px - foe_on_circle(-100.0), found.y_px - CAMERA.cy_px) < 1.5
    assert np.count_nonzero(found.inliers) < (1.05 - 0.8 * share) * len(flow)


def test_the_covariance_grows_with_the_noise_of_few_points() -> None:
    flow = flow_on_circle(1e9, 0.1)
    few = flow.select(np.arange(0, len(flow), 10))
    many, less = (estimate(points, CAMERA, CONFIG, stream(0, "foe")) for points in (flow, few))
    assert less.covariance_px2[0, 0] > 4.0 * many.covariance_px2[0, 0]


@pytest.mark.parametrize("axis", ["pitch", "roll"])
def test_an_unmeasured_pitch_or_roll_is_fitted_along(axis: str) -> None:
    flow = flow_on_circle(1e9, 0.02)
    x, y = ((flow.points_px - [CAMERA.cx_px, CAMERA.cy_px]) / CAMERA.fx_px).T
    motion = {"pitch": (x * y, 1.0 + y * y), "roll": (-y, x)}[axis]
    tilt_px = 0.003 * CAMERA.fx_px * np.stack(motion, axis=1)
    found = estimate(replace(flow, displacement_px=flow.displacement_px + tilt_px), CAMERA, CONFIG, stream(0, "foe"))
    assert np.hypot(found.x_px - foe_on_circle(1e9), found.y_px - CAMERA.cy_px) < 1.5


def test_a_standing_car_knows_no_focus() -> None:
    still = replace(flow_on_circle(1e9, 0.0), displacement_px=np.zeros((300, 2)))
    for method in ("as_printed", "least_squares", "robust"):
        found = estimate(still, CAMERA, expansion(method), stream(0, "foe"))
        assert (found.x_px, found.y_px, found.confidence) == (CAMERA.cx_px, CAMERA.cy_px, 0.0)


def test_points_on_the_glass_leave_the_focus_in_place_and_take_confidence() -> None:
    """As many points again that do not move at all."""
    clean = flow_on_circle(1e9, 0.1)
    drops = stream(3, "glass").uniform([0.0, 0.0], [640.0, 480.0], (300, 2))
    both = (np.concatenate([px, drops]) for px in (clean.points_px, clean.first_px))
    flow = replace(flow_between(*both, clean.past_pose[0]), on_glass=np.arange(600) >= 300)
    seen, wet = (estimate(one, CAMERA, CONFIG, stream(0, "foe")) for one in (clean, flow))
    assert (wet.x_px, wet.y_px) == pytest.approx((seen.x_px, seen.y_px))
    assert wet.confidence == pytest.approx(0.5 * seen.confidence, rel=0.1)
    assert not wet.inliers[300:].any()


def test_without_motion_the_last_focus_is_held_and_less_and_less_sure() -> None:
    flow = flow_on_circle(100.0, 0.1)
    seen = estimate(flow, CAMERA, CONFIG, stream(0, "foe"))
    still = flow_between(flow.points_px, flow.points_px)
    held = estimate(still, CAMERA, CONFIG, stream(0, "foe"), seen)
    later = estimate(still, CAMERA, CONFIG, stream(0, "foe"), held)
    assert (held.x_px, held.y_px, held.confidence) == (seen.x_px, seen.y_px, 0.0)
    assert later.covariance_px2[0, 0] > held.covariance_px2[0, 0] > seen.covariance_px2[0, 0]


def test_the_last_focus_helps_where_the_flow_is_poor() -> None:
    errors, last = [], estimate(flow_on_circle(1e9, 0.02), CAMERA, CONFIG, stream(0, "foe"))
    flow = flow_on_circle(1e9, 0.5, 0.4)
    for before in (None, last):
        found = [estimate(flow, CAMERA, CONFIG, stream(k, "foe"), before) for k in range(5)]
        errors.append(np.median([abs(one.x_px - CAMERA.cx_px) for one in found]))
    assert errors[1] < errors[0]


def test_the_covariance_says_how_large_the_errors_are() -> None:
    """95 % of the errors of normal noise, with outliers or without, within 2.5 standard deviations."""
    within = []
    for k in range(60):
        share = 0.4 * (k % 2)
        found = estimate(flow_on_circle(1e9 + k, 0.1, share), CAMERA, CONFIG, stream(k, "foe"))
        error = np.array([found.x_px - CAMERA.cx_px, found.y_px - CAMERA.cy_px])
        within.append(np.all(np.abs(error) < 2.5 * np.sqrt(np.diag(found.covariance_px2))))
    assert np.mean(within) > 0.9
