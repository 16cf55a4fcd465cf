"""Passes valid frames; frozen, torn, noisy, flat ones and brightness jumps would be taken for motion.

Each test asks for what no valid frame of a moving camera shows.
"""

from collections import deque
from math import hypot, inf

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.types import Bools, Floats, Image


@settings
class NoisyFrameConfig:
    row_levels: float = setting("Mean difference of neighbouring rows that are unrelated, in grey levels.", gt=0.0)
    rows: int = setting("Number of unrelated rows in sequence that make a frame noisy.", ge=1)


@settings
class BrightnessJumpConfig:
    ratio: float = setting("Largest ratio of the mean grey level to that of the last frames, or its inverse.", gt=1.0)
    frames: int = setting(
        "Number of last frames whose median counts: a lasting change is accepted after half of them.", ge=1
    )


@settings
class TornFrameConfig:
    rows: int = setting("Least number of sampled rows at the bottom that repeat the last frame.", ge=1)
    usual_share: float = setting("Share of frames in which these rows may repeat, as a bonnet does.", gt=0.0, lt=1.0)
    settled: float = setting(
        "Weight of the last frame in the share of frames whose bottom rows repeat.", gt=0.0, le=1.0
    )


@settings
class FrameGateConfig:
    sample_px: int = setting("Spacing of the compared pixels, in rows and columns.", ge=1)
    flat_levels: int = setting("Least difference of the brightest and darkest grey level.", ge=0)
    moved_m: float = setting("Travel of the car after which no two frames are equal.", gt=0.0)
    noise: NoisyFrameConfig = setting("Does not process noisy frames.")
    jump: BrightnessJumpConfig = setting("Does not process frames that are much brighter or darker.")
    torn: TornFrameConfig = setting("Does not process frames that end with a part of the last frame.")


class FrameGate:
    """Compares each frame with those before it, valid or not."""

    def __init__(self, config: FrameGateConfig) -> None:
        self._config = config
        self._time_s = -inf
        self._sample: Image | None = None
        self._changed_at_m = (0.0, 0.0)  # of the car when the image last changed
        self._stays: Floats = np.empty(0)  # (rows,) share of the frames in which each row repeats
        self._levels: deque[float] = deque(maxlen=config.jump.frames)

    def passes(self, image: Image, frame_time_s: float, place_m: tuple[float, float]) -> bool:
        """Whether an (H, W, 3) frame, taken at this time and place, is new and valid."""
        if frame_time_s <= self._time_s:
            return False
        self._time_s = frame_time_s
        step = self._config.sample_px
        sample = image[::step, ::step].copy()
        changed = self._changed(sample, place_m)
        level = float(sample.mean())
        jumps = self._jumps(level)
        self._levels.append(level)
        flat = int(sample.max()) - int(sample.min()) < self._config.flat_levels
        return changed and not (jumps or flat or self._has_noise(image))

    def _changed(self, sample: Image, place_m: tuple[float, float]) -> bool:
        """Whether all of the image is new, or the car has not moved since it last was."""
        last, self._sample = self._sample, sample
        if last is None or last.shape != sample.shape:
            self._changed_at_m, self._stays = place_m, np.full(len(sample), 0.5)
            return True
        same: Bools = (sample == last).all(axis=(1, 2))
        (x, y), (last_x, last_y) = place_m, self._changed_at_m
        moved = hypot(x - last_x, y - last_y) > self._config.moved_m
        if same.all():
            return not moved
        self._changed_at_m = place_m
        config = self._config.torn
        if not moved:
            return True
        below = int(np.argmin(same[::-1]))  # the lowest rows that repeat the last frame
        torn = below >= config.rows and float(self._stays[-below:].mean()) < config.usual_share
        self._stays += config.settled * (same - self._stays)
        return not torn

    def _jumps(self, level: float) -> bool:
        """Whether a frame is much brighter or darker than the last ones."""
        config = self._config.jump
        if not self._levels:
            return False
        usual = float(np.median(self._levels))
        return not usual / config.ratio <= level <= usual * config.ratio

    def _has_noise(self, image: Image) -> bool:
        """Whether neighbouring rows are unrelated."""
        config = self._config.noise
        rows = image[:, :: self._config.sample_px, 1].astype(np.int16)
        wild: Bools = np.abs(rows[1:] - rows[:-1]).mean(axis=1) > config.row_levels
        run = wild[: len(wild) - config.rows + 1].copy()
        for k in range(1, config.rows):
            run &= wild[k : len(wild) - config.rows + 1 + k]
        return bool(run.any())
