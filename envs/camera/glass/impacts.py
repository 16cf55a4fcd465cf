"""Number and sizes of raindrops that hit the windscreen."""

from math import cos, sin

import numpy as np

from vpf_sim.envs.camera.glass.pane import RAKE_RAD
from vpf_sim.types import Floats

SMALLEST_MM, LARGEST_MM = 0.5, 6.0  # smaller drops are part of the film
FOOTPRINT = 1.83  # diameter of the spot over that of the drop


class Impacts:
    """Impacts on the windscreen for rain of `rain_mmph`.

    Size distribution: N(D) = 8000 exp(-4.1 R^-0.21 D) / (m^3 mm) (Marshall and Palmer 1948). Fall speed:
    v(D) = 9.65 - 10.3 exp(-0.6 D) m/s (Atlas, Srivastava and Sekhon 1973). At speed V, glass with rake r is hit by
    N(D) (V sin r + v(D) cos r) drops per second and m^2.
    """

    def __init__(self, rain_mmph: float) -> None:
        self._edges = np.linspace(SMALLEST_MM, LARGEST_MM, 56)
        middle = (self._edges[1:] + self._edges[:-1]) / 2
        density = 8000.0 * np.exp(-4.1 * max(rain_mmph, 1e-6) ** -0.21 * middle) * np.diff(self._edges)
        self._by_speed = density * sin(RAKE_RAD)
        self._by_fall = density * (9.65 - 10.3 * np.exp(-0.6 * middle)) * cos(RAKE_RAD)

    def rates(self, speed_mps: float) -> Floats:
        """(56,) cumulative impacts / (s m^2) up to each class edge."""
        return np.concatenate([[0.0], np.cumsum(self._by_speed * speed_mps + self._by_fall)])

    def draw(self, rng: np.random.Generator, speed_mps: float, area_time: float) -> Floats:
        """Diameters, mm, of the drops that hit `area_time` m^2 s of glass."""
        rates = self.rates(speed_mps)
        count = rng.poisson(rates[-1] * area_time)
        diameters: Floats = np.interp(rng.random(count) * rates[-1], rates, self._edges)
        return diameters
