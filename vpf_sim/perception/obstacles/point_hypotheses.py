"""Points above the road over many frames: tentative at first, then confirmed."""

from dataclasses import dataclass, fields

import numpy as np

from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.types import Bools, Floats, Flow, Integers


def frames(time_s: float, rate_hz: float) -> int:
    """Frames of a time at a rate, at least two."""
    return max(2, round(time_s * rate_hz))


def among(identity: Integers, others: Integers) -> Bools:
    """(N,) which of the identities are among the others (M,): `np.isin`, ten times as fast."""
    if not len(others):
        return np.zeros(len(identity), np.bool_)
    ordered = np.sort(others)
    found: Bools = ordered.take(ordered.searchsorted(identity), mode="clip") == identity
    return found


def followed(identity: Integers, flow: Flow) -> Bools:
    """(N,) which tracks are still followed, visible or covered."""
    return among(identity, flow.identity) | among(identity, flow.occluded)


def matches(identity: Integers, others: Integers) -> tuple[Integers, Integers]:
    """Rows of both with the same identity; `others` has each one once."""
    if not len(others):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    order = np.argsort(others)
    column = order.take(others.searchsorted(identity, sorter=order), mode="clip")
    row = np.flatnonzero(others[column] == identity)
    return row.astype(np.int64), column[row].astype(np.int64)


@dataclass(slots=True)
class PointObservations:
    """M points above the road in one frame."""

    identity: Integers  # (M,) of the track
    place_m: Floats  # (M, 2) in the world
    sigma_m: Floats  # (M,) of the depth
    sight_rad: Floats  # (M,) direction of sight in the world, along which the place errs
    depth_m: Floats  # (M,) from the camera
    seed_weight: Floats  # (M,) 0 .. 1, how far it may begin an obstacle, not only support one
    low: Bools  # (M,) a hand's breadth above the road
    margin: Floats  # (M,) excess of chi2 on the road


@dataclass(slots=True)
class PointHypotheses(PointObservations):
    """M points that were above the road at least once, as last observed, with the largest margin."""

    hits: Integers  # (M,) frames above the road
    since_s: Floats  # (M,) when the count began
    steady_m: Floats  # (M, 2) the place that later observations must confirm
    steady_sigma_m: Floats  # (M,)
    agreed: Integers  # (M,) observations there
    confirmed: Bools  # (M,)
    obstacle: Integers  # (M,) identity of its obstacle, -1 none yet

    @classmethod
    def none(cls) -> "PointHypotheses":
        number, truth, whole = np.empty(0), np.empty(0, np.bool_), np.empty(0, np.int64)
        seen = PointObservations(whole, np.empty((0, 2)), number, number, number, number, truth, number)
        return cls.of(seen, truth, 0.0)

    @classmethod
    def of(cls, seen: PointObservations, chosen: Bools, time_s: float) -> "PointHypotheses":
        """Tentative points of the `chosen` (M,) observations."""
        columns = {field.name: getattr(seen, field.name)[chosen] for field in fields(PointObservations)}
        count = len(columns["identity"])
        return cls(
            **columns,
            hits=np.ones(count, np.int64),
            since_s=np.full(count, time_s),
            steady_m=columns["place_m"],
            steady_sigma_m=columns["sigma_m"],
            agreed=np.ones(count, np.int64),
            confirmed=np.zeros(count, np.bool_),
            obstacle=np.full(count, -1, np.int64),
        )

    def __len__(self) -> int:
        return len(self.identity)

    def keep(self, chosen: Bools) -> None:
        for column in fields(self):
            setattr(self, column.name, getattr(self, column.name)[chosen])

    def record(self, seen: PointObservations, config: StaticObstacleConfig, rate_hz: float, time_s: float) -> None:
        """Add the points of one frame above the road."""
        if not len(self) and not len(seen.identity):
            return
        needed, most = frames(config.hits_s, rate_hz), 2 * frames(config.memory_s, rate_hz)
        row, column = matches(self.identity, seen.identity)  # rows of self, columns of `seen`
        moved = np.hypot(*(seen.place_m[column] - self.steady_m[row]).T)
        still = moved < config.steady_m + config.steady_ratio * seen.depth_m[column]
        self._agree(row[still], seen, column[still], needed)
        self._restart(row[~still], seen, column[~still], time_s)
        expected = config.hits_share * rate_hz * (time_s - self.since_s)
        self.confirmed = self.confirmed | (self.hits >= np.maximum(needed, np.minimum(expected, most)))
        new = np.ones(len(seen.identity), np.bool_)
        new[column] = False
        if new.any():
            fresh = PointHypotheses.of(seen, new, time_s)
            for part in fields(self):
                setattr(self, part.name, np.concatenate([getattr(self, part.name), getattr(fresh, part.name)]))

    def _agree(self, row: Integers, seen: PointObservations, column: Integers, needed: int) -> None:
        """Count observations near the last place; a confirmed point moves only with as many as confirm one."""
        self.hits[row] += 1
        self.agreed[row] += 1
        moves = ~self.confirmed[row] | (self.agreed[row] >= needed)
        self._place(row[moves], seen, column[moves])
        sharper = seen.sigma_m[column] < 0.5 * self.steady_sigma_m[row]
        self._settle(row[sharper], seen, column[sharper])

    def _restart(self, row: Integers, seen: PointObservations, column: Integers, time_s: float) -> None:
        """Begin again with tentative points that moved; confirmed ones keep their place."""
        self.agreed[row] = 1
        self._settle(row, seen, column)
        again = ~self.confirmed[row]
        row, column = row[again], column[again]
        self.hits[row], self.since_s[row] = 1, time_s
        self._place(row, seen, column)

    def _settle(self, row: Integers, seen: PointObservations, column: Integers) -> None:
        self.steady_m[row], self.steady_sigma_m[row] = seen.place_m[column], seen.sigma_m[column]

    def _place(self, row: Integers, seen: PointObservations, column: Integers) -> None:
        margin = np.maximum(self.margin[row], seen.margin[column])
        for part in fields(PointObservations):
            getattr(self, part.name)[row] = getattr(seen, part.name)[column]
        self.margin[row] = margin
