"""Quantiles are those of numpy to the bit, whatever the values' type and number."""

import numpy as np
import pytest

from vpf_sim.perception.quantiles import median, quantile
from vpf_sim.seeding import stream


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.uint8])
def test_quantiles_are_numpys(kind: type[np.generic]) -> None:
    random = stream(0, "quantiles")
    for count in range(1, 60):
        values = (40.0 + 9.0 * random.standard_normal((count, 3))).astype(kind)
        for share in (0.0, 0.05, 0.1, 0.5, 0.75, 0.9, 0.95, 1.0):
            assert quantile(values, share) == np.quantile(values, [share])[0]


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_medians_are_numpys(kind: type[np.generic]) -> None:
    random = stream(0, "medians")
    for count in range(1, 60):
        values = random.standard_normal(count).astype(kind)
        assert median(values) == float(np.median(values))
