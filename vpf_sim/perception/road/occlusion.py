"""The road that known bodies cover and hide, as long as they may be: of most only the end that faces us is told."""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Bools, Floats, Obstacles, RoadEdges

FAR_M = 40.0  # from the camera, up to which a body hides the road


@dataclass(frozen=True, slots=True)
class OcclusionConfig:
    """How far the road is left out about a known body."""

    before_m: float = 0.8  # its face
    beside_m: float = 0.35
    car_width_m: float = 1.0  # what is wider may be a car,
    car_length_m: float = 5.5
    truck_width_m: float = 2.25  # or, as for the planner, a truck
    truck_length_m: float = 9.0
    length_m: float = 1.0  # of any other
    driven_m: float = 4.0  # behind the face of one that drives nothing stands,
    driven_sigma_m: float = 1.5  # if its distance is known so well (standard deviation)

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")
        if not self.car_width_m < self.truck_width_m:
            raise ValueError(f"car_width_m: expected < truck_width_m = {self.truck_width_m}, got {self.car_width_m}")

    def lengths_m(self, width_m: Floats) -> Floats:
        """(K,) how long bodies may be that are so wide."""
        wide = [width_m > self.truck_width_m, width_m > self.car_width_m]
        return np.select(wide, [self.truck_length_m, self.car_length_m], self.length_m)


def footprints(bodies: Obstacles, road: RoadEdges, config: OcclusionConfig, since_s: float = 0.0) -> Floats:
    """(K, 4, 2) corners of what each body covers, or did `since_s` ago, at most, vehicle axes: it is along the road."""
    length = config.lengths_m(bodies.width_m)
    along, across = _axes(bodies, road)
    half = (0.5 * bodies.width_m + config.beside_m)[:, None] * across
    middle = np.stack([bodies.forward_m, bodies.middle_m], axis=1)
    before = config.before_m + since_s * bodies.speed_mps
    near, far = middle - before[:, None] * along, middle + length[:, None] * along
    return np.stack([near - half, near + half, far + half, far - half], axis=1)


def driven_over(places_m: Floats, moving: Obstacles, road: RoadEdges, config: OcclusionConfig) -> Bools:
    """(N,) which of the places (N, 2), vehicle axes, lie where a body drives now: nothing stands there."""
    moving = moving.chosen(moving.sigma_m < config.driven_sigma_m)
    along, across = _axes(moving, road)
    apart = places_m[:, None] - np.stack([moving.forward_m, moving.middle_m], axis=1)
    behind, beside = (apart * along).sum(axis=2), (apart * across).sum(axis=2)
    inside = (np.abs(beside) < 0.5 * moving.width_m) & (behind > -config.before_m) & (behind < config.driven_m)
    over: Bools = np.any(inside, axis=1)
    return over


def _axes(bodies: Obstacles, road: RoadEdges) -> tuple[Floats, Floats]:
    """(K, 2) directions along the road and across it, to the right, where the bodies are."""
    angle = direction_rad(bodies.forward_m, road)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.stack([-np.sin(angle), np.cos(angle)], axis=1)


def shadow(corners_m: Floats, lens_m: Floats) -> Floats:
    """(N, 2) outline of what a body with these corners (4, 2) covers and hides from a camera at `lens_m` (2,).

    Where the camera is itself within the corners they are wrong: a body hides nothing then but what it covers.
    """
    if cv2.pointPolygonTest(corners_m.astype(np.float32), lens_m.tolist(), False) >= 0.0:
        return corners_m
    sight = corners_m - lens_m
    beyond = lens_m + sight * (FAR_M / np.hypot(*sight.T))[:, None]
    hull = cv2.convexHull(np.concatenate([corners_m, beyond]).astype(np.float32))
    return np.asarray(hull[:, 0], np.float64)
