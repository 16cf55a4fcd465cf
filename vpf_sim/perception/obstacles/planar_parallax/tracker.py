"""Tracks of low obstacles: confirmed over several observations, kept in the world until passed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import distance_m, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import LowTrackConfig
from vpf_sim.types import Floats, Obstacles


@dataclass(slots=True)
class _Track:
    """A tentative or confirmed low obstacle, in the world."""

    place_m: Floats  # (2,) the middle of its face
    width_m: float
    first_pose: Floats  # (3,) of the car at the first observation
    first_forward_m: float  # of that observation
    hits: float  # observations, weighted by their gain
    misses: int = 0
    identity: int | None = None  # once it is confirmed


class LowObstacleTracks:
    """Tracker of low obstacles, from the observations of planar parallax."""

    def __init__(
        self, config: LowTrackConfig, next_identity: Callable[[], int], near_m: float, behind_m: float
    ) -> None:
        """The observed patch ends `near_m` ahead of the pose; confirmed tracks are pruned `behind_m` behind it."""
        self.config = config
        self._near_m, self._behind_m = near_m, behind_m
        self._next_identity = next_identity
        self.tracks: list[_Track] = []
        self._new_rate = 0.0  # new tracks per look

    @property
    def hits_needed(self) -> int:
        """Hits of a confirmed track."""
        config, clutter = self.config, self.config.clutter
        return config.hits + (clutter.more_hits if self._new_rate > clutter.rate else 0)

    def record(self, observations: list[LowObservation], pose: Floats) -> None:
        """Add one frame's observations by the vehicle at `pose`."""
        for track in self.tracks:
            if self._forward_m(track, pose) > self._near_m:
                track.misses += 1
        before = len(self.tracks)
        for one in observations:
            self._add(one, pose)
        self._new_rate += (len(self.tracks) - before - self._new_rate) / self.config.clutter.looks
        self.tracks = [track for track in self.tracks if self._is_kept(track, pose)]

    def bodies(self, pose: Floats) -> Obstacles:
        """The confirmed tracks, in the axes of the vehicle at `pose`."""
        chosen = [track for track in self.tracks if track.identity is not None]
        place = vehicle_from_world(np.array([track.place_m for track in chosen]).reshape(-1, 2), pose)
        half = 0.5 * np.maximum([track.width_m for track in chosen], self.config.least_width_m)
        sigma, unknown = np.full(len(chosen), self.config.sigma_m), np.full(len(chosen), np.inf)
        identity = np.array([track.identity for track in chosen], np.int64)
        return Obstacles(place[:, 0], place[:, 1] - half, place[:, 1] + half, sigma, unknown, identity)

    def _add(self, one: LowObservation, pose: Floats) -> None:
        """Add an observation to its track, averaging place and width, or begin a track."""
        here, newest = np.array([one.forward_m, one.middle_m]), self.config.newest
        place, track = world_from_vehicle(here, pose), self._track_at(here, pose)
        if track is None:
            self.tracks.append(_Track(place, one.width_m, pose.copy(), one.forward_m, self._weight(one)))
            return
        track.hits, track.misses = track.hits + self._weight(one), 0
        track.place_m = track.place_m + newest * (place - track.place_m)
        track.width_m += newest * (one.width_m - track.width_m)
        travel_m = distance_m(pose, track.first_pose)
        enough = travel_m >= self.config.way_m and track.hits >= self.hits_needed
        if track.identity is None and enough and self._approaches(track, place, travel_m):
            track.identity = self._next_identity()

    def _weight(self, one: LowObservation) -> float:
        """What an observation counts: mirror images are fainter than what stands."""
        rule = self.config.gain_weight
        return min(max(one.gain / rule.usual_gain, rule.least), rule.most)

    def _approaches(self, track: _Track, place_m: Floats, travel_m: float) -> bool:
        """Whether it came nearer by the car's own way. Drops on the windscreen do not, mirror images by less."""
        own_m = float(vehicle_from_world(place_m, track.first_pose)[0]) - track.first_forward_m
        return travel_m - own_m > self.config.approach_share * travel_m

    def _track_at(self, here: Floats, pose: Floats) -> _Track | None:
        """The first track about a place."""
        for track in self.tracks:
            gap = np.abs(vehicle_from_world(track.place_m, pose) - here)
            if gap[0] < self.config.along_m and gap[1] < self.config.across_m:
                return track
        return None

    def _is_kept(self, track: _Track, pose: Floats) -> bool:
        ahead_m = self._forward_m(track, pose)
        if track.identity is None:
            return track.misses < self.config.misses and ahead_m > 0.0
        return ahead_m > -self._behind_m

    def _forward_m(self, track: _Track, pose: Floats) -> float:
        return float(vehicle_from_world(track.place_m, pose)[0])
