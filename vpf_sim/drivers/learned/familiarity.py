"""How unlike a policy's inputs are to those that it learned from: a plain distance of picture statistics, and speeds.

A picture is described by the brightness and the texture of a few blocks. Its distance is the root mean square of the
statistics' differences to their means in training, in standard deviations there. It is no proof that a policy fails,
but a policy's commands mean little far from what it learned from.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from vpf_sim.drivers.learned.manifest import BLOCKS, STATISTICS, LearnedFrom
from vpf_sim.types import Floats, Image

LEAST_DEVIATION = (4.0, 0.1)  # of brightness, grey levels; of texture's logarithm
MARGIN = 1.25  # of the distance, beyond the farthest picture of the training
SLACK_MPS = 1.0  # beyond the fastest and slowest of the training
UNLIKE_SHARE = 0.5  # of the decisions, above which a remark says so


def statistics(picture: Image) -> Floats:
    """(STATISTICS,) mean grey level and logarithm of the texture of each block of (channels, H, W)."""
    grey = picture.mean(axis=0).astype(np.float32)
    texture = np.abs(cv2.Sobel(grey, cv2.CV_32F, 1, 0)) + np.abs(cv2.Sobel(grey, cv2.CV_32F, 0, 1))
    size = BLOCKS[::-1]
    blocks = [cv2.resize(part, size, interpolation=cv2.INTER_AREA).ravel() for part in (grey, texture)]
    return np.concatenate([blocks[0], np.log1p(blocks[1])]).astype(np.float64)


def learned_from(pictures: Sequence[Image], speeds_mps: Sequence[float]) -> LearnedFrom:
    """The section of the manifest for pictures (channels, H, W) and speeds of a training."""
    seen = np.array([statistics(picture) for picture in pictures])
    mean, deviation = seen.mean(axis=0), np.maximum(seen.std(axis=0), np.repeat(LEAST_DEVIATION, STATISTICS // 2))
    farthest = max(_distance(one, mean, deviation) for one in seen)
    rounded = [tuple(np.round(values, 3).tolist()) for values in (mean, deviation)]
    speeds = (round(float(min(speeds_mps)), 2), round(float(max(speeds_mps)), 2))
    return LearnedFrom(speed_mps=speeds, mean=rounded[0], deviation=rounded[1], limit=round(MARGIN * farthest, 3))


def _distance(found: Floats, mean: Floats, deviation: Floats) -> float:
    return float(np.sqrt(np.mean(((found - mean) / deviation) ** 2)))


class Familiarity:
    """Counts the decisions whose picture or speed is unlike those of the training."""

    def __init__(self, known: LearnedFrom) -> None:
        self._known = known
        self._decisions, self._unlike, self._speeding = 0, 0, 0

    def add(self, picture: Image | None, speed_mps: float) -> None:
        """Count a decision with the newest picture (channels, H, W) of the policy's inputs."""
        known = self._known
        self._decisions += 1
        if picture is not None:
            away = _distance(statistics(picture), np.array(known.mean), np.array(known.deviation))
            self._unlike += away > known.limit
        slowest, fastest = known.speed_mps
        self._speeding += not slowest - SLACK_MPS <= speed_mps <= fastest + SLACK_MPS

    def remark(self) -> str:
        """What is unlike the training in most decisions, in one line; empty where nothing is."""
        slowest, fastest = self._known.speed_mps
        parts = [
            f"{what} in {100.0 * count / self._decisions:.0f} % of the decisions"
            for count, what in (
                (self._unlike, "the picture is unlike those that it learned from"),
                (
                    self._speeding,
                    f"the speed is outside of the {slowest:.1f} to {fastest:.1f} m/s that it learned from",
                ),
            )
            if count > UNLIKE_SHARE * self._decisions
        ]
        return "; ".join(parts)
