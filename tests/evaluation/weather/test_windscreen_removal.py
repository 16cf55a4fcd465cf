"""Spots and a wiper blade before a moving road: detection, mask and restoration."""

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
import pytest
from driver_settings import FULL_FRAME, ROBUST

from vpf_sim.evaluation.weather.windscreen_removal import Restoration, WindscreenMask
from vpf_sim.evaluation.weather.windscreen_spots import SpotConfig, SpotDetector
from vpf_sim.evaluation.weather.wiper_detector import WiperDetector
from vpf_sim.geometry import ground_from_pixels
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Image

CAMERA = Camera(400, 240, 320.0, 320.0, 199.5, 40.0, height_m=1.4, forward_m=0.0)  # looks at the road alone
RATE_HZ, STEP_M = 20.0, 0.4


@lru_cache
def road(k: int) -> Image:
    """(H, W) grey: a random road seen from the pose of frame k; above the horizon a light sky."""
    pose = pose_at(k)
    texture = stream(1, "road").normal(0.0, 1.0, (512, 512))
    smooth = cv2.GaussianBlur(texture, (0, 0), 2.0)
    x, y = np.meshgrid(np.arange(400.0), np.arange(240.0))
    place = ground_from_pixels(CAMERA, np.stack([x, np.maximum(y, CAMERA.cy_px + 6.0)], axis=-1))
    spot = 20.0 * (place + pose[:2])
    u, v = (np.remainder(spot[..., i], 511.0).astype(np.float32) for i in (0, 1))
    seen = 110.0 + 40.0 * cv2.remap(smooth / smooth.std(), u, v, cv2.INTER_LINEAR)
    return np.where(y < CAMERA.cy_px + 6.0, 190.0, np.clip(seen, 0.0, 255.0)).astype(np.uint8)


def spots(count: int = 12) -> Bools:
    """(H, W) true on round spots below the horizon."""
    mask, rng = np.zeros((240, 400), np.uint8), stream(2, "spots")
    for _ in range(count):
        cv2.circle(mask, (int(rng.uniform(20, 380)), int(rng.uniform(110, 225))), int(rng.uniform(5, 9)), 1, -1)
    return mask.astype(bool)


def dirty(frame: Image, mask: Bools) -> Image:
    """The frame behind blurred white spots."""
    cover = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 1.5)
    return np.rint(frame * (1.0 - cover) + 235.0 * cover).astype(np.uint8)


def pose_at(k: int) -> Floats:
    return np.array([STEP_M * k, 0.0, 0.0])


def overlap(found: Bools, truth: Bools) -> float:
    return float(np.count_nonzero(found & truth) / max(1, np.count_nonzero(found | truth)))


def test_spots_are_detected_and_the_road_is_not() -> None:
    watch, clean, mask = (SpotDetector(CAMERA, SpotConfig(), RATE_HZ) for _ in range(2)), None, spots()
    wet, dry = watch
    for k in range(14):
        frame = road(k)
        wet.update(dirty(frame, mask), pose_at(k))
        dry.update(frame, pose_at(k))
    clean = dry.spots() != 0
    assert overlap(wet.spots() != 0, mask) > 0.5
    assert clean.mean() < 0.02


def test_a_line_along_the_motion_is_no_spot() -> None:
    watch = SpotDetector(CAMERA, SpotConfig(), RATE_HZ)
    for k in range(14):
        frame = road(k).copy()
        cv2.line(frame, (199, 40), (80, 239), 255, 5, cv2.LINE_AA)
        watch.update(frame, pose_at(k))
    line = np.zeros((240, 400), np.uint8)
    cv2.line(line, (199, 40), (80, 239), 255, 9)
    assert (watch.spots()[line > 0] != 0).mean() < 0.1


def test_a_stationary_car_adds_no_samples() -> None:
    watch, mask = SpotDetector(CAMERA, SpotConfig(), RATE_HZ), spots()
    for _ in range(14):
        assert not watch.update(dirty(road(0), mask), pose_at(0))
    assert not watch.spots().any()


def test_wiped_spots_are_cleared() -> None:
    watch, mask = SpotDetector(CAMERA, SpotConfig(), RATE_HZ), spots()
    for k in range(14):
        watch.update(dirty(road(k), mask), pose_at(k))
    assert watch.spots()[:, 200:].any()
    watch.reset(np.where(np.arange(400) >= 200, 255, 0).astype(np.uint8)[None].repeat(240, 0))
    assert not watch.spots()[:, 200:].any()
    assert watch.spots()[:, :200].any()


def test_a_reduced_image_works_for_a_larger_camera() -> None:
    camera = Camera(800, 480, 640.0, 640.0, 399.5, 80.0, height_m=1.4, forward_m=0.0)
    assert SpotDetector(camera, SpotConfig(), RATE_HZ).shape == (240, 400)


def with_blade(frame: Image, x_px: int) -> Image:
    blade = np.zeros((240, 400), np.float32)
    cv2.line(blade, (x_px - 40, 0), (x_px + 40, 239), 1.0, 40)
    cover = cv2.GaussianBlur(blade, (0, 0), 4.0)
    return np.rint(frame * (1.0 - cover) + 20.0 * cover).astype(np.uint8)


def test_a_blade_is_detected_while_visible() -> None:
    watch = WiperDetector(CAMERA, RATE_HZ)
    for k in range(12):
        assert watch.update(road(k)) is None
    seen = watch.update(with_blade(road(12), 200))
    assert seen is not None
    assert 0.05 < (seen != 0).mean() < 0.3
    assert seen[len(seen) // 2, seen.shape[1] // 2] == 255
    assert watch.update(road(13)) is None


def test_a_post_beside_the_road_is_no_blade() -> None:
    watch = WiperDetector(CAMERA, RATE_HZ)
    for k in range(12):
        watch.update(road(k))
    post = road(12).copy()
    cv2.line(post, (300, 0), (300, 239), 20, 9)
    assert watch.update(post) is None


def test_a_line_slightly_off_the_motion_is_no_spot() -> None:
    """The direction of motion is not known exactly: the camera may look 2 deg aside."""
    watch = SpotDetector(CAMERA, SpotConfig(), RATE_HZ)
    line = np.zeros((240, 400), np.uint8)
    cv2.line(line, (210, 40), (80, 239), 255, 9)
    for k in range(14):
        frame = road(k).copy()
        cv2.line(frame, (210, 40), (80, 239), 255, 5, cv2.LINE_AA)
        watch.update(frame, pose_at(k))
    assert (watch.spots()[line > 0] != 0).mean() < 0.1


@pytest.mark.parametrize("mode", ["grey", "colour"])
def test_the_warped_frame_fills_spots_better_than_inpainting(mode: str) -> None:
    mask, restoration, glass = spots(), Restoration(CAMERA), WindscreenMask(CAMERA, RATE_HZ)
    tracker = FlowTracker(CAMERA, replace(FULL_FRAME.flow, max_level=3), RATE_HZ)
    for k in range(14):
        clean = road(k)
        wet = dirty(clean, mask)
        hidden = glass.with_rim(mask.astype(np.uint8) * 255)
        flow = tracker.update(wet, pose_at(k), hidden)
        foe = expansion.estimate(flow, CAMERA, ROBUST.focus_of_expansion, stream(0, "foe"))
        frame = wet if mode == "grey" else cv2.cvtColor(wet, cv2.COLOR_GRAY2RGB).astype(np.uint8)
        restored = restoration.update(frame, hidden, flow, foe)
    plane = restored if mode == "grey" else restored[..., 1]
    around = cv2.inpaint(wet, hidden, 3.0, cv2.INPAINT_TELEA)
    error, of_inpainting = (np.abs(one[mask].astype(float) - clean[mask]).mean() for one in (plane, around))
    assert error < 0.85 * of_inpainting
    np.testing.assert_array_equal(plane[hidden == 0], wet[hidden == 0])


def test_the_mask_of_a_frame_has_spots_and_blade() -> None:
    glass, mask = WindscreenMask(CAMERA, RATE_HZ), spots()
    for k in range(14):
        found = glass.update(dirty(road(k), mask), pose_at(k))
    assert overlap(found != 0, mask) > 0.5
    with_both = glass.update(with_blade(dirty(road(14), mask), 200), pose_at(14))
    assert np.count_nonzero(with_both) > np.count_nonzero(found)
    assert with_both[120, 200] == 255


@pytest.mark.parametrize(("change", "said"), [({"coherence": 1.0}, "coherence"), ({"memory_s": 0.0}, "memory_s")])
def test_invalid_settings_are_refused(change: dict[str, float], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        SpotConfig(**change)
