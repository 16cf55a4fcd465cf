"""The table of points that stood above the road: how often, where in the world, and how surely."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Floats, Flow

Integers = NDArray[np.int64]


def frames(time_s: float, rate_hz: float) -> int:
    """How many frames at that rate a point needs to be seen in for that time: two at least."""
    return max(2, round(time_s * rate_hz))


def among(identity: Integers, others: Integers) -> Bools:
    """(N,) which of the identities are among the others (M,): `np.isin`, which takes ten times as long."""
    if not len(others):
        return np.zeros(len(identity), np.bool_)
    ordered = np.sort(others)
    found: Bools = ordered.take(ordered.searchsorted(identity), mode="clip") == identity
    return found


def followed(identity: Integers, flow: Flow) -> Bools:
    """(N,) which tracks are followed still, seen or covered."""
    return among(identity, flow.identity) | among(identity, flow.covered)


def matches(identity: Integers, others: Integers) -> tuple[Integers, Integers]:
    """Rows of both that are the same track; none is twice in `others`."""
    if not len(others):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    order = np.argsort(others)
    column = order.take(others.searchsorted(identity, sorter=order), mode="clip")
    row = np.flatnonzero(others[column] == identity)
    return row.astype(np.int64), column[row].astype(np.int64)


@dataclass(frozen=True, slots=True)
class Sightings:
    """M points of one frame that were seen to stand above the road."""

    identity: Integers  # (M,) of the track
    place_m: Floats  # (M, 2) in the world
    sigma_m: Floats  # (M,) of the depth
    sight_rad: Floats  # (M,) direction in the world in which the point was seen, and its place may err
    depth_m: Floats  # (M,) from the camera
    height_m: Floats  # (M,) above the road
    seed_weight: Floats  # (M,) 0 .. 1, how far it may found a body, not only support one
    low: Bools  # (M,) near the road, see `perception.obstacles.low_obstacles`
    margin: Floats  # (M,) by how much chi2 is worse with the road
    texture: Floats  # (M,) small eigenvalue of the structure tensor, grey levels^2 / px^2


@dataclass(frozen=True, slots=True)
class ConfirmationRule:
    """When a point is believed: after so many hits, in so large a share of the frames, without moving in the world."""

    rate_hz: float
    hits: int
    most_hits: int  # more are not counted, so that the road's evidence can still clear the point
    share: float
    steady_m: float  # largest change of place, plus
    steady_ratio: float  # this share of the depth


@dataclass(slots=True)
class PointHypotheses:
    """M points that stood above the road at least once, one row a track."""

    identity: Integers  # (M,)
    hits: Integers  # (M,) frames in which it stood above the road, less twice those in which it lay on it
    since_s: Floats  # (M,) when the count began
    place_m: Floats  # (M, 2) in the world at the last hit
    sigma_m: Floats  # (M,)
    sight_rad: Floats  # (M,)
    depth_m: Floats  # (M,)
    height_m: Floats  # (M,)
    seed_weight: Floats  # (M,)
    low: Bools  # (M,)
    margin: Floats  # (M,) the largest so far
    texture: Floats  # (M,)
    steady_m: Floats  # (M, 2) the place that later hits must confirm
    steady_sigma_m: Floats  # (M,)
    agreed: Integers  # (M,) hits since it was first seen there
    believed: Bools  # (M,)
    body: Integers  # (M,) identity of its body, -1 none yet

    @classmethod
    def none(cls) -> "PointHypotheses":
        number, truth = np.empty(0), np.empty(0, np.bool_)
        return cls.of(
            Sightings(
                np.empty(0, np.int64),
                np.empty((0, 2)),
                *(number,) * 5,
                truth,
                *(number,) * 2,
            ),
            0.0,
        )

    @classmethod
    def of(cls, seen: Sightings, time_s: float) -> "PointHypotheses":
        count = len(seen.identity)
        return cls(
            identity=seen.identity,
            hits=np.ones(count, np.int64),
            since_s=np.full(count, time_s),
            place_m=seen.place_m,
            sigma_m=seen.sigma_m,
            sight_rad=seen.sight_rad,
            depth_m=seen.depth_m,
            height_m=seen.height_m,
            seed_weight=seen.seed_weight,
            low=seen.low,
            margin=seen.margin,
            texture=seen.texture,
            steady_m=seen.place_m,
            steady_sigma_m=seen.sigma_m,
            agreed=np.ones(count, np.int64),
            believed=np.zeros(count, np.bool_),
            body=np.full(count, -1, np.int64),
        )

    def __len__(self) -> int:
        return len(self.identity)

    def keep(self, chosen: Bools) -> None:
        for column in fields(self):
            setattr(self, column.name, getattr(self, column.name)[chosen])

    def record(self, seen: Sightings, on_road: Integers, rules: ConfirmationRule, time_s: float) -> None:
        """Count one frame: `seen` stood above the road, the tracks `on_road` lay on it."""
        if not len(self) and not len(seen.identity):
            return
        row, column = matches(self.identity, seen.identity)  # rows are of the table, columns of `seen`
        moved = np.hypot(*(seen.place_m[column] - self.steady_m[row]).T)
        still = moved < rules.steady_m + rules.steady_ratio * seen.depth_m[column]
        self._confirm(row[still], seen, column[still], rules.hits)
        self._restart(row[~still], seen, column[~still], time_s)
        self.hits[among(self.identity, on_road)] -= 2
        self.hits = np.minimum(self.hits, rules.most_hits)
        expected = rules.share * rules.rate_hz * (time_s - self.since_s)
        enough = (self.hits >= rules.hits) & (self.hits >= np.minimum(expected, rules.most_hits))
        self.believed = (self.believed | enough) & (self.hits > 0)
        new = np.ones(len(seen.identity), np.bool_)
        new[column] = False
        if new.any():
            self._append(seen, new, time_s)

    def _confirm(self, row: Integers, seen: Sightings, column: Integers, agreements: int) -> None:
        """One more hit; a point that is believed moves only to where it was seen as often as it takes to believe it."""
        self.hits[row] += 1
        self.agreed[row] += 1
        moves = ~self.believed[row] | (self.agreed[row] >= agreements)
        self._place(row[moves], seen, column[moves])
        sharper = seen.sigma_m[column] < 0.5 * self.steady_sigma_m[row]
        self._settle(row[sharper], seen, column[sharper])

    def _restart(self, row: Integers, seen: Sightings, column: Integers, time_s: float) -> None:
        """What moves in the world is no landmark: one not believed yet starts again, one believed keeps its place."""
        self.agreed[row] = 1
        self._settle(row, seen, column)
        again = ~self.believed[row]
        row, column = row[again], column[again]
        self.hits[row], self.since_s[row] = 1, time_s
        self._place(row, seen, column)

    def _settle(self, row: Integers, seen: Sightings, column: Integers) -> None:
        self.steady_m[row], self.steady_sigma_m[row] = seen.place_m[column], seen.sigma_m[column]

    def _place(self, row: Integers, seen: Sightings, column: Integers) -> None:
        self.place_m[row], self.sigma_m[row] = seen.place_m[column], seen.sigma_m[column]
        self.depth_m[row], self.height_m[row] = seen.depth_m[column], seen.height_m[column]
        self.sight_rad[row] = seen.sight_rad[column]
        self.seed_weight[row], self.low[row] = seen.seed_weight[column], seen.low[column]
        self.margin[row] = np.maximum(self.margin[row], seen.margin[column])
        self.texture[row] = seen.texture[column]

    def _append(self, seen: Sightings, new: Bools, time_s: float) -> None:
        fresh = PointHypotheses.of(Sightings(*(getattr(seen, name)[new] for name in Sightings.__slots__)), time_s)
        for column in fields(self):
            setattr(self, column.name, np.concatenate([getattr(self, column.name), getattr(fresh, column.name)]))
