"""The wiper's blade: a dark band from edge to edge of the picture that was not there a moment ago."""

from collections import deque

import cv2
import numpy as np

from vpf_sim.evaluation.weather.windscreen_spots import reduced
from vpf_sim.types import Camera, Image

FOCAL_PX = 20.0  # of the picture that is looked at: a blade is a few pixels wide, and hardly anything else is left
SAMPLE_S, SAMPLES, FEWEST = 0.1, 8, 4
DARKER = 15.0  # grey levels than the median of the samples, at least, and
DEVIATIONS = 4.0  # median absolute deviations
HEIGHT_SHARE = 0.6  # of the picture's, that a blade crosses at least
WIDTH_PX = 1.5  # of the reduced picture, at least: 4 deg; a post beside the road is thinner


class WiperDetector:
    """Is shown every frame, and tells where a blade is."""

    def __init__(self, camera: Camera, rate_hz: float) -> None:
        self._divisor = max(1, round(camera.fx_px / FOCAL_PX))
        self.shape = (camera.height_px // self._divisor, camera.width_px // self._divisor)
        self._every = max(1, round(SAMPLE_S * rate_hz))
        self._samples: deque[Image] = deque(maxlen=SAMPLES)
        self._frame = 0

    def update(self, image: Image) -> Image | None:
        """(h, w) 255 where the blade is in the grey (H, W) frame, in a picture of `shape`; None where there is none."""
        small = reduced(image, self.shape, self._divisor)
        blade = self._look(small) if len(self._samples) >= FEWEST else None
        if self._frame % self._every == 0:
            self._samples.append(small)
        self._frame += 1
        return blade

    def _look(self, small: Image) -> Image | None:
        samples = np.array(self._samples, np.float32)
        usual = np.median(samples, axis=0)
        limit = np.maximum(DARKER, DEVIATIONS * np.median(np.abs(samples - usual), axis=0))
        dark = (usual - small > limit).astype(np.uint8)
        count, label, boxes, _ = cv2.connectedComponentsWithStats(dark)
        height, area = boxes[:, cv2.CC_STAT_HEIGHT], boxes[:, cv2.CC_STAT_AREA]
        like_a_blade = (height >= HEIGHT_SHARE * len(small)) & (area >= WIDTH_PX * height)
        blades = [k for k in range(1, count) if like_a_blade[k]]
        return np.isin(label, blades).astype(np.uint8) * 255 if blades else None
