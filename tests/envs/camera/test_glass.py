"""Water on the windscreen, in frames."""

import numpy as np
import pytest
from windscreen import draw, glass, with_drops

from vpf_sim.envs.camera.glass import Drop
from vpf_sim.types import Camera, Image


def noise(height: int = 480, width: int = 640) -> Image:
    return np.random.default_rng(0).integers(0, 256, (height, width, 3)).astype(np.uint8)


def grey(level: int = 128) -> Image:
    return np.full((480, 640, 3), level, np.uint8)


def test_dry_windscreen_does_not_change_the_frame() -> None:
    water, frame = glass("clear"), noise()
    for k in range(3):
        np.testing.assert_array_equal(draw(water, frame, k), frame)
    assert not water.hidden().any()


def test_drop_shows_the_scene_rotated_by_180_degrees() -> None:
    frame = grey(0)
    frame[:240, :, 0] = 250  # red above
    frame[:, :320, 2] = 250  # blue on the left
    drawn = draw(with_drops(Drop(320.0, 240.0, 3.0)), frame, 4)  # its spot is 17 px wide and 14 high
    # beyond the tints of sky and rim, red is stronger in its lower half and blue in its right one
    upper, lower = drawn[236:239, 318:323, 0].mean(), drawn[242:245, 318:323, 0].mean()
    left, right = drawn[238:243, 314:318, 2].mean(), drawn[238:243, 323:327, 2].mean()
    assert lower > upper + 60.0
    assert right > left + 60.0
    assert drawn[100, 100, 0] > 240 > 10 > drawn[400, 500, 0]


def test_hidden_is_where_water_covers_the_scene() -> None:
    water, frame = glass(wiper_period_s=3.0), noise()
    for k in range(0, 120, 6):
        drawn = draw(water, frame, k)
    hidden = water.hidden()
    assert 0.01 < hidden.mean() < 0.3
    change = np.abs(drawn.astype(float) - frame).mean(axis=2)
    assert np.median(change[hidden]) > 3.0 * np.median(change[~hidden])
    strongly = change > 80.0
    assert hidden[strongly].mean() > 0.9


def test_hidden_includes_the_blade() -> None:
    water = glass(droplets=0.0)
    dark, blades = 0, 0
    for k in range(0, 180, 3):
        black = draw(water, grey(200), k).max(axis=2) < 90
        if black.any():
            blades += 1
            dark += (black & ~water.hidden()).sum()
        else:
            assert not water.hidden().any() or water.hidden().mean() < 0.01
    assert 6 < blades < 20
    assert dark == 0


def test_cover_grows_between_sweeps_and_is_wiped() -> None:
    water = glass(wiper_period_s=4.0)
    cover = []
    for k in range(0, 360, 3):
        draw(water, grey(), k)
        cover.append(water.opacity().mean() / 255.0)
    swings = np.array(cover)
    assert swings.max() - swings.min() > 0.06  # a few %/s for 3 s
    assert swings.min() < 0.02
    growth = np.diff(swings) * 20.0  # 1/s
    assert 0.025 < np.median(growth[growth > 0.0]) < 0.06
    assert growth.min() < -0.5


def test_film_behind_the_blade_dries_within_a_moment() -> None:
    water, frame = glass(droplets=1.0, wiper_period_s=4.0), noise()  # drops a second: next to none
    blade = glass(droplets=0.0, wiper_period_s=4.0)
    seen = [bool((draw(blade, grey(), k) != 128).any()) for k in range(300)]
    gone = next(k for k in range(1, 260) if seen[k - 1] and not any(seen[k : k + 40]))
    contrast = [draw(water, frame, k)[300:400, 200:400].std() for k in range(gone + 40)]
    fresh, dry = contrast[gone], contrast[gone + 30]
    assert 0.88 < fresh / dry < 0.97


def test_the_same_time_again_changes_nothing() -> None:
    water, frame = glass(), noise()
    for k in range(20):
        first = draw(water, frame, k)
        np.testing.assert_array_equal(draw(water, frame, k), first)


def test_seed_determines_the_water() -> None:
    frame = noise()
    first, again, other = (glass(seed=seed) for seed in (3, 3, 4))
    differs = []
    for k in range(30):
        drawn = draw(first, frame, k)
        np.testing.assert_array_equal(draw(again, frame, k), drawn)
        differs.append((draw(other, frame, k) != drawn).any(axis=2).mean())
    assert min(differs) > 0.02


def test_hard_rain_does_not_repeat_within_ten_seconds() -> None:
    water, alphas = glass(droplets=100.0, wiper_period_s=1.0), []
    for k in range(0, 600, 4):
        draw(water, grey(), k)
        if k % 60 == 40:
            alphas.append((water.opacity() > 60).astype(float).ravel())
    wet = [alpha for alpha in alphas if alpha.any()]
    assert len(wet) == 10
    likeness = np.corrcoef(wet) - np.eye(10)
    assert likeness.max() < 0.6  # the corner out of the blade's reach keeps its drops for seconds


@pytest.mark.parametrize("size", [(64, 48), (640, 361), (1242, 375)])
def test_windscreen_supports_any_image_size(size: tuple[int, int]) -> None:
    width, height = size
    camera = Camera(width, height, width / 2, width / 2, (width - 1) / 2, (height - 1) / 2)
    water, frame = glass(camera=camera), noise(height, width)
    for k in range(0, 40, 4):
        drawn = draw(water, frame, k, camera)
    assert drawn.shape == frame.shape
    assert (drawn != frame).any()
    assert water.hidden().shape == (height, width)
