"""Matches a road's lines and verges with a frame, and corrects its state by them."""

from dataclasses import replace
from enum import Enum, auto
from math import isfinite

import numpy as np

from vpf_sim.perception.road.birds_eye import ridge
from vpf_sim.perception.road.feature_matcher import FeatureMatcher
from vpf_sim.perception.road.markings import RidgeMap, RoadFeatures, noise_threshold
from vpf_sim.perception.road.model import PITCH
from vpf_sim.perception.road.road_settings import RoadEdgeConfig, VergeConfig
from vpf_sim.perception.road.state_filter import LaneFilter, initial_covariance
from vpf_sim.perception.road.verges import VergeMatcher
from vpf_sim.types import Camera, Floats, Image, Obstacles


class Match(Enum):
    """What a frame shows where a road is predicted."""

    LINES = auto()  # its lines
    VERGES = auto()  # its verges alone
    OTHERS = auto()  # something, but not this road
    LITTLE = auto()  # too little to say


BY_LINES, BY_ANY = frozenset({Match.LINES}), frozenset({Match.LINES, Match.VERGES})


class LineMatcher(FeatureMatcher):
    """Matches the lines in frames of one camera, and with them the verges, if these are searched for."""

    def __init__(self, camera: Camera, config: RoadEdgeConfig, verges: VergeConfig | None) -> None:
        margin = round((config.ridge_reach_m + config.centroid_m) / config.column_m)
        super().__init__(camera, config, config.patch, margin, config.sigma_m)
        self.config = config
        self.verges = None if verges is None else VergeMatcher(camera, config, verges)

    def ridges(self, grey: Image, obstacles: Obstacles | None, pitch_rad: float) -> RidgeMap:
        """The ridges of a frame outside the parts that obstacles hide."""
        config = self.config
        response = ridge(self.view.warp(grey), round(config.ridge_reach_m / config.column_m))
        threshold = noise_threshold(response, config.least_contrast)
        return RidgeMap(self.view, response, threshold, self.visible(obstacles, pitch_rad), config.centroid_m)

    def features(self, image_rgb: Image, grey: Image, obstacles: Obstacles | None, pitch_rad: float) -> RoadFeatures:
        """What a frame shows of the road outside the parts that obstacles hide."""
        steps = None if self.verges is None else self.verges.steps(image_rgb, obstacles, pitch_rad)
        return RoadFeatures(self.ridges(grey, obstacles, pitch_rad), steps)

    def correct(self, tracked: LaneFilter, features: RoadFeatures, numbers: Floats) -> Match:
        """Correct the state by lines and verges, by their near part alone, or by the verges alone, if one matches."""
        found, parts = self.sightings(tracked, features.ridges, numbers), []
        if self.verges is not None and features.steps is not None and tracked.verges:
            verges = self.verges.sightings(tracked, features.steps, tracked.verge_numbers)
            found = found.joined(verges)
            parts = [verges] if np.count_nonzero(verges.seen) >= self.config.least_rows else []
        if np.count_nonzero(found.seen) < self.config.least_rows:
            return Match.LITTLE
        near = replace(found, seen=found.seen & (found.forward_m < self.config.filter.near_part.within_m))
        known = tracked.state, tracked.covariance
        for part in (found, near, *parts):
            tracked.correct(part)
            if self.is_sane(tracked.state) and tracked.agrees(part):
                by_lines = not tracked.verges or any(tracked.agrees(seen.lines) for seen in (found, near))
                return Match.LINES if by_lines else Match.VERGES
            tracked.state, tracked.covariance = known
        return Match.OTHERS

    def update_verges(self, tracked: LaneFilter, features: RoadFeatures) -> None:
        """Judge the known verges of a road, and add those that are found."""
        if self.verges is not None and features.steps is not None:
            self.verges.judge(tracked, features.steps)
            self.verges.find(tracked, features.steps)

    def settle(
        self, guess: Floats, features: RoadFeatures, numbers: Floats, sigma_m: float, pitch_sigma_rad: float
    ) -> tuple[LaneFilter, Match]:
        """The road about a first guess, corrected several times by one frame, and what showed it at last.

        The standard deviations are those of the guess's place and pitch.
        """
        first, match = self.config.first_guess, Match.LITTLE
        found = LaneFilter(guess, np.empty(0), self.camera, self.config.filter)
        sigmas = (sigma_m, first.sigma_rad, first.width_sigma_m, pitch_sigma_rad)
        for _ in range(first.corrections):
            found.covariance = initial_covariance(*sigmas, self.config.filter)
            found.verges.clear()
            self.update_verges(found, features)
            match = self.correct(found, features, numbers)
            if match not in BY_ANY:
                break
        return found, match

    def is_sane(self, state: Floats, turned_rad: float | None = None) -> bool:
        """Whether the model can draw this road; `turned_rad` is the largest heading, None: of a tracked road."""
        config, limits = self.config, self.config.filter
        _, heading, *curvatures, width, pitch = state[: PITCH + 1].tolist()
        bent = all(abs(curvature) < limits.tightest_per_m for curvature in curvatures)
        straight = abs(heading) < (turned_rad or limits.turned_rad) and abs(pitch) < limits.steepest_rad
        wide = config.narrowest_lane_m - config.wider_m < width < config.widest_lane_m + config.wider_m
        return isfinite(state[0]) and straight and bent and wide
