"""Statistics against numpy's own on the same numbers."""

import numpy as np
import pytest

from vpf_sim.datasets.datasheet import QUANTILES, PixelCounts, combined, of_values


def test_counts_give_the_statistics_of_the_pixels() -> None:
    random = np.random.default_rng(0)
    pictures = [random.integers(10, 200, (12, 16, 3), np.uint8) for _ in range(4)]
    parts = [PixelCounts(), PixelCounts()]
    for number, picture in enumerate(pictures):
        parts[number % 2].add(picture)
    found = combined(parts).statistics()
    pixels = np.array(pictures).reshape(-1, 3) / 255.0
    assert found["count"] == [4]
    for name, expected in (
        ("min", pixels.min(0)),
        ("max", pixels.max(0)),
        ("mean", pixels.mean(0)),
        ("std", pixels.std(0)),
    ):
        assert np.array(found[name]).shape == (3, 1, 1)
        assert np.array(found[name]).ravel() == pytest.approx(expected), name
    for name, share in QUANTILES.items():
        assert np.array(found[name]).ravel() == pytest.approx(np.quantile(pixels, share, axis=0), abs=1.0 / 255.0)


def test_a_column_of_flags_has_the_share_of_true_as_its_mean() -> None:
    found = of_values(np.array([False, False, False, True]))
    assert (found["mean"], found["min"], found["max"], found["count"]) == ([0.25], [0.0], [1.0], [4])
