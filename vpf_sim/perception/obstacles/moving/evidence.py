"""What one look says for a body that moves, or against it: log-odds from its points, one by one.

Against it stand two other readings of the same points. What stands and lies on the road is told by its track alone. The
mirror image of what stands on the wet road lies below the road as well, and moves like a body that drives: with w its
inverse depth it cannot be told from one by any track while we drive straight on. But a wet road reflects a small share
of the light at the angles at which it is looked at (Fresnel), and smears it: a mirror image has a fraction of the
contrast of what stands in the picture, a body has as much. How far that counts depends on how much the road mirrors: on
a dry road hardly a point lies below it that is of no body (`Mirror`), and a dark car is as good as any that is not as
faint as far asphalt. And it counts by where what is mirrored would have to stand: at the inverse depth w, beside the
road as a rule. Where that is on the road, as for a car ahead, hardly anything stands, and a body only has to have more
contrast than its own mirror image, which joins it at the foot and would move the foot towards us. The weights are
chosen by when tentative of development drives, in clear weather and in rain, were believed with them.
"""

from dataclasses import dataclass
from math import exp

import numpy as np

from vpf_sim.perception.quantiles import median, quantile
from vpf_sim.types import Bools, Floats


@dataclass(frozen=True, slots=True)
class EvidenceConfig:
    """What the points of a look weigh, as log-odds of the look."""

    cap: float = 16.0  # chi2 of a track that nothing explains
    speaks_for: float = 3.0  # log-odds of a track between moving and standing from which it speaks for the body,
    speaks_against: float = 1.0  # and from which against it
    low_m: float = 0.1  # heights between which a body's points are no one else's
    high_m: float = 1.25
    per_for: float = 0.6  # times ln(1 + count) of tracks that speak for it,
    per_against: float = 0.4  # against it,
    per_other: float = 0.3  # and of neither
    per_contrast: float = 3.7  # times the upper quartile of their contrast,
    wet_faint: float = -0.5  # less this, below which it speaks against it, on a road that mirrors,
    dry_faint: tuple[float, float] = (-2.5, -1.5)  # and on a dry one, where what is
    faint_m: tuple[float, float] = (15.0, 20.0)  # so far off may be asphalt
    wet_image: float = -1.2  # contrast below which points are of a body's mirror image, on a road that mirrors,
    dry_image: float = -4.0  # and on a dry one;
    image_fainter: float = 1.1  # of a faint body below that of its points by so much
    image_above_m: float = 0.5  # that are higher than this; but what is as faint as an image up there is one itself,
    image_ramp: float = 0.3  # and less so by this contrast
    dry_share: float = 0.12  # of the points on the road that lie below it and are of no body: on a dry road,
    wet_share: float = 0.27  # and on one that mirrors
    share_s: float = 2.0  # time constant of that share
    least_share: float = 0.5  # of those for it in those against it; with less it shines through
    least: float = -1.0  # of a look
    most: float = 2.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.dry_share < self.wet_share:
            raise ValueError(f"dry_share: expected 0 <= dry_share < wet_share = {self.wet_share}, got {self.dry_share}")
        if not self.dry_image < self.wet_image:
            raise ValueError(f"dry_image: expected < wet_image = {self.wet_image}, got {self.dry_image}")
        if not self.image_ramp > 0.0:
            raise ValueError(f"image_ramp: expected > 0, got {self.image_ramp}")
        if not self.faint_m[0] < self.faint_m[1]:
            raise ValueError(f"faint_m: expected two increasing distances, got {self.faint_m}")

    def faint(self, mirror: float, depth_m: float) -> float:
        """The contrast below which points so far off speak against a body, on a road that mirrors so far, 0 to 1."""
        dry = float(np.interp(depth_m, self.faint_m, self.dry_faint))
        return dry + mirror * (self.wet_faint - dry)

    def image(self, mirror: float, upper: Floats) -> float:
        """The contrast below which points are of a body's own mirror image, on a road that mirrors so far, 0 to 1.

        `upper` (N,) is the contrast of its points above `image_above_m`: of a dark car all is faint, and its image
        fainter still.
        """
        own = median(upper) if len(upper) else self.wet_image
        dark = min(own - self.image_fainter - self.wet_image, 0.0)
        is_body = min(max((own - self.wet_image) / self.image_ramp, 0.0), 1.0)
        return self.dry_image + mirror * (self.wet_image + is_body * dark - self.dry_image)


class Mirror:
    """How far the road mirrors, from 0 to 1: by the share of the points on it that lie below it and are of no body."""

    def __init__(self, config: EvidenceConfig, look_s: float) -> None:
        self._config = config
        self._kept = exp(-look_s / config.share_s)
        self._below, self._all = 20.0, 50.0  # until it is known, it mirrors

    def update(self, below: int, count: int) -> None:
        """A look at `count` points on the road and outside of all bodies, of which so many lie below it.

        One at none, standing, leaves the road as it is known.
        """
        if not count:
            return
        self._below, self._all = self._kept * self._below + below, self._kept * self._all + count

    @property
    def degree(self) -> float:
        """0 on a dry road, 1 on a wet one."""
        dry, wet = self._config.dry_share, self._config.wet_share
        return min(max((self._below / max(self._all, 1.0) - dry) / (wet - dry), 0.0), 1.0)


def evidence(
    inside: Bools, moving: Floats, standing: Floats, contrast: Floats, faint: float, config: EvidenceConfig
) -> float:
    """Log-odds of a look at N points, of which those `inside` (N,) the body's outline count.

    A track has the chi2 `moving` (N,) as one of the body and `standing` (N,) as one that stands; `contrast` (N,) is the
    logarithm of its squared gradients, as a share of those of what stands upright in the picture, and speaks against it
    below `faint`.
    """
    odds = 0.5 * (np.minimum(standing, config.cap) - np.minimum(moving, config.cap))[inside]
    speaks = odds > config.speaks_for
    number_for, number_against = np.count_nonzero(speaks), np.count_nonzero(odds < -config.speaks_against)
    if number_for <= config.least_share * number_against:
        return config.least
    other = len(odds) - number_for - number_against
    sharp = quantile(contrast[inside][speaks], 0.75)
    value = config.per_contrast * (sharp - faint)
    value += config.per_for * np.log1p(number_for) - config.per_against * np.log1p(number_against)
    return float(min(max(value - config.per_other * np.log1p(other), config.least), config.most))
