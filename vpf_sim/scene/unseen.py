"""What may drive where a camera that looks forward sees nothing: beside the car and behind it.

A car that is slower than the traffic is overtaken. So where traffic was seen, one vehicle after the other may come in
each lane beside the car, at the traffic's speed, and a lane change may cut one off. Vehicles that the car has overtaken
must catch up first. A car that has stood for some seconds no longer waits.
"""

from collections.abc import Mapping
from math import inf

import numpy as np

from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState
from vpf_sim.scene.scene_settings import UnseenConfig
from vpf_sim.scene.tracks import Tracks

FRONT_M, GAP_M, LEAST_EVERY_M = 1.5, 3.0, 12.0  # the first one's front, from the car's middle; no car fits in a gap
COMING_S, COUNT = 5.0, 6  # for which they come, at least as long as a plan reaches; faster ones are longer
FASTEST_MPS = 60.0  # more is no vehicle's
WIDTH_M = 1.0  # enough to keep the car out of the lane
IN_LANE, NEXT_LANE = 0.6, 1.6  # of a lane's width, from its middle: a car that is nearer is in it, or in the next
STANDING_MPS, DRIVING_MPS = 0.3, 2.0  # a car that has begun to drive goes on
SURE_S = 1.0  # for which a track has been traffic before it counts: drops and paint are so for a moment


class UnseenTraffic:
    """Remembers how fast the traffic was, how far the car has left it behind, and how long it has stood."""

    def __init__(self, config: UnseenConfig) -> None:
        self._config = config
        self._speed_mps, self._seen_s, self._stood_s = 0.0, -inf, 0.0
        self._last_s: float | None = None
        self._ahead_m = 0.0  # distance gained on the traffic since it was seen first
        self._since_s: dict[int, float] = {}  # when each track was seen first, of those seen last

    def update(self, time_s: float, own_mps: float, along_mps: Mapping[int, float]) -> None:
        """Note the speeds along the road of what moves in our direction, by the tracks' identities."""
        since_s = 0.0 if self._last_s is None else time_s - self._last_s
        self._last_s = time_s
        if own_mps < STANDING_MPS:
            self._stood_s += since_s
        elif own_mps > DRIVING_MPS:
            self._stood_s = 0.0
        self._since_s = {identity: self._since_s.get(identity, time_s) for identity in along_mps}
        fastest = max((v for track, v in along_mps.items() if time_s - self._since_s[track] >= SURE_S), default=0.0)
        if fastest > max(self._speed_mps, STANDING_MPS) or time_s - self._seen_s > self._config.remembered_s:
            self._speed_mps = fastest
        if fastest > STANDING_MPS:
            self._seen_s = time_s
        gained_m = (own_mps - self._speed_mps) * since_s
        self._ahead_m = max(self._ahead_m + gained_m, 0.0) if self._is_recent(time_s) else 0.0

    def _is_recent(self, time_s: float) -> bool:
        return time_s - self._seen_s < self._config.remembered_s

    def tracks(self, road: Road, ego: EgoState, time_s: float) -> Tracks:
        """Tracks in the lanes of our direction that are next to the car's, while it is slower than the traffic."""
        lanes = road.lanes_at(np.array([ego.s_m]))[:, 0]
        away = np.abs(lanes - ego.d_m) / road.lane_width_m
        others = lanes[(away > IN_LANE) & (away < NEXT_LANE)]
        waits = self._is_recent(time_s) and self._stood_s < self._config.patience_s
        if not waits or ego.speed_mps > self._config.slower_share * self._speed_mps:
            others = others[:0]
        every_m = max(COMING_S * min(self._speed_mps, FASTEST_MPS) / (COUNT - 1), LEAST_EVERY_M)
        length_m = every_m - GAP_M
        others, behind_m = (grid.ravel() for grid in np.meshgrid(others, every_m * np.arange(COUNT)))
        s, same = ego.s_m + FRONT_M - 0.5 * length_m - behind_m - self._ahead_m, np.ones(len(others))
        x, y, heading = road.world(s, others)
        return Tracks(
            x, y, heading, self._speed_mps * same, 0.0 * same, length_m * same, WIDTH_M * same,
            s, others, np.zeros((len(others), 4, 4)),
        )  # fmt: skip
