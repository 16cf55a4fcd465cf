"""Footprints and occlusion by obstacles, with their largest lengths: of most only the face is observed."""

import cv2
import numpy as np

from vpf_sim.perception.object_sizes import lengths_m
from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Floats, Obstacles, RoadEdges

BEFORE_M, BESIDE_M = 0.8, 0.35  # margins of the occluded region, before the face and at both sides
FAR_M = 40.0  # from the camera, up to which a body hides the road


def footprints(bodies: Obstacles, road: RoadEdges, since_s: float = 0.0) -> Floats:
    """(K, 4, 2) corners of what each body covers, or did `since_s` ago, at most, vehicle axes: it is along the road."""
    length = lengths_m(bodies.width_m)
    along, across = _axes(bodies, road)
    half = (0.5 * bodies.width_m + BESIDE_M)[:, None] * across
    middle = np.stack([bodies.forward_m, bodies.middle_m], axis=1)
    before = BEFORE_M + since_s * bodies.speed_mps
    near, far = middle - before[:, None] * along, middle + length[:, None] * along
    return np.stack([near - half, near + half, far + half, far - half], axis=1)


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
