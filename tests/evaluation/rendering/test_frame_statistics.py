"""Frame statistics of images with known values."""

import cv2
import numpy as np
import pytest

from vpf_sim.evaluation.rendering import frame_statistics
from vpf_sim.evaluation.rendering.frame_statistics import FrameStatistics
from vpf_sim.types import Image

ROWS, COLUMNS = np.mgrid[0:240, 0:320].astype(float)


def texture(dx: float = 0.0, dy: float = 0.0) -> Image:
    """A pattern of waves, moved by (dx, dy) px exactly."""
    x, y = COLUMNS - dx, ROWS - dy
    waves = np.sin(0.41 * x + 0.13 * y) + np.sin(0.29 * y - 0.11 * x) + np.sin(0.19 * x - 0.37 * y)
    return np.rint(128.0 + 30.0 * waves).astype(np.uint8)


def test_the_gradient_of_a_ramp_is_its_slope() -> None:
    ramp = (3.0 * COLUMNS[:, :80]).astype(np.uint8)
    assert frame_statistics.gradient_percentiles(ramp) == [3.0, 3.0, 3.0]
    oblique = (1.5 * COLUMNS[:48, :48] + 2.0 * ROWS[:48, :48]).astype(np.float32).round().astype(np.uint8)
    assert frame_statistics.gradient_percentiles(oblique)[0] == pytest.approx(2.5, rel=0.05)


def test_the_contrast_of_a_chessboard_is_half_its_step() -> None:
    board = np.where((ROWS + COLUMNS) % 2 == 0, 90, 110).astype(np.uint8)
    assert frame_statistics.contrast(board) == pytest.approx(10.0, abs=0.02)
    assert frame_statistics.contrast(np.full((60, 60), 77, np.uint8)) == 0.0


def test_corners_are_counted_where_they_are() -> None:
    picture = np.full((240, 320), 60, np.uint8)
    for x, y in ((60, 30), (160, 110), (240, 110), (100, 200)):
        cv2.rectangle(picture, (x, y), (x + 24, y + 24), 200, -1)
    assert frame_statistics.corner_counts(picture) == [4, 8, 4]
    assert frame_statistics.corner_counts(np.full((240, 320), 60, np.uint8)) == [0, 0, 0]


def test_a_moving_texture_is_followed_to_where_it_moved() -> None:
    frames = [texture(1.3 * k, -0.6 * k) for k in range(7)]
    points = np.array([[60.0, 60.0], [150.0, 100.0], [200.0, 180.0]])
    now, alive = frame_statistics.follow(frames, points)
    assert alive.shape == (6, 3)
    assert alive.all()
    assert np.abs(now - points - (7.8, -3.6)).max() < 0.15
    assert frame_statistics.survival(frames)[0] > 0.95


def test_a_vanished_point_is_not_tracked() -> None:
    rng = np.random.default_rng(3)
    strangers = [rng.integers(0, 256, (240, 320)).astype(np.uint8) for _ in range(7)]
    one, six = frame_statistics.survival(strangers)
    assert one < 0.5
    assert six < 0.02


def test_lost_points_stay_lost() -> None:
    empty = np.full((240, 320), 128, np.uint8)
    _, alive = frame_statistics.follow([texture(), empty, texture()], np.array([[60.0, 60.0], [150.0, 100.0]]))
    assert not (alive[1] & ~alive[0]).any()


def test_measure_is_the_mean_over_the_sampled_frames() -> None:
    frames = [texture(k) for k in range(13)]
    every = [frame_statistics.gradient_percentiles(frame)[1] for frame in frames[:7]]
    assert frame_statistics.measure(frames).gradient_p90 == pytest.approx(np.mean(every))
    assert frame_statistics.measure(frames, every=3).gradient_p90 == pytest.approx(np.mean(every[::3]))
    with pytest.raises(ValueError, match="expected more than 6 frames, got 6"):
        frame_statistics.measure(frames[:6])


def test_frames_are_scaled_to_one_width() -> None:
    wide = np.zeros((375, 1242, 3), np.uint8)
    wide[:, ::2] = 100
    scaled = frame_statistics.scaled_grey(wide)
    assert scaled.shape == (193, 640)
    assert abs(float(scaled.mean()) - 50.0) < 1.0


def test_the_ratio_is_number_by_number() -> None:
    ours, theirs = FrameStatistics(*range(1, 10)), FrameStatistics(*(2 * i for i in range(1, 9)), 0.0)
    assert list(ours.ratio(theirs).values()) == [0.5] * 8 + [np.inf]


def test_the_mean_is_number_by_number() -> None:
    mean = FrameStatistics.mean([FrameStatistics(*range(9)), FrameStatistics(*range(2, 11))])
    assert mean == FrameStatistics(*(float(i) for i in range(1, 10)))
