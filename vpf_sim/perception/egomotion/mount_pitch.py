"""How far the camera looks below where it is believed to, told by the road's lines, and taken over slowly.

A camera is mounted some tenths of a degree askew, a car sits lower behind when it is loaded, and the road ahead may
rise. Whichever it is, the plane of the road is turned against the one that is believed in: by 0.005 rad the road 15 m
ahead seems to lie 8 cm below or above its place, and is a body. Parallel lines tell the turn in a single frame
(`perception.road.model`), each frame anew: here their word is gathered by a scalar Kalman filter. What is believed
changes in steps only, and flow and frames stay as they are where a camera looks where it should: hard rain pretends up
to 0.03 deg at first, while nothing else is known.
"""

from math import sqrt

from vpf_sim.perception.egomotion.config import MountPitchConfig


class MountPitch:
    """The constant part of the pitch, as it is known and as it is believed."""

    def __init__(self, config: MountPitchConfig) -> None:
        self._config = config
        self._found_rad, self._variance_rad2 = 0.0, config.first_sd_rad**2
        self._time_s: float | None = None
        self.pitch_rad = 0.0  # + looks down; what is believed

    @property
    def sigma_rad(self) -> float:
        """Standard deviation of what is known."""
        return sqrt(self._variance_rad2)

    def update(self, pitch_rad: float, sigma_rad: float, time_s: float) -> None:
        """A look says that the camera looks so far down, with that standard deviation of its own."""
        config = self._config
        if self._time_s is not None:
            self._variance_rad2 += config.drift_sd_rad**2 * (time_s - self._time_s)
        self._time_s = time_s
        gain = self._variance_rad2 / (self._variance_rad2 + sigma_rad**2 + config.look_sd_rad**2)
        self._found_rad += gain * (pitch_rad - self._found_rad)
        self._variance_rad2 *= 1.0 - gain
        if abs(self._found_rad) < config.least_rad * (1.0 if self.pitch_rad == 0.0 else 0.5):
            self.pitch_rad = 0.0
        elif abs(self._found_rad - self.pitch_rad) >= config.step_rad:
            self.pitch_rad = self._found_rad
