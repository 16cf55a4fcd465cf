"""Far things that move, taken for near ones that stand: what comes nearer draws apart, and they do not.

A car that drives far ahead moves across the picture where the road bends, as what stands near and aside would. One
point of it cannot tell the two apart; several can: the image of what stands grows by the share of its distance that the
car has come nearer (Lee, Perception 5, 1976), that of what is far off hardly at all. Often a point has others about it
for some frames only; what it was found to be then it still is without them.
"""

from collections import deque

import numpy as np

from vpf_sim.geometry import distance_m
from vpf_sim.perception.obstacles.config import LoomingConsistencyConfig
from vpf_sim.perception.obstacles.point_hypotheses import Integers, among, followed, frames, matches
from vpf_sim.types import Bools, Floats, Flow

LEAST_POINTS = 2  # of one thing


class LoomingConsistency:
    """Remembers where the points were, and tells which draw apart too little."""

    def __init__(self, config: LoomingConsistencyConfig, rate_hz: float) -> None:
        """`rate_hz` of the frames that are recorded."""
        self._config = config
        self._past: deque[Flow] = deque(maxlen=frames(config.baseline_s, rate_hz) + 1)
        self._most = frames(config.kept_s, rate_hz)
        self._judged: Integers = np.empty(0, np.int64)  # identities of points that others were about, and
        self._votes: Integers = np.empty(0, np.int64)  # in how many more frames they kept together than drew apart

    def record(self, flow: Flow) -> None:
        """Remember this frame."""
        self._past.append(flow)
        kept = followed(self._judged, flow)
        self._judged, self._votes = self._judged[kept], self._votes[kept]

    def keeps_together(self, rows: Integers, inverse_per_m: Floats) -> Bools:
        """(N,) of those rows of the newest frame, which draw apart from the ones about them less than what stands.

        Standing, they would be at the inverse depths (N,). Where none is about one, what was found before holds. A
        track that is younger than the baseline tells nothing.
        """
        self._judge(rows, inverse_per_m)
        together = np.zeros(len(rows), np.bool_)
        known, judged = matches(self._past[-1].identity[rows], self._judged)
        together[known] = self._votes[judged] > 0
        return together

    def _judge(self, rows: Integers, inverse_per_m: Floats) -> None:
        """Compare the rows with the ones about them, and count what is beyond doubt."""
        config, now, before = self._config, self._past[-1], self._past[0]
        chosen, past = matches(now.identity[rows], before.identity)
        if len(chosen) < LEAST_POINTS:
            return
        place, inverse = before.points_px[past], inverse_per_m[chosen]
        moved = now.points_px[rows[chosen]] - place
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
        beyond = grown - config.least * expected * extent
        sure = (count >= LEAST_POINTS) & (np.abs(beyond) > config.sure * config.noise_px * np.sqrt(extent))
        self._count(now.identity[rows[chosen[sure]]], np.where(beyond[sure] < 0.0, 1, -1))

    def _count(self, identity: Integers, votes: Integers) -> None:
        """Add votes (K,) to those of each point."""
        new = identity[~among(identity, self._judged)]
        self._judged = np.concatenate([self._judged, new])
        self._votes = np.concatenate([self._votes, np.zeros(len(new), np.int64)])
        voted, judged = matches(identity, self._judged)
        self._votes[judged] = np.clip(self._votes[judged] + votes[voted], -self._most, self._most)
