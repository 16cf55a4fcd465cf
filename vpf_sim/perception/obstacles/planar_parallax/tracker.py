"""Tracks of low obstacles: confirmed over several observations, kept in the world until passed."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vpf_sim.geometry import distance_m, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.types import Bools, Floats, Obstacles


@dataclass(slots=True)
class _Track:
    """A tentative or confirmed low obstacle, in the world."""

    place_m: Floats  # (2,) the middle of its face
    width_m: float
    first_pose: Floats  # (3,) of the car at the first observation
    first_forward_m: float  # from the car then
    hits: float  # sure observations, each by its gain
    sure: int  # number of sure observations
    sightings: int = 1
    placed_m: float = 0.0  # way of the car from the first observation to the last one not truncated
    way_m: float = 0.0  # of the car from the first observation to the last
    came_nearer: bool = False  # by about that way
    truncated: bool = False  # at the last observation
    misses: int = 0
    identity: int | None = None  # once it is confirmed


class LowObstacleTracks:
    """Tracker of low obstacles, from the observations of planar parallax."""

    def __init__(self, config: LowTrackConfig, next_identity: Callable[[], int], near_m: float = 0.0) -> None:
        """`near_m` from the pose the observed patch ends."""
        self.config = config
        self._near_m = near_m
        self._next_identity = next_identity
        self.tracks: list[_Track] = []
        self._fresh_rate = 0.0  # new tracks per observation

    def record(self, spots: list[LowObservation], pose: Floats) -> None:
        """Add one observation by the vehicle at `pose`."""
        before = len(self.tracks)
        for one in self.tracks:
            if self._forward_m(one, pose) > self._near_m:
                one.misses += 1
        for spot in spots:
            self._count(spot, pose)
        if self.config.clutter is not None:
            fresh = sum(one.hits > 0 for one in self.tracks[before:])
            self._fresh_rate += (fresh - self._fresh_rate) / self.config.clutter.looks
        self.tracks = [one for one in self.tracks if self._is_kept(one, pose)]

    def bodies(self, pose: Floats) -> Obstacles:
        """The confirmed tracks, in the axes of the vehicle at `pose`."""
        return self._obstacles([one for one in self.tracks if one.identity is not None], pose)

    def tentative(self, pose: Floats) -> Obstacles:
        """The tentative tracks that were observed again, in the axes of the vehicle at `pose`."""
        return self._obstacles([one for one in self.tracks if one.identity is None and self._is_reported(one)], pose)

    def _is_reported(self, one: _Track) -> bool:
        """Whether a tentative track came nearer, or, hidden until it is too near for that, was sure each time."""
        if self.config.tentative is None:
            return False
        doubts = self.config.tentative.hits
        shows_near = one.truncated and one.way_m > self.config.least_way_m and one.sure >= doubts
        return shows_near or (one.came_nearer and one.sightings >= doubts)

    def _obstacles(self, chosen: list[_Track], pose: Floats) -> Obstacles:
        place = vehicle_from_world(np.array([one.place_m for one in chosen]).reshape(-1, 2), pose)
        half = 0.5 * np.maximum([one.width_m for one in chosen], self.config.least_width_m)
        sigma, unknown = np.full(len(chosen), self.config.sigma_m), np.full(len(chosen), np.inf)
        identity = np.array(
            [-1 - k if one.identity is None else one.identity for k, one in enumerate(chosen)], np.int64
        )
        return Obstacles(place[:, 0], place[:, 1] - half, place[:, 1] + half, sigma, unknown, identity)

    def keep(self, stands: Callable[[Floats], Bools], pose: Floats) -> None:
        """Remove tracks where `stands` is false, (N,) by places (N, 2) in the axes of the vehicle at `pose`."""
        if self.tracks:
            places = vehicle_from_world(np.array([one.place_m for one in self.tracks]), pose)
            self.tracks = [one for one, stays in zip(self.tracks, stands(places), strict=True) if stays]

    def _count(self, spot: LowObservation, pose: Floats) -> None:
        """Add an observation to its track, or begin one; a truncated one has no place."""
        truncated = spot.truncated and self.config.truncated is not None
        here = np.array([spot.forward_m, spot.middle_m])
        place, one = world_from_vehicle(here, pose), self._known_at(here, pose)
        if one is None:
            if not truncated:
                hits, sure = self._count_of(spot), int(spot.sure)
                self.tracks.append(_Track(place, spot.width_m, pose.copy(), spot.forward_m, hits, sure))
            return
        one.hits, one.sure, one.sightings = one.hits + self._count_of(spot), one.sure + spot.sure, one.sightings + 1
        one.misses, one.truncated = 0, truncated
        self._approach(one, place, pose)
        if not truncated:
            self._place(one, spot, place)
        if one.identity is None and self._stands(one):
            one.identity = self._next_identity()

    def _count_of(self, spot: LowObservation) -> float:
        """The weight of an observation; 0 for one that is not sure."""
        rule = self.config.gain_weight
        if not spot.sure or rule is None:
            return float(spot.sure)
        return min(max(spot.gain / rule.usual_gain, rule.least), rule.most)

    def _stands(self, one: _Track) -> bool:
        """Whether it was observed often enough, over way enough, and came nearer as what stands does."""
        config = self.config
        needed = self.hits_needed
        if config.truncated is not None and one.placed_m < config.way_m:
            needed += config.truncated.more_hits
        return one.came_nearer and one.way_m >= config.way_m and one.hits >= needed

    def _known_at(self, here: Floats, pose: Floats) -> _Track | None:
        """The first track about a place."""
        for one in self.tracks:
            gap = np.abs(vehicle_from_world(one.place_m, pose) - here)
            if gap[0] < self.config.along_m and gap[1] < self.config.across_m:
                return one
        return None

    def _place(self, one: _Track, spot: LowObservation, place_m: Floats) -> None:
        """Average place and width over the observations."""
        newest, one.placed_m = self.config.newest, one.way_m
        one.place_m = one.place_m + newest * (place_m - one.place_m)
        one.width_m += newest * (spot.width_m - one.width_m)

    def _approach(self, one: _Track, place_m: Floats, pose: Floats) -> None:
        """Update the own way since the first observation, and whether the track came nearer by as much.

        The track's own motion along the first heading is subtracted. A truncated one came at least as near.
        """
        one.way_m = distance_m(pose, one.first_pose)
        nearer_m = one.way_m + one.first_forward_m - float(vehicle_from_world(place_m, one.first_pose)[0])
        rule = self.config.truncated if one.truncated else self.config.approach
        moved = one.way_m > self.config.least_way_m
        one.came_nearer = moved and (self.config.approach is None or rule is None or nearer_m > rule.share * one.way_m)

    @property
    def hits_needed(self) -> int:
        """Hits of a confirmed track."""
        clutter = self.config.clutter
        return self.config.hits + (clutter.more_hits if clutter and self._fresh_rate > clutter.rate else 0)

    def _is_kept(self, one: _Track, pose: Floats) -> bool:
        ahead_m = self._forward_m(one, pose)
        if one.identity is None:
            return one.misses < self.config.misses and ahead_m > 0.0
        return ahead_m > -self.config.behind_m

    def _forward_m(self, one: _Track, pose: Floats) -> float:
        return float(vehicle_from_world(one.place_m, pose)[0])


def in_sight(spot: LowObservation, lens_m: Floats, bodies: Obstacles, config: LowTrackConfig) -> LowObservation | None:
    """The part of an observation that a camera at `lens_m` (2,), vehicle axes, sees past known obstacles.

    None if that is too little.
    """
    rule = config.occlusion
    if rule is None:
        return spot
    between = (bodies.forward_m > lens_m[0]) & (bodies.forward_m + rule.beyond_m < spot.forward_m)
    left, right = spot.left_m, spot.right_m
    for body in np.flatnonzero(between):
        beyond = (spot.forward_m - lens_m[0]) / (bodies.forward_m[body] - lens_m[0])
        begins = lens_m[1] + (bodies.left_m[body] - rule.margin_m - lens_m[1]) * beyond
        ends = lens_m[1] + (bodies.right_m[body] + rule.margin_m - lens_m[1]) * beyond
        if begins < right and ends > left:
            left, right = (left, begins) if begins - left > right - ends else (ends, right)
            if right - left < rule.least_seen_m:
                return None
    return replace(spot, left_m=float(left), right_m=float(right))
