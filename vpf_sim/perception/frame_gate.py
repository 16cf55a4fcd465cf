"""Tells a frame to be looked at from one that shows nothing new or nothing true.

What a frame shows is taken for motion: of a frozen one the car seems to stand, of a torn or noisy one half of the
picture jumps. Each test asks for what no whole frame of a moving camera does, so that good frames pass.
"""

from collections import deque
from math import hypot, inf

import numpy as np

from vpf_sim.types import Bools, Floats, Image

SAMPLE_PX = 8  # between the pixels that are compared, in rows and in columns
FLAT_LEVELS = 8  # between the darkest and the brightest of them, below which a frame shows nothing
MOVED_M = 0.02  # of the car, after which no two frames are the same
NOISE_LEVELS, NOISE_ROWS = 50.0, 2  # mean difference of neighbouring rows, and how many such in a row
BRIGHTER = 1.25  # than the last frames, or darker, by which one jumps
LEVELS_OF = 5  # frames; the median of these takes up a lasting change
TORN_ROWS = 4  # of the sample, from below, that are those of the last frame
USUAL_SHARE, SETTLED = 0.3, 0.05  # of frames in which such rows stay anyway (a bonnet), and weight of the last frame


class FrameGate:
    """Compares each frame with those that arrived before it, good or not."""

    def __init__(self) -> None:
        self._time_s = -inf
        self._sample: Image | None = None
        self._changed_at_m = (0.0, 0.0)  # where the car was when the picture last changed
        self._stays: Floats = np.empty(0)  # (rows,) in what share of the frames each row stayed as it was
        self._levels: deque[float] = deque(maxlen=LEVELS_OF)

    def passes(self, image: Image, frame_time_s: float, place_m: tuple[float, float]) -> bool:
        """Whether an (H, W, 3) frame with that time stamp, taken at that place, is a new and whole picture."""
        if frame_time_s <= self._time_s:
            return False
        self._time_s = frame_time_s
        sample = image[::SAMPLE_PX, ::SAMPLE_PX].copy()
        changed = self._changed(sample, place_m)
        level = float(sample.mean())
        jumps = self._jumps(level)
        self._levels.append(level)
        return changed and not jumps and not _is_flat(sample) and not _has_noise(image)

    def _changed(self, sample: Image, place_m: tuple[float, float]) -> bool:
        """Whether all of the picture is new, as far as the car has moved since it last was."""
        last, self._sample = self._sample, sample
        if last is None or last.shape != sample.shape:
            self._changed_at_m, self._stays = place_m, np.full(len(sample), 0.5)
            return True
        same: Bools = (sample == last).all(axis=(1, 2))
        (x, y), (last_x, last_y) = place_m, self._changed_at_m
        moved = hypot(x - last_x, y - last_y) > MOVED_M
        if same.all():
            return not moved
        self._changed_at_m = place_m
        torn = moved and self._is_torn(same)
        if moved:
            self._stays += SETTLED * (same - self._stays)
        return not torn

    def _is_torn(self, same: Bools) -> bool:
        """Whether the lowest rows are those of the last frame, which they seldom are: `same` (rows,)."""
        below = len(same) if same.all() else int(np.argmin(same[::-1]))
        return below >= TORN_ROWS and float(self._stays[-below:].mean()) < USUAL_SHARE

    def _jumps(self, level: float) -> bool:
        """Whether a frame is much brighter or darker than the last ones."""
        if not self._levels:
            return False
        usual = float(np.median(self._levels))
        return not usual / BRIGHTER <= level <= usual * BRIGHTER


def _is_flat(sample: Image) -> bool:
    return int(sample.max()) - int(sample.min()) < FLAT_LEVELS


def _has_noise(image: Image) -> bool:
    """Whether rows of the frame have nothing to do with those beside them."""
    rows = image[:, ::SAMPLE_PX, 1].astype(np.int16)
    wild: Bools = np.abs(rows[1:] - rows[:-1]).mean(axis=1) > NOISE_LEVELS
    run = wild[: len(wild) - NOISE_ROWS + 1].copy()
    for k in range(1, NOISE_ROWS):
        run &= wild[k : len(wild) - NOISE_ROWS + 1 + k]
    return bool(run.any())
