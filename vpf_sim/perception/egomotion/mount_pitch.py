"""Mount pitch of the camera, by a Kalman filter of the pitches that the road's lines show in single frames.

A camera is mounted some tenths of a degree askew, a loaded car sits lower behind, and the road ahead may rise. At 0.005
rad the road 15 m ahead seems 8 cm too high and looks like an obstacle. The applied pitch changes in steps, and stays 0
for a good mounting: hard rain feigns up to 0.03 deg at first.
"""

from vpf_sim.perception.egomotion.egomotion_settings import MountPitchConfig


class MountPitch:
    """The constant part of the pitch: estimated and applied."""

    def __init__(self, config: MountPitchConfig) -> None:
        self._config = config
        self._found_rad, self._variance_rad2 = 0.0, config.first_sd_rad**2
        self._time_s: float | None = None
        self.pitch_rad = 0.0  # applied, + looks down

    def update(self, pitch_rad: float, sigma_rad: float, time_s: float) -> None:
        """Add an observation of the pitch with its standard deviation."""
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
