"""Measurement errors of the car's sensors and of the camera's mounting; none by default."""

from math import exp, pi, radians, sqrt

import cv2
import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios.parts import Sensors as SensorErrors
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

BODY_HZ, BODY_DAMPING = 1.5, 0.3  # pitch of a sprung body (Gillespie, Fundamentals of Vehicle Dynamics)


class Sensors:
    """The sensors of one episode; each is read once per tick.

    Speed: scale and noise. Yaw rate: bias and noise. Pose: white noise and a random walk. Camera: a mounting error, and
    the body's pitch as a damped oscillator driven by the road; the homography K R K^-1 rotates the frame about the
    camera's centre, with replicated borders. The driver does not know these errors.
    """

    def __init__(self, errors: SensorErrors, camera: Camera, rate_hz: float, seed: int) -> None:
        self._errors, self._camera, self._dt_s = errors, camera, 1.0 / rate_hz
        self.are_exact = errors == SensorErrors()
        self._random, self._bumps = stream(seed, "sensors"), stream(seed, "pitch")
        scale, bias = self._random.standard_normal(2).tolist()
        mounting, pitch, rate = self._bumps.standard_normal(3).tolist()
        omega = 2.0 * pi * BODY_HZ
        self._scale = 1.0 + errors.speed_scale * scale
        self._bias_radps = errors.yaw_rate_bias_radps * bias
        self._mounting_rad = radians(errors.mounting_deg) * mounting
        self.pitch_rad = radians(errors.pitch_deg) * pitch  # of the body, > 0 down
        self._pitch_radps = omega * radians(errors.pitch_deg) * rate
        self._walked = np.zeros(3)  # x, y, yaw

    def read(self, state: Floats) -> Floats:
        """(5,) measured x m, y m, yaw rad, speed m/s, yaw rate rad/s."""
        if self.are_exact:
            return state
        errors = self._errors
        walk = [errors.position_walk_m, errors.position_walk_m, radians(errors.heading_walk_deg)]
        self._walked += sqrt(self._dt_s) * np.array(walk) * self._random.standard_normal(3)
        noise = self._random.standard_normal(5) * [
            errors.position_noise_m,
            errors.position_noise_m,
            radians(errors.heading_noise_deg),
            errors.speed_noise_mps,
            errors.yaw_rate_noise_radps,
        ]
        x, y, yaw = (state[:3] + self._walked + noise[:3]).tolist()
        speed = max(0.0, self._scale * float(state[3]) + float(noise[3]))
        return np.array([x, y, -wrap_angle(-yaw), speed, state[4] + self._bias_radps + noise[4]])

    def frame(self, image: Image | None) -> Image | None:
        """(H, W, 3) the frame with mounting error and body pitch; None for a tick without a frame."""
        if self._errors.pitch_deg == self._errors.mounting_deg == 0.0:
            return image
        self._step_pitch()
        if image is None:
            return None
        turned = self._homography(self._mounting_rad + self.pitch_rad)
        size = (image.shape[1], image.shape[0])
        frame: Image = cv2.warpPerspective(image, turned, size, borderMode=cv2.BORDER_REPLICATE).astype(np.uint8)
        return frame

    def _step_pitch(self) -> None:
        """One step of p'' = -omega^2 p - 2 zeta omega p' + white noise scaled to p's standard deviation."""
        omega, dt = 2.0 * pi * BODY_HZ, self._dt_s
        drive = radians(self._errors.pitch_deg) * sqrt(4.0 * BODY_DAMPING * omega**3 * dt)
        pull = omega**2 * self.pitch_rad * dt
        damped = self._pitch_radps * exp(-2.0 * BODY_DAMPING * omega * dt)
        self._pitch_radps = damped - pull + drive * float(self._bumps.standard_normal())
        self.pitch_rad += self._pitch_radps * dt

    def _homography(self, pitch_rad: float) -> Floats:
        """(3, 3) homography from the camera's pixels to those of a camera pitched down by `pitch_rad`."""
        camera, (c, s) = self._camera, (np.cos(pitch_rad), np.sin(pitch_rad))
        matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        found: Floats = matrix @ turn @ np.linalg.inv(matrix)
        return found
