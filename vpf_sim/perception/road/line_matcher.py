"""Matches a road's lines and verges with a frame, and corrects its state by them."""

from dataclasses import replace
from math import isfinite

import cv2
import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye, ridge
from vpf_sim.perception.road.markings import RidgeMap, RoadFeatures, noise_threshold, sight
from vpf_sim.perception.road.model import PITCH, seen_places
from vpf_sim.perception.road.obstacle_mask import hidden_by
from vpf_sim.perception.road.road_settings import RoadEdgeConfig, VergeConfig
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.perception.road.verges import VergeMatcher
from vpf_sim.types import Camera, Floats, Image, Obstacles


class LineMatcher:
    """Holds the bird's-eye view of a camera."""

    def __init__(self, camera: Camera, config: RoadEdgeConfig, verges: VergeConfig | None) -> None:
        self.camera = camera
        self.config = config
        self.view = BirdsEye(camera, config.patch)
        self.verges = None if verges is None else VergeMatcher(camera, config, verges)
        margin = 2 * round((config.ridge_reach_m + config.centroid_m) / config.column_m) + 1
        self._visible = cv2.erode(self.view.visible.astype(np.uint8), np.ones((1, margin), np.uint8)) > 0
        depth = self.view.forward_m - camera.forward_m
        self._variance: Floats = config.sigma_m**2 + (config.sigma_px * depth / camera.fx_px) ** 2

    def ridges(self, grey: Image, obstacles: Obstacles | None, pitch_rad: float) -> RidgeMap:
        """The ridges of a frame outside the parts that obstacles hide."""
        config, visible = self.config, self._visible
        response = ridge(self.view.warp(grey), round(config.ridge_reach_m / config.column_m))
        if obstacles is not None and len(obstacles):
            visible = visible & ~hidden_by(obstacles, self.view, pitch_rad, config.obstacle_mask)
        return RidgeMap(
            self.view, response, noise_threshold(response, config.least_contrast), visible, config.centroid_m
        )

    def features(self, image_rgb: Image, grey: Image, obstacles: Obstacles | None, pitch_rad: float) -> RoadFeatures:
        """What a frame shows of the road outside the parts that obstacles hide."""
        steps = None if self.verges is None else self.verges.steps(image_rgb, obstacles, pitch_rad)
        return RoadFeatures(self.ridges(grey, obstacles, pitch_rad), steps)

    def correct(self, tracked: LaneFilter, features: RoadFeatures, numbers: Floats) -> bool | None:
        """Whether the frame corrected the state; None: too little of the road is visible.

        By lines and verges, by their near part alone, or by the verges alone.
        """
        lines, verges = self._sightings(tracked, features.ridges, numbers), None
        if self.verges is not None and features.steps is not None:
            verges = self.verges.sightings(tracked, features.steps)
        found = lines if verges is None else lines.joined(verges)
        if np.count_nonzero(found.seen) < self.config.least_rows:
            return None
        near = replace(found, seen=found.seen & (found.forward_m < self.config.filter.near_part.within_m))
        parts, known = [found, near], (tracked.state, tracked.covariance)
        if verges is not None and np.count_nonzero(verges.seen) >= self.config.least_rows:
            parts.append(verges)
        for part in parts:
            tracked.correct(part)
            if self.is_sane(tracked.state) and tracked.agrees(part):
                return True
            tracked.state, tracked.covariance = known
        return False

    def _sightings(self, tracked: LaneFilter, ridges: RidgeMap, numbers: Floats) -> Sightings:
        """Where the lines are seen about their predicted places."""
        expected_m, reached = seen_places(tracked.state, numbers, self.view.forward_m, self.camera)
        right_m, seen = sight(ridges, expected_m, reached, self.config.filter.reach_m)
        return Sightings(numbers, self.view.forward_m, right_m, np.broadcast_to(self._variance, seen.shape), seen)

    def settle(
        self, guess: Floats, features: RoadFeatures, numbers: Floats, pitch_sigma_rad: float
    ) -> LaneFilter | None:
        """The road about a first guess, corrected several times by one frame; None where it is not visible."""
        first = self.config.first_guess
        found = LaneFilter(guess, np.empty(0), self.camera, self.config.filter)
        sigmas = (first.sigma_m, first.sigma_rad, first.width_sigma_m, pitch_sigma_rad)
        for _ in range(first.corrections):
            found.covariance = initial_covariance(*sigmas, self.config.filter)
            found.verges.clear()
            if self.verges is not None and features.steps is not None:
                self.verges.find(found, features.steps)
            if not self.correct(found, features, numbers):
                return None
        return found

    def is_sane(self, state: Floats, turned_rad: float | None = None) -> bool:
        """Whether the model can draw this road; `turned_rad` is the largest heading, None: of a tracked road."""
        config, limits = self.config, self.config.filter
        _, heading, *curvatures, width, pitch = state[: PITCH + 1].tolist()
        bent = all(abs(curvature) < limits.tightest_per_m for curvature in curvatures)
        straight = abs(heading) < (turned_rad or limits.turned_rad) and abs(pitch) < limits.steepest_rad
        wide = config.narrowest_lane_m - config.wider_m < width < config.widest_lane_m + config.wider_m
        return isfinite(state[0]) and straight and bent and wide
