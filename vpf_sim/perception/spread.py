"""Far things that move, taken for near ones that stand: what comes nearer draws apart, and they do not.

A car that drives far ahead moves across the picture where the road bends, as what stands near and aside would. One
point of it cannot tell the two apart; several can: the image of what stands grows by the share of its distance that the
car has come nearer (Lee, Perception 5, 1976), that of what is far off hardly at all.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import distance_m
from vpf_sim.perception.marks import Integers, matches
from vpf_sim.types import Bools, Floats, Flow

LEAST_POINTS = 3  # of one thing


@dataclass(frozen=True, slots=True)
class SpreadConfig:
    """Which points are of one thing, and how little they draw apart if it is far off."""

    baseline_s: float = 0.5  # over which they are watched
    about_px: float = 30.0  # between points of one thing, at most
    alike: float = 0.5  # share of the inverse depth, by which theirs may differ
    noise_px: float = 0.2  # standard deviation of a point's way over the baseline
    least: float = 0.5  # of the growth that their inverse depth asks for
    sure: float = 2.0  # standard deviations

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")


class Spread:
    """Remembers where the points were, and tells which draw apart too little."""

    def __init__(self, config: SpreadConfig, rate_hz: float) -> None:
        """`rate_hz` of the frames that are recorded."""
        self._config = config
        self._past: deque[Flow] = deque(maxlen=max(2, round(config.baseline_s * rate_hz) + 1))

    def record(self, flow: Flow) -> None:
        """Remember this frame."""
        self._past.append(flow)

    def keeps_together(self, rows: Integers, inverse_per_m: Floats) -> Bools:
        """(N,) of those rows of the newest frame, which draw apart from the ones about them less than what stands.

        Standing, they would be at the inverse depths (N,). A track that is younger than the baseline tells nothing.
        """
        config, now, before = self._config, self._past[-1], self._past[0]
        together = np.zeros(len(rows), np.bool_)
        chosen, past = matches(now.identity[rows], before.identity)
        if len(chosen) < LEAST_POINTS:
            return together
        place = before.points_px[past]
        moved = now.points_px[rows[chosen]] - place
        inverse = inverse_per_m[chosen]
        mine = np.abs(inverse - inverse[:, None]) < config.alike * inverse[:, None]
        for axis in place.T:
            mine &= np.abs(axis - axis[:, None]) < config.about_px
        count = mine.sum(axis=1)
        extent, grown = np.zeros(len(chosen)), np.zeros(len(chosen))
        for axis, way in zip(place.T, moved.T, strict=True):
            apart = np.where(mine, axis - (mine @ axis / count)[:, None], 0.0)
            extent += (apart**2).sum(axis=1)
            grown += apart @ way
        expected = distance_m(now.pose, before.pose) * (mine @ inverse) / count
        bound = config.least * expected * extent - config.sure * config.noise_px * np.sqrt(extent)
        together[chosen] = (count >= LEAST_POINTS) & (grown < bound)
        return together
