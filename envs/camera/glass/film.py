"""The water film on the windscreen between the drops."""

import cv2
import numpy as np

from vpf_sim.envs.camera.glass.wipers import Swath, Wiper
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

OLD, FRESH = 0.04, 0.12  # share of blurred light between sweeps, and right behind the blade
ARCS = 0.4  # variation of thickness by radius, from the blade's edge
ARC_M = 0.002
DRIES_S = 0.2  # time from fresh to old


class Film:
    """`cover` (h, w) 0..255 of the planes: fresh behind the blade, thinner soon after."""

    def __init__(self, shape: tuple[int, int], wiper: Wiper | None, tick_s: float, seed: int) -> None:
        thickness = np.ones(shape) if wiper is None else _arcs(wiper.radii_m, seed)
        self._old, self._fresh = (np.rint(255.0 * share * thickness).astype(np.uint8) for share in (OLD, FRESH))
        self._step: Image = np.rint((self._fresh - self._old.astype(float)) * tick_s / DRIES_S).astype(np.uint8)
        self._fresh_until_s = -np.inf
        self.cover: Image = self._old.copy()

    def wipe(self, swath: Swath, time_s: float) -> None:
        """Set fresh film in the swath."""
        cv2.copyTo(self._fresh, swath.mask, self.cover)
        self._fresh_until_s = time_s + 2.0 * DRIES_S

    def advance(self, time_s: float) -> None:
        """Thin the film by one tick."""
        if time_s <= self._fresh_until_s:
            cv2.subtract(self.cover, self._step, self.cover)
            cv2.max(self.cover, self._old, self.cover)


def _arcs(radii_m: Floats, seed: int) -> Floats:
    """Thickness of the film by distance from the pivot, mean 1."""
    steps = np.arange(0.0, radii_m.max() + 2.0 * ARC_M, ARC_M)
    noise = stream(seed, "film").uniform(-1.0, 1.0, len(steps))
    thickness: Floats = 1.0 + ARCS * np.interp(radii_m, steps, noise)
    return thickness
