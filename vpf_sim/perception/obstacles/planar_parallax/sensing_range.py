"""How far ahead a low body would be suspected by now: by what the looks at the road could have made out.

What stands on the road changes its layout the more the nearer it is, and the more contrast it has. Haze and dusk take
contrast from a body and from the grain of the road alike, so the difference that a pallet makes is told in multiples of
the grain's. A look makes one out at a place if that is more than the look's noise asks, and if no water hides the place
(`planar_parallax.detector`). It is suspected after several such looks (`planar_parallax.tracker`): coming nearer at
speed v with a look each T, the car takes p(x) dx / (v T) of them on a way dx, p the share of looks that would do.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class SensingRangeConfig:
    """The difference that a pallet 0.12 to 0.15 m high makes, and how looks are averaged."""

    grains: float = 30.0  # of the fainter pallets, in multiples of what the grain makes, grey levels^2,
    grains_at_m: float = 9.0  # from the pose;
    power: float = 3.4  # it falls with this power of the distance
    far_m: float = 12.5  # from where on few looks tell its height: pixels of the older frame are long
    step_m: float = 0.25
    half_width_m: float = 1.5  # of the strip of road ahead that is judged
    spare_looks: float = 1.5  # more than it takes: looks are averaged, and fail by chance
    good_share: float = 0.85  # of looks that make one out on a dry, grainy road: some fail in any weather
    looks: float = 12.0  # averaged over,
    grain_looks: float = 50.0  # and for the grain: mirror images pass, it stays

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")


@dataclass(frozen=True, slots=True)
class LookQuality:
    """What one look at the road could have made out."""

    noise: float  # difference that a body has to exceed to be suspected, squared grey levels
    grain: float  # difference that the road's grain alone makes
    seen: Floats  # (K,) share of the road ahead that was seen at each place


class SensingRange:
    """Averages over the looks. Before the first, the road is believed to be seen well."""

    def __init__(self, config: SensingRangeConfig, near_m: float, period_s: float) -> None:
        self.config = config
        self.forward_m: Floats = np.arange(near_m, config.far_m, config.step_m)
        self._period_s = period_s  # between looks
        self._share = np.ones(len(self.forward_m))  # of looks that make a low body out
        self._passed_m = self._way_with_hits(self._share)
        self._good_m = self._way_with_hits(np.full(len(self.forward_m), config.good_share))
        self._grain: float | None = None

    def record(self, look: LookQuality) -> None:
        """Take in one look."""
        config = self.config
        if self._grain is None:
            self._grain = look.grain
        self._grain += (look.grain - self._grain) / config.grain_looks
        difference = config.grains * self._grain * (config.grains_at_m / self.forward_m) ** config.power
        self._share += (np.where(difference > look.noise, look.seen, 0.0) - self._share) / config.looks
        self._passed_m = self._way_with_hits(self._share)

    def needed_m(self, speed_mps: float, sightings: int) -> float:
        """m of way with looks that make a body out, until one is suspected that takes so many."""
        return (sightings + self.config.spare_looks) * self._period_s * speed_mps

    def distance_m(self, needed_m: float) -> float:
        """m from the pose, at which a low body would be suspected that takes so much of the way; 0 if none."""
        return self._where(self._passed_m, needed_m)

    def good_m(self, needed_m: float) -> float:
        """The same of a good view, `good_share` of whose looks would make one out, wherever it is."""
        return self._where(self._good_m, needed_m)

    def _way_with_hits(self, share: Floats) -> Floats:
        """(K,) m, on coming as near as each place."""
        passed: Floats = np.cumsum(share[::-1])[::-1] * self.config.step_m
        return passed

    def _where(self, passed_m: Floats, needed_m: float) -> float:
        if passed_m[0] < needed_m:
            return 0.0
        return float(np.interp(needed_m, passed_m[::-1], self.forward_m[::-1]))
