"""The drops that rain throws on a windshield: how many, how large."""

from math import cos, sin

import numpy as np

from vpf_sim.envs.camera.glass.pane import RAKE_RAD
from vpf_sim.types import Floats

SMALLEST_MM, LARGEST_MM = 0.5, 6.0  # smaller ones are part of the film
FOOTPRINT = 1.83  # diameter of the spot on the glass / diameter of the drop that made it


class Impacts:
    """Impacts on the glass by rain of `rain_mmph`.

    Sizes in the air: N(D) = 8000 exp(-4.1 R^-0.21 D) / (m^3 mm) (Marshall and Palmer 1948). Fall speed
    v(D) = 9.65 - 10.3 exp(-0.6 D) m/s (Atlas, Srivastava and Sekhon 1973). A car of speed V meets
    N(D) (V sin r + v(D) cos r) of them a second and m^2 of glass with rake r.
    """

    def __init__(self, rain_mmph: float) -> None:
        self._edges = np.linspace(SMALLEST_MM, LARGEST_MM, 56)
        middle = (self._edges[1:] + self._edges[:-1]) / 2
        density = 8000.0 * np.exp(-4.1 * max(rain_mmph, 1e-6) ** -0.21 * middle) * np.diff(self._edges)
        self._by_speed = density * sin(RAKE_RAD)
        self._by_fall = density * (9.65 - 10.3 * np.exp(-0.6 * middle)) * cos(RAKE_RAD)

    def rates(self, speed_mps: float) -> Floats:
        """(56,) impacts / (s m^2) of drops smaller than each of the edges of the classes."""
        return np.concatenate([[0.0], np.cumsum(self._by_speed * speed_mps + self._by_fall)])

    def draw(self, rng: np.random.Generator, speed_mps: float, area_time: float) -> Floats:
        """Diameters (mm) of the drops that hit `area_time` m^2 s of glass."""
        rates = self.rates(speed_mps)
        count = rng.poisson(rates[-1] * area_time)
        diameters: Floats = np.interp(rng.random(count) * rates[-1], rates, self._edges)
        return diameters
