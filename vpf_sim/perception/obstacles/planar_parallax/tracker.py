"""Spots of the road that stand above it: confirmed over several looks, kept in the world until passed."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vpf_sim.geometry import distance_m, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.types import Bools, Floats, Obstacles

LEAST_WAY_M = 0.2  # without which nothing has come nearer: a standing car sees what sticks to the glass again


@dataclass(frozen=True, slots=True)
class LowTrackConfig:
    """When a spot is believed: seen so often at one place of the world, over so long a way."""

    # Mirror images gain 6 to 12 times the noise, pallets 12 to 45 times in hard rain, 30 to 130 in clear weather.
    usual_gain: float = 12.0  # a sighting counts by its gain over this,
    counts: tuple[float, float] = (0.5, 1.5)  # between these limits,
    hits: int = 3  # and it takes so many in sum
    more_hits: int = 4  # that it takes besides while spots flash up everywhere, as they do in rain:
    busy: float = 0.3  # that many new ones a look,
    busy_looks: float = 20.0  # on average over so many
    way_m: float = 1.0  # of the car between the first and the last sighting that told the place,
    nearer_share: float = 0.9  # and how much of it the spot came nearer: a drop does not, a mirror image does by less
    cut_share: float = 0.6  # the same of a spot whose near end is cut off
    misses: int = 3  # in a row, after which one that is not believed is forgotten
    along_m: float = 0.7  # sightings nearer than this
    across_m: float = 0.6  # and this are of one spot
    newest: float = 0.4  # weight of the newest sighting for place and sides
    edge_m: float = 0.3  # inside the carriageway's edges
    beyond_m: float = 0.8  # this far behind a body's face begins what it hides
    margin_m: float = 0.3  # beside a body, hidden as well
    low_hides_m: float = 2.0  # and up to here behind its face one that is low hides anything
    least_seen_m: float = 0.4  # a spot of which less is seen beside a body is none
    sigma_m: float = 0.4  # of a spot's face
    beside_m: float = 0.1  # a spot so near a taller body is of it: what that body covers is left out beforehand,
    sticks_out_m: float = 0.75  # unless it reaches so far out of it: more than the least width beside it does,
    before_m: float = 2.0  # or begins farther before its face than mirror images do
    least_width_m: float = 0.6  # a body is told no narrower
    behind_m: float = 11.0  # where one is forgotten
    cut_hits: int = 2  # that it takes besides where its place was not told all the way
    doubts: int = 2  # sightings, sure ones or not, until one that is not believed is suspected

    def __post_init__(self) -> None:
        if not (self.usual_gain > 0.0 and 0.0 < self.counts[0] <= self.counts[1]):
            raise ValueError(
                f"usual_gain, counts: expected > 0 and 0 < first <= second, got {self.usual_gain}, {self.counts}"
            )
        if not self.hits > 0:
            raise ValueError(f"hits: expected > 0, got {self.hits}")
        if not 0.0 < self.cut_share <= self.nearer_share <= 1.0:
            raise ValueError(
                f"cut_share, nearer_share: expected 0 < first <= second <= 1, got {self.cut_share}, {self.nearer_share}"
            )
        if not self.low_hides_m >= self.beyond_m:
            raise ValueError(f"low_hides_m: expected >= beyond_m = {self.beyond_m}, got {self.low_hides_m}")
        if not self.doubts > 0:
            raise ValueError(f"doubts: expected > 0, got {self.doubts}")
        if not self.least_seen_m > 0.0:
            raise ValueError(f"least_seen_m: expected > 0, got {self.least_seen_m}")
        if not self.cut_hits >= 0:
            raise ValueError(f"cut_hits: expected >= 0, got {self.cut_hits}")


@dataclass(slots=True)
class _Candidate:
    """A spot, in the world."""

    place_m: Floats  # (2,) the middle of its face
    width_m: float
    first_pose: Floats  # (3,) of the car at the first sighting
    first_forward_m: float  # from the car then
    hits: float  # sure ones, each by its gain,
    sure: int  # and their number
    sightings: int = 1
    told_m: float = 0.0  # way of the car from the first sighting to the last that told the place
    way_m: float = 0.0  # of the car from the first sighting to the last
    came_nearer: bool = False  # by about that way
    cut: bool = False  # at the last sighting it was as near as anything is looked at, or nearer
    misses: int = 0
    identity: int | None = None  # of the body that it is believed to be


class LowObstacleTracks:
    """Counts where spots are seen again."""

    def __init__(self, config: LowTrackConfig, next_identity: Callable[[], int], near_m: float = 0.0) -> None:
        """`near_m` from the pose nothing is looked at any more."""
        self.config = config
        self._near_m = near_m
        self._next_identity = next_identity
        self._known: list[_Candidate] = []
        self._fresh_rate = 0.0  # new spots a look

    def record(self, spots: list[LowObservation], pose: Floats) -> None:
        """Count one look, of the vehicle at `pose`."""
        before = len(self._known)
        for one in self._known:
            if self._forward_m(one, pose) > self._near_m:
                one.misses += 1
        for spot in spots:
            self._count(spot, pose)
        fresh = sum(one.hits > 0 for one in self._known[before:])
        self._fresh_rate += (fresh - self._fresh_rate) / self.config.busy_looks
        self._known = [one for one in self._known if self._is_kept(one, pose)]

    def bodies(self, pose: Floats) -> Obstacles:
        """Those believed, in the axes of the vehicle at `pose`."""
        return self._told([one for one in self._known if one.identity is not None], pose)

    def tentative(self, pose: Floats) -> Obstacles:
        """Those that were seen again, but are not believed, in the axes of the vehicle at `pose`.

        What was hidden until it is too near to be seen to come nearer must have been sure each time.
        """
        return self._told([one for one in self._known if one.identity is None and self._is_suspect(one)], pose)

    def _is_suspect(self, one: _Candidate) -> bool:
        doubts = self.config.doubts
        shows_near = one.cut and one.way_m > LEAST_WAY_M and one.sure >= doubts
        return shows_near or (one.came_nearer and one.sightings >= doubts)

    def _told(self, chosen: list[_Candidate], pose: Floats) -> Obstacles:
        place = vehicle_from_world(np.array([one.place_m for one in chosen]).reshape(-1, 2), pose)
        half = 0.5 * np.maximum([one.width_m for one in chosen], self.config.least_width_m)
        sigma, unknown = np.full(len(chosen), self.config.sigma_m), np.full(len(chosen), np.inf)
        identity = np.array(
            [-1 - k if one.identity is None else one.identity for k, one in enumerate(chosen)], np.int64
        )
        return Obstacles(place[:, 0], place[:, 1] - half, place[:, 1] + half, sigma, unknown, identity)

    def forget(self, identity: int) -> None:
        """One that is believed turned out to be road."""
        self._known = [one for one in self._known if one.identity != identity]

    def keep(self, stands: Callable[[Floats], Bools], pose: Floats) -> None:
        """Forget all but those that stand, (N,) by their places (N, 2) in the axes of the vehicle at `pose`."""
        if self._known:
            places = vehicle_from_world(np.array([one.place_m for one in self._known]), pose)
            self._known = [one for one, stays in zip(self._known, stands(places), strict=True) if stays]

    def _count(self, spot: LowObservation, pose: Floats) -> None:
        """Add it to the spot that it is seen again, or remember it; the near end of one cut off tells no place."""
        here = np.array([spot.forward_m, spot.middle_m])
        place, one = world_from_vehicle(here, pose), self._known_at(here, pose)
        if one is None:
            if not spot.cut:
                hits, sure = self._count_of(spot), int(spot.sure)
                self._known.append(_Candidate(place, spot.width_m, pose.copy(), spot.forward_m, hits, sure))
            return
        one.hits, one.sure, one.sightings = one.hits + self._count_of(spot), one.sure + spot.sure, one.sightings + 1
        one.misses, one.cut = 0, spot.cut
        self._approach(one, spot, place, pose)
        if not spot.cut:
            self._place(one, spot, place)
        if one.identity is None and self._stands(one):
            one.identity = self._next_identity()

    def _count_of(self, spot: LowObservation) -> float:
        """How much a sighting counts; 0 for one that is not sure."""
        least, most = self.config.counts
        return min(max(spot.gain / self.config.usual_gain, least), most) if spot.sure else 0.0

    def _stands(self, one: _Candidate) -> bool:
        """Whether it was seen often enough, over way enough, as what stands comes nearer."""
        config = self.config
        needed = self.hits_needed + (0 if one.told_m >= config.way_m else config.cut_hits)
        return one.came_nearer and one.way_m >= config.way_m and one.hits >= needed

    def _known_at(self, here: Floats, pose: Floats) -> _Candidate | None:
        """The first that is remembered about a place."""
        for one in self._known:
            gap = np.abs(vehicle_from_world(one.place_m, pose) - here)
            if gap[0] < self.config.along_m and gap[1] < self.config.across_m:
                return one
        return None

    def _place(self, one: _Candidate, spot: LowObservation, place_m: Floats) -> None:
        """Average over the sightings."""
        newest, one.told_m = self.config.newest, one.way_m
        one.place_m = one.place_m + newest * (place_m - one.place_m)
        one.width_m += newest * (spot.width_m - one.width_m)

    def _approach(self, one: _Candidate, spot: LowObservation, place_m: Floats, pose: Floats) -> None:
        """How far the car has come since the first sighting, and whether the spot came nearer by as much.

        That is less by what the spot moved on, as the car was headed then. One that is cut off came at least so near.
        """
        one.way_m = distance_m(pose, one.first_pose)
        nearer_m = one.way_m + one.first_forward_m - float(vehicle_from_world(place_m, one.first_pose)[0])
        share = self.config.cut_share if spot.cut else self.config.nearer_share
        one.came_nearer = one.way_m > LEAST_WAY_M and nearer_m > share * one.way_m

    @property
    def hits_needed(self) -> int:
        """Until a spot is believed."""
        return self.config.hits + (self.config.more_hits if self._fresh_rate > self.config.busy else 0)

    def _is_kept(self, one: _Candidate, pose: Floats) -> bool:
        ahead_m = self._forward_m(one, pose)
        if one.identity is None:
            return one.misses < self.config.misses and ahead_m > 0.0
        return ahead_m > -self.config.behind_m

    def _forward_m(self, one: _Candidate, pose: Floats) -> float:
        return float(vehicle_from_world(one.place_m, pose)[0])


def in_sight(spot: LowObservation, lens_m: Floats, bodies: Obstacles, config: LowTrackConfig) -> LowObservation | None:
    """What a camera at `lens_m` (2,), vehicle axes, sees of a spot beside the known bodies that stand before it.

    Where one stood, its picture is the body's, not the road's.
    """
    between = (bodies.forward_m > lens_m[0]) & (bodies.forward_m + config.beyond_m < spot.forward_m)
    left, right = spot.left_m, spot.right_m
    for body in np.flatnonzero(between):
        beyond = (spot.forward_m - lens_m[0]) / (bodies.forward_m[body] - lens_m[0])
        begins = lens_m[1] + (bodies.left_m[body] - config.margin_m - lens_m[1]) * beyond
        ends = lens_m[1] + (bodies.right_m[body] + config.margin_m - lens_m[1]) * beyond
        if begins < right and ends > left:
            left, right = (left, begins) if begins - left > right - ends else (ends, right)
            if right - left < config.least_seen_m:
                return None
    return replace(spot, left_m=float(left), right_m=float(right))
