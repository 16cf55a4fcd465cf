"""Spots of the road that stand above it: confirmed over several looks, kept in the world until passed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import distance_m, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.ground_residual import Spot
from vpf_sim.types import Floats, Obstacles


@dataclass(frozen=True, slots=True)
class SpotConfig:
    """When a spot is believed: seen so often at one place of the world, over so long a way."""

    hits: int = 3
    more_hits: int = 4  # that it takes besides while spots flash up everywhere, as they do in rain:
    busy: float = 0.3  # that many new ones a look,
    busy_looks: float = 20.0  # on average over so many
    way_m: float = 1.0  # of the car between the first and the last hit,
    nearer_share: float = 0.6  # and by how much of it the spot came nearer: a drop on the glass does not
    misses: int = 3  # in a row, after which one that is not believed is forgotten
    along_m: float = 0.8  # sightings nearer than this
    across_m: float = 0.6  # and this are of one spot
    newest: float = 0.4  # weight of the newest sighting for place and sides
    edge_m: float = 0.3  # inside the carriageway's edges
    beyond_m: float = 0.8  # this far behind a body's face begins what it hides
    margin_m: float = 0.3  # beside a body, hidden as well
    sigma_m: float = 0.4  # of a spot's face
    beside_m: float = 0.1  # a spot so near a taller body is of it: what that body covers is left out beforehand
    least_width_m: float = 0.6  # a body is told no narrower
    behind_m: float = 11.0  # where one is forgotten


@dataclass(slots=True)
class _Candidate:
    """A spot, in the world."""

    place_m: Floats  # (2,) the middle of its face
    width_m: float
    first_m: Floats  # (2,) of the car at the first hit
    first_forward_m: float  # from the car then
    hits: int = 1
    misses: int = 0
    identity: int | None = None  # of the body that it is believed to be


class SpotBook:
    """Counts where spots are seen again."""

    def __init__(self, config: SpotConfig, next_identity: Callable[[], int]) -> None:
        self.config = config
        self._next_identity = next_identity
        self._known: list[_Candidate] = []
        self._fresh_rate = 0.0  # new spots a look

    def record(self, spots: list[Spot], pose: Floats) -> None:
        """Count one look, of the vehicle at `pose`."""
        before = len(self._known)
        hit = [self._count(spot, pose) for spot in spots]
        self._fresh_rate += (len(self._known) - before - self._fresh_rate) / self.config.busy_looks
        for one in self._known:
            if not any(one is other for other in hit):
                one.misses += 1
        self._known = [one for one in self._known if self._is_kept(one, pose)]

    def bodies(self, pose: Floats) -> Obstacles:
        """Those believed, in the axes of the vehicle at `pose`."""
        believed = [one for one in self._known if one.identity is not None]
        place = vehicle_from_world(np.array([one.place_m for one in believed]).reshape(-1, 2), pose)
        half = 0.5 * np.maximum([one.width_m for one in believed], self.config.least_width_m)
        sigma, unknown = np.full(len(believed), self.config.sigma_m), np.full(len(believed), np.inf)
        identity = np.array([one.identity for one in believed], np.int64)
        return Obstacles(place[:, 0], place[:, 1] - half, place[:, 1] + half, sigma, unknown, identity)

    def forget(self, identity: int) -> None:
        """One that is believed turned out to be road."""
        self._known = [one for one in self._known if one.identity != identity]

    def _count(self, spot: Spot, pose: Floats) -> _Candidate:
        config = self.config
        here = np.array([spot.forward_m, 0.5 * (spot.left_m + spot.right_m)])
        width = spot.right_m - spot.left_m
        for one in self._known:
            gap = np.abs(vehicle_from_world(one.place_m, pose) - here)
            if gap[0] < config.along_m and gap[1] < config.across_m:
                one.hits, one.misses = one.hits + 1, 0
                one.place_m = one.place_m + config.newest * (world_from_vehicle(here, pose) - one.place_m)
                one.width_m += config.newest * (width - one.width_m)
                way = distance_m(pose[:2], one.first_m)
                stands = way >= config.way_m and one.first_forward_m - spot.forward_m > config.nearer_share * way
                if one.identity is None and one.hits >= self.hits_needed and stands:
                    one.identity = self._next_identity()
                return one
        self._known.append(_Candidate(world_from_vehicle(here, pose), width, pose[:2].copy(), spot.forward_m))
        return self._known[-1]

    @property
    def hits_needed(self) -> int:
        """Until a spot is believed."""
        return self.config.hits + (self.config.more_hits if self._fresh_rate > self.config.busy else 0)

    def _is_kept(self, one: _Candidate, pose: Floats) -> bool:
        if one.identity is None:
            return one.misses < self.config.misses
        return float(vehicle_from_world(one.place_m, pose)[0]) > -self.config.behind_m


def is_hidden(spot: Spot, lens_m: Floats, bodies: Obstacles, config: SpotConfig) -> bool:
    """Whether a known body stood before the spot, for a camera at `lens_m` (2,), vehicle axes: then its picture is the
    body's, not the road's."""
    between = (bodies.forward_m > lens_m[0]) & (bodies.forward_m + config.beyond_m < spot.forward_m)
    if not between.any():
        return False
    share = (bodies.forward_m[between] - lens_m[0]) / (spot.forward_m - lens_m[0])
    left = lens_m[1] + (spot.left_m - lens_m[1]) * share
    right = lens_m[1] + (spot.right_m - lens_m[1]) * share
    margin = config.margin_m
    overlap = (right > bodies.left_m[between] - margin) & (left < bodies.right_m[between] + margin)
    return bool(overlap.any())
