"""Ego-aligned temporal average of grids of the road ahead."""

from collections.abc import Callable

import cv2
import numpy as np

from vpf_sim.types import Floats, Singles


class TemporalAverage:
    """Exponential averages of grids that move with the road. What enters the grid begins at 0.

    Noise of single observations, as of rain, averages out; an obstacle's difference does not.
    """

    def __init__(self, share: float) -> None:
        self._share = np.float32(share)  # of the newest observation
        self._grids: list[Singles] = []
        self._pose: Floats = np.zeros(3)

    def add(self, grids: list[Singles], pose: Floats, transform: Callable[[Floats, Floats], Singles]) -> list[Singles]:
        """The averages (rows, columns) with those observed at `pose`; `transform` leads to cells at a past pose."""
        self._grids = [
            self._share * grid + past for grid, past in zip(grids, self._moved(grids, pose, transform), strict=True)
        ]
        self._pose = pose.copy()
        return self._grids

    def fade(self) -> None:
        """Add an observation that shows nothing at all."""
        self._grids = [(1 - self._share) * grid for grid in self._grids]

    def _moved(
        self, grids: list[Singles], pose: Floats, transform: Callable[[Floats, Floats], Singles]
    ) -> list[Singles]:
        """The past averages with their weight, moved to where the road is now."""
        if not self._grids:
            return [np.zeros_like(grid) for grid in grids]
        way, size = transform(self._pose, pose), grids[0].shape[::-1]
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        # As one image: equal to the bit for four grids, for other numbers of them OpenCV rounds otherwise.
        moved = cv2.split(cv2.warpAffine(cv2.merge(self._grids), way, size, flags=flags))
        return [(1 - self._share) * np.asarray(grid, np.float32) for grid in moved]
