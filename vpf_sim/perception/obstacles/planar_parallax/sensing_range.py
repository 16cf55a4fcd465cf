"""Sensing range of low obstacles: how far ahead one would be a tentative track by now.

An obstacle changes the layout of the road more the nearer it is and the more contrast it has. Haze and dusk take
contrast from it and from the road's grain alike, so its difference is given in multiples of the grain's. An observation
detects it at a place if that exceeds the noise, and if no water hides the place (`planar_parallax.detector`). A track
needs several (`planar_parallax.tracker`): at speed v, with an observation each T, the car makes p(x) dx / (v T) of them
on a way dx, p the share of observations that detect it.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.obstacles.planar_parallax.config import SensingRangeConfig
from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class LookQuality:
    """What one observation of the road could have detected."""

    noise: float  # squared grey levels, that an obstacle's difference must exceed
    grain: float  # squared grey levels, difference of the road's grain
    seen: Floats  # (K,) share of the road ahead that was visible at each place


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

    def record(self, look: LookQuality) -> None:
        """Add one observation."""
        config = self.config
        if self._grain is None:
            self._grain = look.grain
        self._grain += (look.grain - self._grain) / config.grain_looks
        difference = config.grains * self._grain * (config.grains_at_m / self.forward_m) ** config.power
        self._share += (np.where(difference > look.noise, look.seen, 0.0) - self._share) / config.looks
        self._passed_m = self._way_with_hits(self._share)

    def needed_m(self, speed_mps: float, sightings: int) -> float:
        """m of way with good observations that a track needs for so many sightings."""
        return (sightings + self.config.spare_looks) * self._period_s * speed_mps

    def distance_m(self, needed_m: float) -> float:
        """m from the pose, where an obstacle that needs so much of the way would be a track; 0: nowhere."""
        return self._where(self._passed_m, needed_m)

    def good_m(self, needed_m: float) -> float:
        """The same with a good view, where `good_share` of the observations detect it everywhere."""
        return self._where(self._good_m, needed_m)

    def _way_with_hits(self, share: Floats) -> Floats:
        """(K,) m, up to each place."""
        passed: Floats = np.cumsum(share[::-1])[::-1] * (self.forward_m[1] - self.forward_m[0])
        return passed

    def _where(self, passed_m: Floats, needed_m: float) -> float:
        if passed_m[0] < needed_m:
            return 0.0
        return float(np.interp(needed_m, passed_m[::-1], self.forward_m[::-1]))
