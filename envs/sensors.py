"""What a real car's sensors make of its state and of its camera's frame; without errors both pass as they are."""

from math import exp, pi, radians, sqrt

import cv2
import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios.parts import Sensors as SensorErrors
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

BODY_HZ, BODY_DAMPING = 1.5, 0.3  # of a car's pitching on its springs (Gillespie, Fundamentals of Vehicle Dynamics)


class Sensors:
    """The sensors of one episode; each is read once a tick.

    Speed: scale and noise. Yaw rate: bias and noise. Pose: noise of each reading, and what satellite and inertial
    navigation cannot tell, a random walk. Camera: mounted askew, and pitching with the body as a damped oscillator that
    the road's unevenness drives; the frame is turned about the camera's centre by the homography K R K^-1, its rim
    repeated. The driver is told of none of it.
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
        self._pitch_rad = radians(errors.pitch_deg) * pitch
        self._pitch_radps = omega * radians(errors.pitch_deg) * rate
        self._walked = np.zeros(3)  # x, y, yaw

    def read(self, state: Floats) -> Floats:
        """(5,) x m, y m, yaw rad, speed m/s, yaw rate rad/s as they are measured."""
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

    def frame(self, taken: Image | None) -> Image | None:
        """(H, W, 3) the frame of the camera as it is mounted, at the body's pitch; None of a tick in which none is."""
        if self._errors.pitch_deg == self._errors.mounting_deg == 0.0:
            return taken
        self._pitch()
        if taken is None:
            return None
        turned = self._homography(self._mounting_rad + self._pitch_rad)
        size = (taken.shape[1], taken.shape[0])
        frame: Image = cv2.warpPerspective(taken, turned, size, borderMode=cv2.BORDER_REPLICATE).astype(np.uint8)
        return frame

    def _pitch(self) -> None:
        """p'' = -omega^2 p - 2 zeta omega p' + white noise, of which p has the standard deviation that is asked for."""
        omega, dt = 2.0 * pi * BODY_HZ, self._dt_s
        drive = radians(self._errors.pitch_deg) * sqrt(4.0 * BODY_DAMPING * omega**3 * dt)
        pull = omega**2 * self._pitch_rad * dt
        damped = self._pitch_radps * exp(-2.0 * BODY_DAMPING * omega * dt)
        self._pitch_radps = damped - pull + drive * float(self._bumps.standard_normal())
        self._pitch_rad += self._pitch_radps * dt

    def _homography(self, down_rad: float) -> Floats:
        """(3, 3) from the pixels of the camera to those of one that looks so much farther down."""
        camera, (c, s) = self._camera, (np.cos(down_rad), np.sin(down_rad))
        matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        found: Floats = matrix @ turn @ np.linalg.inv(matrix)
        return found
