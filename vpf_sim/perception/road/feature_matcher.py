"""Sightings of what runs along a tracked road, in a bird's-eye view: lines and verges share it."""

import cv2
import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye, Patch
from vpf_sim.perception.road.markings import RidgeMap, sight
from vpf_sim.perception.road.model import seen_places
from vpf_sim.perception.road.obstacle_mask import hidden_by
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings
from vpf_sim.types import Bools, Camera, Floats, Obstacles


class FeatureMatcher:
    """Sees features that run along the road, lines or verges, in one patch of the road ahead."""

    def __init__(self, camera: Camera, road: RoadEdgeConfig, patch: Patch, margin: int, sigma_m: float) -> None:
        """`margin` is the number of columns beside a place that its response depends on.

        `sigma_m` is the standard deviation of an observation on the road; the pixels' adds to it.
        """
        self.camera, self._road = camera, road
        self.view = BirdsEye(camera, patch)
        self._visible = cv2.erode(self.view.visible.astype(np.uint8), np.ones((1, 2 * margin + 1), np.uint8)) > 0
        depth = self.view.forward_m - camera.forward_m
        self._variance: Floats = sigma_m**2 + (road.sigma_px * depth / camera.fx_px) ** 2

    def visible(self, obstacles: Obstacles | None, pitch_rad: float) -> Bools:
        """(rows, columns) the part of the patch that the frame shows and no obstacle hides."""
        if obstacles is None or not len(obstacles):
            return self._visible
        return self._visible & ~hidden_by(obstacles, self.view, pitch_rad, self._road.obstacle_mask)

    def sightings(self, tracked: LaneFilter, features: RidgeMap, numbers: Floats) -> Sightings:
        """Where the features of these numbers are seen about their predicted places."""
        expected_m, reached = seen_places(tracked.state, numbers, self.view.forward_m, self.camera)
        right_m, seen = sight(features, expected_m, reached, self._road.filter.reach_m)
        return Sightings(numbers, self.view.forward_m, right_m, np.broadcast_to(self._variance, seen.shape), seen)
