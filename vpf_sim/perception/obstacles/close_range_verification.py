"""A second look, at walking pace, at what was taken for a body: is there road where it should stand?

A body is told from afar, by few points, and kept until the car has passed it; before one that was never there the
car would stand for good. From a few metres the grain of the road is seen well enough to tell: two frames, some
decimetres of way apart, are laid out as road from the body's face on. Where they show the road, their grain agrees
without any shift along the way; what stands h above it seems to have moved on, by h / (H - h) of the camera's way. A
body is refuted where the road lies all across its width, from its face to where even one that was told too near would
stand. What has no grain, as dark paint, is never taken for road.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.geometry import distance_m, distort, project, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.config import VerificationConfig
from vpf_sim.types import Bools, Camera, Floats, Image, Obstacles

PASSED_M = 30.0  # behind the car, where no body is told any more


@dataclass(slots=True)
class _Place:
    """Of a body in the world, and the correlation of the grain in it, summed over the looks."""

    name: int  # the body's identity, which parts of one that fell apart have in common
    middle_m: Floats  # (2,)
    width_m: float
    products: Floats  # (3, shifts, cells): of now with then, of now with itself, of then with itself
    looks: int = 0
    refuted: bool = False


class CloseRangeVerifier:
    """Remembers the last frames at walking pace, and takes away the bodies in whose place the road is."""

    def __init__(self, camera: Camera, config: VerificationConfig) -> None:
        self._camera = camera
        self._config = config
        self._past: deque[tuple[Image, Floats]] = deque()
        self._places: list[_Place] = []

    def looks(self, pose: Floats, speed_mps: float) -> bool:
        """Whether the frame taken at `pose`, at that speed, is looked at: one in a step of way, at walking pace."""
        went_on = not self._past or distance_m(pose, self._past[-1][1]) >= self._config.step_m
        return self._is_slow(speed_mps) and went_on

    def update(
        self,
        image: Image | None,
        pose: Floats,
        bodies: Obstacles,
        speed_mps: float,
        sure: Callable[[Obstacles], Bools] | None = None,
    ) -> Obstacles:
        """The bodies without those that turned out to be road, in the axes of the vehicle at `pose`.

        `image` is None for a frame that shows something else, as a wiper.
        But those that are `sure` (K,) stay: between the legs of who stands there, and past them, the road is seen.
        """
        if not self._is_slow(speed_mps):
            self._past.clear()
            if not any(one.refuted for one in self._places):
                return bodies
        self._forget(pose)
        places = [self._place(bodies, k, pose) for k in range(len(bodies))]
        if image is not None and self.looks(pose, speed_mps):
            self._look(image, pose, bodies, places)
        there = np.array([not one.refuted for one in places], np.bool_)
        if there.all():
            return bodies
        return bodies.chosen(there if sure is None else there | sure(bodies))

    def _is_slow(self, speed_mps: float) -> bool:
        return speed_mps < self._config.slow_mps

    def _forget(self, pose: Floats) -> None:
        """The places that the car has passed."""
        self._places = [one for one in self._places if vehicle_from_world(one.middle_m, pose)[0] > -PASSED_M]

    def _place(self, bodies: Obstacles, k: int, pose: Floats) -> _Place:
        """What is known of a body's; nothing where it is told elsewhere, or wider, than it was."""
        width, name, moved = float(bodies.right_m[k] - bodies.left_m[k]), int(bodies.identity[k]), self._config.moved_m
        middle = world_from_vehicle(np.array([bodies.forward_m[k], bodies.left_m[k] + 0.5 * width]), pose)
        for one in self._places:
            if one.name == name and distance_m(middle, one.middle_m) < moved and abs(width - one.width_m) < moved:
                return one
        cells = self._config.rows * max(1, round(self._config.across_m(width) / self._config.cell_m))
        self._places.append(_Place(name, middle, width, np.zeros((3, 2 * self._config.shift_grains + 1, cells))))
        return self._places[-1]

    def _look(self, image: Image, pose: Floats, bodies: Obstacles, places: Sequence[_Place]) -> None:
        """Compare the frame with the one that was taken a baseline before."""
        config = self._config
        self._past.append((image, pose.copy()))
        while len(self._past) > 1 and distance_m(pose, self._past[1][1]) >= config.baseline_m:
            self._past.popleft()
        older, then = self._past[0]
        if not config.baseline_m <= distance_m(pose, then) < 2.0 * config.baseline_m:
            return
        face = bodies.forward_m - self._camera.forward_m
        looked_at = (face > config.nearest_m) & (face < config.farthest_m) & (bodies.speed_mps == 0.0)
        looked_at &= np.abs(bodies.middle_m) < config.most_bearing * face
        for k, one in enumerate(places):
            if looked_at[k] and not one.refuted:
                self._compare(one, (image, pose), (older, then), pose)

    def _compare(self, one: _Place, now: tuple[Image, Floats], then: tuple[Image, Floats], pose: Floats) -> None:
        """Add the products of the grains in a body's place, and judge by all looks.

        The place goes away from the camera: beside the road that a narrow body hides, off our way, lies road that is
        seen past it.
        """
        config = self._config
        middle = vehicle_from_world(one.middle_m, pose)
        margin, across = config.shift_grains, one.products.shape[2] // config.rows
        cell = round(config.cell_m / config.grain_m)
        length = config.rows * cell
        forward = middle[0] - config.before_m + config.grain_m * np.arange(-margin, length + margin)
        aside = config.across_m(one.width_m) * ((np.arange(across * cell) + 0.5) / (across * cell) - 0.5)
        lens_m = self._camera.forward_m
        right = aside + (middle[1] * (forward - lens_m) / (middle[0] - lens_m))[:, None]
        shape = right.shape
        flat = np.stack([np.broadcast_to(forward[:, None], shape), right], axis=-1)
        place = world_from_vehicle(flat.reshape(-1, 2), pose)
        fresh, old = (self._grain(*view, place, shape) for view in (now, then))
        fresh = fresh[margin : margin + length]
        for index in range(2 * margin + 1):
            moved = old[index : index + length]
            both = np.isfinite(fresh + moved)
            for row, product in enumerate((fresh * moved, fresh * fresh, moved * moved)):
                known = np.where(both, product, 0.0).reshape(config.rows, cell, across, cell)
                one.products[row, index] += known.sum(axis=(1, 3)).ravel()
        one.looks += 1
        one.refuted = one.looks >= config.least_looks and self._is_road(one.products)

    def _grain(self, image: Image, pose: Floats, place_m: Floats, shape: tuple[int, int]) -> Floats:
        """What is seen at places of the road, (N, 2) in the world, less what runs along the way as a line does."""
        flat = vehicle_from_world(place_m, pose)
        pixels = distort(self._camera, project(self._camera, np.column_stack([flat, np.zeros(len(flat))])))
        x, y = np.nan_to_num(pixels, nan=-10.0).astype(np.float32).reshape(*shape, 2).transpose(2, 0, 1)
        seen = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
        seen = np.asarray(cv2.GaussianBlur(seen, (3, 3), 0), np.float32)
        even = round(self._config.cell_m / self._config.grain_m)
        inside = (x > 0.0) & (x < image.shape[1] - 1.0) & (y > 0.0) & (y < image.shape[0] - 1.0)
        grain: Floats = np.where(inside, seen - cv2.blur(seen, (1, even)), np.nan).astype(np.float64)
        return grain

    def _is_road(self, products: Floats) -> bool:
        """Whether the grain agrees without a shift in nearly all cells, and in none far better with one.

        A body that is narrower than it was told fills but a few.
        """
        config = self._config
        correlation = products[0] / np.sqrt(np.maximum(products[1] * products[2], 1e-9))
        shift = np.abs(np.arange(-config.shift_grains, config.shift_grains + 1))
        with_none = correlation[shift <= config.near_grains].max(axis=0)
        with_some = correlation[shift > config.near_grains + 1].max(axis=0)
        road: Bools = (with_none > config.least_correlation) & (with_none > with_some + config.least_lead)
        road &= with_some < config.most_other
        lead = np.where(with_some < config.most_other, config.least_lead, 0.0)
        stands = (with_some > config.least_correlation) & (with_some > with_none + lead)
        return bool(np.mean(road) >= config.road_share and not stands.any())
