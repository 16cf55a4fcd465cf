"""Measurement errors of the car's sensors and of the camera's mounting; none by default.

Sensor faults: lost, late or corrupted frames, a stuck speedometer, yaw rate spikes.

They do not end an episode as `invalid_frame`: `ending` checks the frame before these faults.
"""

from collections import deque
from math import exp, pi, radians, sqrt

import cv2
import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios.parts import SensorFaults
from vpf_sim.scenarios.parts import Sensors as SensorErrors
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

BODY_HZ, BODY_DAMPING = 1.5, 0.3  # pitch of a sprung body (Gillespie, Fundamentals of Vehicle Dynamics)
BAND_SHARE = (0.05, 0.25)  # height of a noise band, share of the rows
TEAR_SHARE = (0.1, 0.9)  # row at which a frame tears, share of the rows from the top
EARLY_S = 1e-6  # tolerance of arrival times, which are multiples of 1 / rate
SPEED, YAW_RATE = 3, 4  # indices into the measured state


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


class CameraFaults:
    """The frames of one episode on their way from the camera to the driver; called once per tick.

    It keeps the last frame that has arrived with its exposure time stamp, as camera drivers do: while a frame is
    dropped or late, image and stamp stay the same. Frozen, black, torn and noisy frames have new stamps. The first
    frame is intact and arrives at once.
    """

    def __init__(self, faults: SensorFaults, rate_hz: float, seed: int) -> None:
        self._faults, self._seed = faults, seed
        self._chances = {name: stream(seed, f"sensor fault {name}") for name in ("drop", "black", "torn", "noise")}
        self._exposures = stream(seed, "sensor fault exposure")
        self._freezes = stream(seed, "sensor fault freeze")
        self._freeze_frames = max(1, round(faults.freeze_s * rate_hz))
        self._frozen_frames = 0  # left in the present freeze
        self._on_the_way: deque[tuple[Image, float]] = deque()
        self._exposed: Image | None = None  # the sensor's last image
        self._last: Image | None = None  # the last image that left the camera
        self._arrived: tuple[Image, float] | None = None  # the last that has arrived, with its time stamp

    def frame(self, image: Image, time_s: float) -> tuple[Image, float]:
        """(H, W, 3) the last frame that has arrived, and its exposure time, s."""
        if self._arrived is None:
            self._exposed = self._last = image
            self._arrived = image, time_s
            return self._arrived
        sent = self._with_faults(image)
        if not self._happens("drop", self._faults.drop_share):
            self._on_the_way.append((sent, time_s))
        latest_s = time_s - 1e-3 * self._faults.latency_ms + EARLY_S
        while self._on_the_way and self._on_the_way[0][1] <= latest_s:
            self._arrived = self._on_the_way.popleft()
        return self._arrived

    def _with_faults(self, image: Image) -> Image:
        """The frame with faults; the input is not changed."""
        assert self._exposed is not None
        assert self._last is not None
        faults, before = self._faults, self._last
        picture = self._exposed if self._is_frozen() else self._with_exposure_jump(image)
        self._exposed = picture
        torn, noisy = self._happens("torn", faults.torn_share), self._happens("noise", faults.noise_rows_share)
        if torn:
            picture = _torn(picture, before, self._chances["torn"])
        if noisy:
            picture = _with_noise(picture, self._chances["noise"])
        if self._happens("black", faults.black_share):
            picture = np.zeros_like(picture)
        self._last = picture
        return picture

    def _happens(self, name: str, share: float) -> bool:
        return share > 0.0 and bool(self._chances[name].random() < share)

    def _is_frozen(self) -> bool:
        """Whether the image is frozen; the rate of freezes follows from the share of all frames."""
        share, frames = self._faults.freeze_share, self._freeze_frames
        if share == 0.0:
            return False
        if self._frozen_frames == 0 and self._freezes.random() < share / (share + frames * (1.0 - share)):
            self._frozen_frames = frames
        frozen = self._frozen_frames > 0
        self._frozen_frames -= frozen
        return frozen

    def _with_exposure_jump(self, image: Image) -> Image:
        """(H, W, 3) the frame, at times overexposed or underexposed."""
        if self._faults.exposure_jump_share == 0.0 or self._exposures.random() >= self._faults.exposure_jump_share:
            return image
        stops = self._faults.exposure_jump_stops * (1.0 if self._exposures.random() < 0.5 else -1.0)
        brighter: Image = np.minimum(np.rint(image * 2.0**stops), 255.0).astype(np.uint8)
        return brighter


class SignalFaults:
    """Faults of the speedometer and the yaw rate sensor; read once per tick."""

    def __init__(self, faults: SensorFaults, seed: int) -> None:
        self._faults = faults
        self._random = stream(seed, "sensor fault yaw rate")
        self._stuck_mps: float | None = None

    def read(self, measured: Floats, time_s: float) -> Floats:
        """(5,) x m, y m, yaw rad, speed m/s, yaw rate rad/s with faults."""
        faults = self._faults
        if not faults.affect_signals:
            return measured
        reported = measured.copy()
        if faults.speed_stuck_after_s is not None and time_s >= faults.speed_stuck_after_s - EARLY_S:
            if self._stuck_mps is None:
                self._stuck_mps = float(reported[SPEED])
            reported[SPEED] = self._stuck_mps
        if faults.yaw_rate_spike_share > 0.0 and self._random.random() < faults.yaw_rate_spike_share:
            reported[YAW_RATE] += faults.yaw_rate_spike_radps * (1.0 if self._random.random() < 0.5 else -1.0)
        return reported


def _torn(picture: Image, before: Image, random: np.random.Generator) -> Image:
    """The image above a random row and the previous one below it."""
    row = round(float(random.uniform(*TEAR_SHARE)) * len(picture))
    return np.concatenate([picture[:row], before[row:]])


def _with_noise(picture: Image, random: np.random.Generator) -> Image:
    """The image with a band of noise rows."""
    height = max(1, round(float(random.uniform(*BAND_SHARE)) * len(picture)))
    top = int(random.integers(len(picture) - height + 1))
    noisy = picture.copy()
    noisy[top : top + height] = random.integers(256, size=noisy[top : top + height].shape, dtype=np.uint8)
    return noisy
