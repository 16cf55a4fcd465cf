"""Matches a road's lines with the ridges of a frame, and corrects its state by them."""

from dataclasses import replace
from math import isfinite

import cv2
import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye, ridge
from vpf_sim.perception.road.markings import RidgeMap, noise_threshold, sight
from vpf_sim.perception.road.model import seen_places
from vpf_sim.perception.road.obstacle_mask import hidden_by
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.types import Camera, Floats, Image, Obstacles


class LineMatcher:
    """Holds the bird's-eye view of a camera."""

    def __init__(self, camera: Camera, config: RoadEdgeConfig) -> None:
        self.camera = camera
        self.config = config
        self.view = BirdsEye(camera, config.patch)
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

    def correct(self, tracked: LaneFilter, ridges: RidgeMap, numbers: Floats) -> bool | None:
        """Whether the lines corrected the state, all or the near part alone; None: too few are visible."""
        expected_m, reached = seen_places(tracked.state, numbers, self.view.forward_m, self.camera)
        right_m, seen = sight(ridges, expected_m, reached, self.config.filter.reach_m)
        if np.count_nonzero(seen) < self.config.least_rows:
            return None
        found = Sightings(numbers, self.view.forward_m, right_m, np.broadcast_to(self._variance, seen.shape), seen)
        known = tracked.state, tracked.covariance
        for reach_m in (np.inf, self.config.filter.near_part.within_m):
            near = replace(found, seen=found.seen & (found.forward_m < reach_m))
            tracked.correct(near)
            if self.is_sane(tracked.state) and tracked.agrees(near):
                return True
            tracked.state, tracked.covariance = known
        return False

    def settle(self, guess: Floats, ridges: RidgeMap, numbers: Floats, pitch_sigma_rad: float) -> LaneFilter | None:
        """The road about a first guess, corrected several times by one frame; None where its lines are not visible."""
        first = self.config.first_guess
        found = LaneFilter(guess, np.empty(0), self.camera, self.config.filter)
        sigmas = (first.sigma_m, first.sigma_rad, first.width_sigma_m, pitch_sigma_rad)
        for _ in range(first.corrections):
            found.covariance = initial_covariance(*sigmas, self.config.filter)
            if not self.correct(found, ridges, numbers):
                return None
        return found

    def is_sane(self, state: Floats, turned_rad: float | None = None) -> bool:
        """Whether the model can draw this road; `turned_rad` is the largest heading, None: of a tracked road."""
        config, limits = self.config, self.config.filter
        _, heading, *curvatures, width, pitch = state.tolist()
        bent = all(abs(curvature) < limits.tightest_per_m for curvature in curvatures)
        straight = abs(heading) < (turned_rad or limits.turned_rad) and abs(pitch) < limits.steepest_rad
        wide = config.narrowest_lane_m - config.wider_m < width < config.widest_lane_m + config.wider_m
        return isfinite(state[0]) and straight and bent and wide
