"""Verification at walking pace: is there road in the place of an obstacle?

Obstacles are detected from afar by few points and kept until passed; before a false one the car would stand for good.
From a few metres the texture of the road is visible. Two frames some decimetres apart are mapped to the road plane in
the obstacle's place. Where they show the road, their textures agree without any shift; an object at height h seems
shifted by h / (H - h) of the camera's travel. An obstacle is rejected if the road lies across its whole width, from its
face to where one that was detected too near would stand. Plain surfaces, as dark paint, are never taken for road.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.geometry import distance_m, distort, project, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.config import VerificationConfig
from vpf_sim.types import Bools, Camera, Floats, Image, Obstacles


@dataclass(slots=True)
class _Region:
    """Place of an obstacle in the world, with the products of textures in it, summed over the observations."""

    identity: int
    middle_m: Floats  # (2,)
    width_m: float
    products: Floats  # (3, shifts, cells): of now with then, of now with itself, of then with itself
    observations: int = 0
    is_road: bool = False


class CloseRangeVerifier:
    """Keeps the last frames at walking pace, and rejects obstacles in whose place the road is."""

    def __init__(self, camera: Camera, config: VerificationConfig) -> None:
        self._camera = camera
        self._config = config
        self._past: deque[tuple[Image, Floats]] = deque()
        self._regions: list[_Region] = []

    def needs_frame(self, pose: Floats, speed_mps: float) -> bool:
        """Whether the frame taken at `pose`, at this speed, is used: one for each step at walking pace."""
        went_on = not self._past or distance_m(pose, self._past[-1][1]) >= self._config.step_m
        return speed_mps < self._config.slow_mps and went_on

    def update(
        self,
        image: Image | None,
        pose: Floats,
        obstacles: Obstacles,
        speed_mps: float,
        verified: Callable[[Obstacles], Bools] | None = None,
    ) -> Obstacles:
        """The obstacles without rejected ones, in vehicle axes at `pose`.

        `image` is None under the wiper. Those that are `verified` (K,) stay: between a pedestrian's legs the road is
        visible.
        """
        if speed_mps >= self._config.slow_mps:
            self._past.clear()
            if not any(one.is_road for one in self._regions):
                return obstacles
        self._regions = [one for one in self._regions if vehicle_from_world(one.middle_m, pose)[0] > -30.0]
        regions = [self._region(obstacles, k, pose) for k in range(len(obstacles))]
        if image is not None and self.needs_frame(pose, speed_mps):
            self._observe(image, pose, obstacles, regions)
        kept = np.array([not one.is_road for one in regions], np.bool_)
        if kept.all():
            return obstacles
        return obstacles.chosen(kept if verified is None else kept | verified(obstacles))

    def _region(self, obstacles: Obstacles, k: int, pose: Floats) -> _Region:
        """The region of an obstacle; a new one if its place or width changed."""
        config, identity = self._config, int(obstacles.identity[k])
        width = float(obstacles.right_m[k] - obstacles.left_m[k])
        middle = world_from_vehicle(np.array([obstacles.forward_m[k], obstacles.left_m[k] + 0.5 * width]), pose)
        for one in self._regions:
            moved_m = max(distance_m(middle, one.middle_m), abs(width - one.width_m))
            if one.identity == identity and moved_m < config.moved_m:
                return one
        cells = config.rows * max(1, round(config.across_m(width) / config.cell_m))
        self._regions.append(_Region(identity, middle, width, np.zeros((3, 2 * config.shift_grains + 1, cells))))
        return self._regions[-1]

    def _observe(self, image: Image, pose: Floats, obstacles: Obstacles, regions: list[_Region]) -> None:
        """Compare the frame with the one a baseline before."""
        config = self._config
        self._past.append((image, pose.copy()))
        while len(self._past) > 1 and distance_m(pose, self._past[1][1]) >= config.baseline_m:
            self._past.popleft()
        then = self._past[0]
        if not config.baseline_m <= distance_m(pose, then[1]) < 2.0 * config.baseline_m:
            return
        face = obstacles.forward_m - self._camera.forward_m
        visible = (face > config.nearest_m) & (face < config.farthest_m) & (obstacles.speed_mps == 0.0)
        visible &= np.abs(obstacles.middle_m) < config.most_bearing * face
        for k, one in enumerate(regions):
            if visible[k] and not one.is_road:
                self._compare(one, (image, pose), then, pose)

    def _compare(self, one: _Region, now: tuple[Image, Floats], then: tuple[Image, Floats], pose: Floats) -> None:
        """Add the products of the textures in a region, and judge by all observations.

        The region leads away from the camera: beside the road that a narrow obstacle hides, road is visible past it.
        """
        config = self._config
        middle = vehicle_from_world(one.middle_m, pose)
        margin, across = config.shift_grains, one.products.shape[2] // config.rows
        cell = round(config.cell_m / config.grain_m)
        length = config.rows * cell
        forward = middle[0] - config.margin_m + config.grain_m * np.arange(-margin, length + margin)
        aside = config.across_m(one.width_m) * ((np.arange(across * cell) + 0.5) / (across * cell) - 0.5)
        lens_m = self._camera.forward_m
        right = aside + (middle[1] * (forward - lens_m) / (middle[0] - lens_m))[:, None]
        shape = right.shape
        flat = np.stack([np.broadcast_to(forward[:, None], shape), right], axis=-1)
        place = world_from_vehicle(flat.reshape(-1, 2), pose)
        fresh, old = (self._texture(*view, place, shape) for view in (now, then))
        fresh = fresh[margin : margin + length]
        for index in range(2 * margin + 1):
            moved = old[index : index + length]
            both = np.isfinite(fresh + moved)
            for row, product in enumerate((fresh * moved, fresh * fresh, moved * moved)):
                known = np.where(both, product, 0.0).reshape(config.rows, cell, across, cell)
                one.products[row, index] += known.sum(axis=(1, 3)).ravel()
        one.observations += 1
        one.is_road = one.observations >= config.least_observations and self._is_road(one.products)

    def _texture(self, image: Image, pose: Floats, place_m: Floats, shape: tuple[int, int]) -> Floats:
        """Grey levels at places (N, 2) of the road in the world, less those of lines along the road; nan: unseen."""
        flat = vehicle_from_world(place_m, pose)
        pixels = distort(self._camera, project(self._camera, np.column_stack([flat, np.zeros(len(flat))])))
        x, y = np.nan_to_num(pixels, nan=-10.0).astype(np.float32).reshape(*shape, 2).transpose(2, 0, 1)
        seen = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
        seen = np.asarray(cv2.GaussianBlur(seen, (3, 3), 0), np.float32)
        even = round(self._config.cell_m / self._config.grain_m)
        inside = (x > 0.0) & (x < image.shape[1] - 1.0) & (y > 0.0) & (y < image.shape[0] - 1.0)
        texture: Floats = np.where(inside, seen - cv2.blur(seen, (1, even)), np.nan).astype(np.float64)
        return texture

    def _is_road(self, products: Floats) -> bool:
        """Whether the textures agree without shift in nearly all cells, and in none much better with one.

        An obstacle narrower than it was detected fills only a few cells.
        """
        config = self._config
        correlation = products[0] / np.sqrt(np.maximum(products[1] * products[2], 1e-9))
        shift = np.abs(np.arange(-config.shift_grains, config.shift_grains + 1))
        unshifted = correlation[shift <= config.near_grains].max(axis=0)
        shifted = correlation[shift > config.near_grains + 1].max(axis=0)
        road: Bools = (unshifted > config.least_correlation) & (unshifted > shifted + config.least_lead)
        road &= shifted < config.most_other
        lead = np.where(shifted < config.most_other, config.least_lead, 0.0)
        stands = (shifted > config.least_correlation) & (shifted > unshifted + lead)
        return bool(np.mean(road) >= config.road_share and not stands.any())
