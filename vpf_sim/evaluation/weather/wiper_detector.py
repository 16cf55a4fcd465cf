"""Detects the wiper's blade: a new dark band from edge to edge of the image."""

from collections import deque

import cv2
import numpy as np

from vpf_sim.evaluation.weather.windscreen_spots import reduced
from vpf_sim.types import Camera, Image

FOCAL_PX = 20.0  # of the reduced image: a blade is a few pixels wide, and little else is visible
SAMPLE_S, SAMPLES, FEWEST = 0.1, 8, 4
DARKER = 15.0  # grey levels below the median of the samples, at least
DEVIATIONS = 4.0  # and this many median absolute deviations below it
HEIGHT_SHARE = 0.6  # least share of the image's height that a blade crosses
WIDTH_PX = 1.5  # least width in the reduced image, 4 deg: a post beside the road is thinner


class WiperDetector:
    """Finds the blade; receives every frame."""

    def __init__(self, camera: Camera, rate_hz: float) -> None:
        self._divisor = max(1, round(camera.fx_px / FOCAL_PX))
        self.shape = (camera.height_px // self._divisor, camera.width_px // self._divisor)
        self._every = max(1, round(SAMPLE_S * rate_hz))
        self._samples: deque[Image] = deque(maxlen=SAMPLES)
        self._frame = 0

    def update(self, image: Image) -> Image | None:
        """(h, w) mask of `shape`, 255 on the blade in the grey (H, W) frame; None without a blade."""
        small = reduced(image, self.shape, self._divisor)
        blade = self._detect(small) if len(self._samples) >= FEWEST else None
        if self._frame % self._every == 0:
            self._samples.append(small)
        self._frame += 1
        return blade

    def _detect(self, small: Image) -> Image | None:
        samples = np.array(self._samples, np.float32)
        usual = np.median(samples, axis=0)
        limit = np.maximum(DARKER, DEVIATIONS * np.median(np.abs(samples - usual), axis=0))
        dark = (usual - small > limit).astype(np.uint8)
        count, label, boxes, _ = cv2.connectedComponentsWithStats(dark)
        height, area = boxes[:, cv2.CC_STAT_HEIGHT], boxes[:, cv2.CC_STAT_AREA]
        is_blade = (height >= HEIGHT_SHARE * len(small)) & (area >= WIDTH_PX * height)
        blades = [k for k in range(1, count) if is_blade[k]]
        return np.isin(label, blades).astype(np.uint8) * 255 if blades else None
