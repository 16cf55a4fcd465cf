"""From the sensor to the file: rolling shutter, exposure control, text burnt in, compression."""

from math import exp

import cv2
import numpy as np

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Image

PERIOD_S = 0.1  # between measurements of the exposure
BEFORE = -1  # the period before the first
TARGET = 112.0  # mean grey level that the exposure control wants
WEAKEST, STRONGEST = 0.6, 1.7  # gains
TEXT_SHARE, TEXT_AT = 0.028, 0.015  # height of the text and distance from the edges, of the picture's height
LEAST_SHIFT_PX = 0.1  # of the first or last row; less cannot be seen, and costs as much
KMPH = 3.6


class ExposureControl:
    """Follows the picture's mean with a lag. It measures at fixed times, so that skipped frames change nothing."""

    def __init__(self, lag_s: float) -> None:
        self._gain = 1.0
        self._measured = BEFORE
        self._weight = 1.0 - exp(-PERIOD_S / lag_s) if lag_s > 0.0 else 0.0

    def is_due(self, time_s: float) -> bool:
        """Whether the picture of this moment is measured."""
        return self._weight > 0.0 and _period_at(time_s) > self._measured

    def apply(self, frame: Image, time_s: float) -> None:
        """Scale the frame in place by the present gain, and measure it if due."""
        if self._weight == 0.0:
            return
        if self.is_due(time_s):
            wanted = min(max(TARGET / max(float(frame.mean()), 1.0), WEAKEST), STRONGEST)
            self._gain += (1.0 if self._measured == BEFORE else self._weight) * (wanted - self._gain)
            self._measured = _period_at(time_s)
        cv2.convertScaleAbs(frame, frame, self._gain)


def _period_at(time_s: float) -> int:
    """The number of the period that a moment belongs to."""
    return int(time_s / PERIOD_S + 1e-6)


class Recorder:
    """Reads the rows one after another, burns in time and speed, and compresses."""

    def __init__(self, rig: Rig) -> None:
        self._readout_s = rig.rolling_shutter_ms / 1e3
        self._has_text = rig.overlay
        self._quality = rig.jpeg_quality
        self._fx_px, self._height_px = rig.camera.fx_px, rig.camera.height_px
        self._core = Core(rig.camera, ground_top(rig.camera))

    def read_out(self, frame: Image, now: Snapshot, before: Snapshot) -> Image:
        """(H, W, 3) the frame as a rolling shutter sees it while the car turns; the middle row is read now.

        The shift is that of distant points; translation and pitch are left out.
        """
        gap_s = now.time_s - before.time_s
        if self._readout_s <= 0.0 or gap_s <= 0.0:
            return frame
        turned_rad = wrap_angle(now.view.yaw_rad - before.view.yaw_rad)
        shear = self._fx_px * turned_rad / gap_s * self._readout_s / self._height_px  # px a row
        if abs(shear) * self._height_px < 2.0 * LEAST_SHIFT_PX:
            return frame
        return self._core.read_out(frame, shear)

    def record(self, frame: Image, now: Snapshot, before: Snapshot) -> Image:
        """(H, W, 3) the frame with its text, after compression."""
        if self._has_text:
            self._write(frame, now, before)
        if self._quality is None:
            return frame
        _, coded = cv2.imencode(
            ".jpg", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, self._quality]
        )
        decoded = np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR), np.uint8)
        return np.asarray(cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), np.uint8)

    def _write(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        gap_s = now.time_s - before.time_s
        way_m = float(np.linalg.norm(now.view.centre - before.view.centre))
        speed_kmph = KMPH * way_m / gap_s if gap_s > 0.0 else 0.0
        minutes, seconds = divmod(int(now.time_s), 60)
        text = f"2026-06-21 12:{minutes:02d}:{seconds:02d}  {speed_kmph:3.0f} km/h"
        tall, edge = TEXT_SHARE * len(frame), round(TEXT_AT * len(frame))
        for shift, colour in ((1, (0, 0, 0)), (0, (255, 255, 255))):  # white with a black shadow
            place = (edge + shift, len(frame) - 1 - edge + shift)
            cv2.putText(frame, text, place, cv2.FONT_HERSHEY_SIMPLEX, tall / 22.0, colour, 1, cv2.LINE_AA)
