"""Sensing range of low obstacles: how far ahead one would be a tentative track by now.

An obstacle's difference grows with its contrast and as it comes nearer. Haze and dusk lower its contrast and the
grain's alike, so it is given in multiples of the grain's. An observation detects it where it exceeds the noise and no
water hides it. At speed v, with an observation each T, the car makes p(x) dx / (v T) of these on a way dx, p the share
of observations that detect it.
"""

import numpy as np

from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import SensingRangeConfig
from vpf_sim.types import Floats


class SensingRange:
    """Sensing range by averages over observations. Before the first, the view counts as good."""

    def __init__(self, config: SensingRangeConfig, near_m: float, period_s: float) -> None:
        self.config = config
        self.forward_m: Floats = np.arange(near_m, config.far_m, 0.25)
        self._period_s = period_s  # between observations
        self._share = np.ones(len(self.forward_m))  # of observations that detect a low obstacle
        self._passed_m = self._way_with_hits(self._share)
        self._good_m = self._way_with_hits(np.full(len(self.forward_m), config.good_share))
        self._grain: float | None = None

    def record(self, noise: float, grain: float, visible: Floats) -> None:
        """Add one observation: squared grey levels of noise and grain, (K,) visible share of the road at each place."""
        config = self.config
        if self._grain is None:
            self._grain = grain
        self._grain += (grain - self._grain) / config.grain_looks
        difference = config.grains * self._grain * (config.grains_at_m / self.forward_m) ** config.power
        self._share += (np.where(difference > noise, visible, 0.0) - self._share) / config.looks
        self._passed_m = self._way_with_hits(self._share)

    def distance_m(self, speed_mps: float, sightings: int) -> float:
        """m from the pose, up to which an obstacle would be a track by now; 0: nowhere."""
        return self._range_m(self._passed_m, speed_mps, sightings)

    def good_m(self, speed_mps: float, sightings: int) -> float:
        """The same where `good_share` of the observations detect an obstacle everywhere."""
        return self._range_m(self._good_m, speed_mps, sightings)

    def _way_with_hits(self, share: Floats) -> Floats:
        """(K,) m of way with observations that detect an obstacle, up to each place."""
        passed: Floats = np.cumsum(share[::-1])[::-1] * (self.forward_m[1] - self.forward_m[0])
        return passed

    def _range_m(self, passed_m: Floats, speed_mps: float, sightings: int) -> float:
        needed_m = (sightings + self.config.spare_looks) * self._period_s * speed_mps
        return 0.0 if passed_m[0] < needed_m else float(np.interp(needed_m, passed_m[::-1], self.forward_m[::-1]))
