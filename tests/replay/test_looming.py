"""Images of an object with a known expansion rate."""

from math import inf, isnan

import cv2
import numpy as np
import pytest

from vpf_sim.replay.obstacles_ahead import Box, LoomingTracker
from vpf_sim.seeding import stream
from vpf_sim.types import Image

RATE_HZ = 20.0
FOCAL, WIDTH_M = 500.0, 1.6


def texture(name: str) -> Image:
    smooth = cv2.GaussianBlur(stream(21, name).normal(0.0, 1.0, (240, 240)), (0, 0), 3.0)
    return np.clip(120.0 + 45.0 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def frame(distance_m: float, aside_px: float, foreign: float = 0.0) -> tuple[Image, Box]:
    """(320, 480) a square object, sharp at any distance, on grey; part of it is a still reflection."""
    size = FOCAL * WIDTH_M / distance_m
    left, top = 240.0 + aside_px - 0.5 * size, 160.0 - 0.5 * size
    matrix = np.array([[size / 240.0, 0.0, left], [0.0, size / 240.0, top]])
    drawn = cv2.warpAffine(texture("body"), matrix, (480, 320), flags=cv2.INTER_AREA, borderValue=100.0)
    rows = int(foreign * size)
    if rows:
        y, x = int(top) + 8, int(left) + 8
        width = int(size) - 16
        drawn[y : y + rows, x : x + width] = texture("pane")[:rows, :width]
    noise = stream(int(1000 * distance_m), "noise").normal(0.0, 1.0, (320, 480))
    noisy = np.clip(drawn.astype(float) + noise, 0, 255).astype(np.uint8)
    return noisy, (left, top, left + size, top + size)


def drive(closing_mps: float, frames: int = 16, foreign: float = 0.0, drift_px: float = 0.0) -> tuple[float, float]:
    """The last time to contact, and the distance then."""
    tracker = LoomingTracker(RATE_HZ)
    for k in range(frames):
        distance = 8.0 - closing_mps * k / RATE_HZ
        ttc_s = tracker.update(*frame(distance, drift_px * k, foreign))
    return ttc_s, distance


@pytest.mark.parametrize("closing_mps", [0.5, 1.0, 4.0])
@pytest.mark.parametrize("drift_px", [0.0, 1.3])
def test_ttc_is_distance_over_closing_speed(closing_mps: float, drift_px: float) -> None:
    ttc_s, distance = drive(closing_mps, drift_px=drift_px)
    assert ttc_s == pytest.approx(distance / closing_mps, rel=0.12)


def test_reflections_are_outliers() -> None:
    ttc_s, distance = drive(1.0, foreign=0.3)
    assert ttc_s == pytest.approx(distance, rel=0.15)


@pytest.mark.parametrize("closing_mps", [0.0, -1.0])
def test_constant_or_growing_distance_has_infinite_ttc(closing_mps: float) -> None:
    ttc_s, _ = drive(closing_mps)
    assert ttc_s == inf


def test_too_few_points_have_unknown_ttc() -> None:
    assert isnan(drive(1.0, frames=3)[0])
    tracker = LoomingTracker(RATE_HZ)
    plain = np.full((320, 480), 90, np.uint8)
    for _ in range(12):
        ttc_s = tracker.update(plain, (100.0, 100.0, 300.0, 200.0))
    assert isnan(ttc_s)
    assert isnan(tracker.update(plain, None))
