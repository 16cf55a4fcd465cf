"""Estimates a mounting angle from observed directions of travel: prior, observations, interval.

Observations on one stretch of road share errors of turn, scene and road crown, so their number counts by the time
that they cover. In a bend they give the yaw only if the yaw rate was recorded: in the flow, a turn looks like a
sideways direction.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Camera, Floats

PRIOR_SD_RAD = (0.07, 0.05)  # of pitch and yaw in usual mountings: 4 and 3 deg
CORRELATED_S = 0.3  # observations within this time are not independent
PERSISTENT_SD_RAD = 0.002  # error that all observations of a drive share
LEAST_S = 1.0  # of driving, below which no angle is used
WIDEST_RAD = 0.0175  # half width of the 95 % interval, above which no angle is used: 1 deg
IN_95_PERCENT = 1.96
NORMAL = 1.48 / 2.0  # standard deviation over interquartile range, normal distribution


@dataclass(frozen=True, slots=True)
class Angle:
    """One mounting angle, rad, with its 95 % interval and the driving that supports it."""

    sd_rad: float
    rad: float = 0.0
    seconds: float = 0.0

    @property
    def half_width_rad(self) -> float:
        return IN_95_PERCENT * self.sd_rad

    @property
    def interval_deg(self) -> tuple[float, float]:
        low, high = np.degrees([self.rad - self.half_width_rad, self.rad + self.half_width_rad])
        return float(low), float(high)

    @property
    def is_used(self) -> bool:
        """Whether it is certain enough to rotate the image by it; speed and scale do not matter for an angle."""
        return self.half_width_rad <= WIDEST_RAD and self.seconds >= LEAST_S

    @property
    def used_rad(self) -> float:
        return self.rad if self.is_used else 0.0


def angle(observed_rad: Floats, sd_rad: Floats, prior_sd_rad: float, seconds: float) -> Angle:
    """Posterior of an angle from M observations (M,) with standard deviations (M,).

    The prior is normal about straight ahead. The error of the observations' median follows from their scatter and
    their own standard deviations, divided by the root of the number of independent ones.
    """
    if not len(observed_rad):
        return Angle(prior_sd_rad)
    independent = min(float(len(observed_rad)), max(1.0, seconds / CORRELATED_S))
    scatter = NORMAL * float(np.subtract(*np.percentile(observed_rad, [75, 25])))
    variance = (1.25**2 * scatter**2 + float(np.median(sd_rad)) ** 2) / independent + PERSISTENT_SD_RAD**2
    share = prior_sd_rad**2 / (prior_sd_rad**2 + variance)
    return Angle(float(np.sqrt(share * variance)), share * float(np.median(observed_rad)), seconds)


def observed_angles(camera: Camera, foe_px: Floats) -> tuple[Floats, Floats]:
    """(M,) pitch and (M,) yaw, rad, of cameras that see these directions of travel (M, 2) px."""
    right, down = (foe_px - [camera.cx_px, camera.cy_px]).T / np.array([[camera.fx_px], [camera.fy_px]])
    return np.arctan(-down), -np.arctan(right * np.cos(np.arctan(down)))
