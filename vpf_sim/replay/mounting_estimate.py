"""How the camera looks, from where it saw the car go: a prior, the sightings, an interval, and whether to use it.

Sightings of one stretch of road share their errors: of the turn, of the bodies in view, of the road's crown. So their
number counts by the time that they cover. A sighting in a bend tells the yaw only where the turn was measured: in the
flow, a turn and a direction to the side look much the same.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Camera, Floats

PRIOR_SD_RAD = (0.07, 0.05)  # pitch and yaw of cameras that people mount: 4 and 3 deg
CORRELATED_S = 0.3  # sightings so near to each other say the same
PERSISTENT_SD_RAD = 0.002  # of what all sightings of a drive share, that no number of them removes
LEAST_S, LEAST_M = 1.0, 10.0  # of way, without which nothing is used
WIDEST_RAD = 0.0175  # half of the interval (95 %), beyond which nothing is used: 1 deg
IN_95_PERCENT = 1.96
NORMAL = 1.48 / 2.0  # standard deviation of a normal distribution over its quartiles' range


@dataclass(frozen=True, slots=True)
class Angle:
    """One angle of the mounting, rad, its interval at 95 %, and on how much way it rests."""

    sd_rad: float
    rad: float = 0.0
    seconds: float = 0.0
    metres: float = 0.0

    @property
    def half_width_rad(self) -> float:
        return IN_95_PERCENT * self.sd_rad

    @property
    def is_used(self) -> bool:
        """Whether it is known well enough to turn the picture by it."""
        return self.half_width_rad <= WIDEST_RAD and self.seconds >= LEAST_S and self.metres >= LEAST_M

    @property
    def used_rad(self) -> float:
        return self.rad if self.is_used else 0.0


def angle(seen_rad: Floats, sd_rad: Floats, prior_sd_rad: float, seconds: float, metres: float) -> Angle:
    """The angle by M sightings (M,), each with its own standard deviation (M,), of so much way.

    The posterior of a normal prior about straight ahead. The sightings' median errs by what they scatter and by what
    the fit of each says of itself, over the root of the number of independent ones.
    """
    if not len(seen_rad):
        return Angle(prior_sd_rad)
    independent = min(float(len(seen_rad)), max(1.0, seconds / CORRELATED_S))
    scatter = NORMAL * float(np.subtract(*np.percentile(seen_rad, [75, 25])))
    variance = (1.25**2 * scatter**2 + float(np.median(sd_rad)) ** 2) / independent + PERSISTENT_SD_RAD**2
    share = prior_sd_rad**2 / (prior_sd_rad**2 + variance)
    return Angle(float(np.sqrt(share * variance)), share * float(np.median(seen_rad)), seconds, metres)


def angles_seen(camera: Camera, foe_px: Floats) -> tuple[Floats, Floats]:
    """(M,) pitch and (M,) yaw, rad, of cameras that see the car go there (M, 2)."""
    right, down = (foe_px - [camera.cx_px, camera.cy_px]).T / np.array([[camera.fx_px], [camera.fy_px]])
    return np.arctan(-down), -np.arctan(right * np.cos(np.arctan(down)))
