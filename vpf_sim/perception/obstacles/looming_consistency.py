"""Far points that move, mistaken for near ones that stand: what comes nearer grows, and they do not.

A car far ahead moves across the image in a bend, as a near obstacle at the side would. A single point cannot tell the
two apart, several can: the image of a static object grows by the share of its distance that the car has come nearer
(Lee, Perception 5, 1976), that of a far one hardly at all. A point often has neighbours for some frames only, so
results are remembered.
"""

from collections import deque

import numpy as np

from vpf_sim.geometry import distance_m
from vpf_sim.perception.obstacles.point_hypotheses import among, followed, frames, matches
from vpf_sim.perception.obstacles.static_obstacle_settings import LoomingConsistencyConfig
from vpf_sim.types import Bools, Floats, Flow, Integers


class LoomingConsistency:
    """Remembers where the points were, and finds those that grow apart too little."""

    def __init__(self, config: LoomingConsistencyConfig, rate_hz: float) -> None:
        """`rate_hz` of the frames that are recorded."""
        self._config = config
        self._past: deque[Flow] = deque(maxlen=frames(config.baseline_s, rate_hz) + 1)
        self._most = frames(config.memory_s, rate_hz)
        self._judged: Integers = np.empty(0, np.int64)  # identities of points that had neighbours, and
        self._votes: Integers = np.empty(0, np.int64)  # frames in which they kept together, less those apart

    def record(self, flow: Flow) -> None:
        """Remember this frame."""
        self._past.append(flow)
        kept = followed(self._judged, flow)
        self._judged, self._votes = self._judged[kept], self._votes[kept]

    def keeps_together(self, rows: Integers, inverse_per_m: Floats) -> Bools:
        """(N,) rows of the newest frame that grow apart from their neighbours less than static points would.

        Static, they would have the inverse depths (N,). Tracks younger than the baseline are not judged.
        """
        self._judge(rows, inverse_per_m)
        together = np.zeros(len(rows), np.bool_)
        known, judged = matches(self._past[-1].identity[rows], self._judged)
        together[known] = self._votes[judged] > 0
        return together

    def _judge(self, rows: Integers, inverse_per_m: Floats) -> None:
        """Compare the rows with their neighbours, and count significant results."""
        config, now, before = self._config, self._past[-1], self._past[0]
        chosen, past = matches(now.identity[rows], before.identity)
        place, inverse = before.points_px[past], inverse_per_m[chosen]
        moved = now.points_px[rows[chosen]] - place
        near = np.abs(inverse - inverse[:, None]) < config.depth_ratio * inverse[:, None]
        for axis in place.T:
            near &= np.abs(axis - axis[:, None]) < config.near_px
        count = near.sum(axis=1)
        extent, grown = np.zeros(len(chosen)), np.zeros(len(chosen))
        for axis, motion in zip(place.T, moved.T, strict=True):
            apart = np.where(near, axis - (near @ axis / count)[:, None], 0.0)
            extent += (apart**2).sum(axis=1)
            grown += apart @ motion
        expected = distance_m(now.pose, before.pose) * (near @ inverse) / count
        beyond = grown - config.least_growth * expected * extent
        sure = (count >= 2) & (np.abs(beyond) > config.sigmas * config.noise_px * np.sqrt(extent))
        self._count(now.identity[rows[chosen[sure]]], np.where(beyond[sure] < 0.0, 1, -1))

    def _count(self, identity: Integers, votes: Integers) -> None:
        """Add votes (K,) to those of each point."""
        new = identity[~among(identity, self._judged)]
        self._judged = np.concatenate([self._judged, new])
        self._votes = np.concatenate([self._votes, np.zeros(len(new), np.int64)])
        voted, judged = matches(identity, self._judged)
        self._votes[judged] = np.clip(self._votes[judged] + votes[voted], -self._most, self._most)
