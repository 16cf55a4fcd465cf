"""Sensor faults: lost, late or corrupted frames, a stuck speedometer, yaw rate spikes.

They do not end an episode as `invalid_frame`: `ending` checks the frame before these faults.
"""

from collections import deque

import numpy as np

from vpf_sim.scenarios.parts import SensorFaults
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

BAND_SHARE = (0.05, 0.25)  # height of a noise band, share of the rows
TEAR_SHARE = (0.1, 0.9)  # row at which a frame tears, share of the rows from the top
EARLY_S = 1e-6  # tolerance of arrival times, which are multiples of 1 / rate
SPEED, YAW_RATE = 3, 4  # indices into the measured state


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
