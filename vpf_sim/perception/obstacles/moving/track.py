"""Track of one moving vehicle: range of its face, speed along the road, extent and confidence."""

from dataclasses import dataclass
from math import exp

import numpy as np

from vpf_sim.geometry import rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.egomotion.corners import inverse
from vpf_sim.perception.obstacles.moving.extent import Sides
from vpf_sim.perception.obstacles.moving.moving_frame import Course, Residuals
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import FilterConfig
from vpf_sim.perception.obstacles.point_hypotheses import among
from vpf_sim.types import Bools, Camera, Floats, Flow, LateralExtent

LEAST_DEPTH_M = 0.5
LEAST_SLOPE = 0.2  # of a ray along the course: a face is not seen along its plane


@dataclass(frozen=True, slots=True)
class Detection(LateralExtent[float]):
    """A new vehicle by its points, in the axes of the vehicle."""

    depth_m: float  # of the road behind its lowest point, from the camera
    speed_mps: float  # along the road
    sigma_mps: float
    left_m: float  # its sides, right of the vehicle's axis
    right_m: float


class MovingTrack:
    """Filters of the range, of the speed along the road, and of middle and width (`Sides`), in the world.

    Point tracks fix the rate (v - v_b) / Z at which the vehicle expands, its foot fixes the range Z. So a correction
    of Z corrects v_b as well, at the same rate.
    """

    def __init__(
        self, detection: Detection, camera: Camera, pose: Floats, log_odds: float, config: FilterConfig
    ) -> None:
        self._camera, self._config = camera, config
        self.speed_mps = detection.speed_mps
        self.width_m = detection.width_m  # as observed
        place = np.array([camera.forward_m + detection.depth_m, detection.middle_m])
        self._place_m = world_from_vehicle(place, pose)
        self.sigma_m = config.range_ratio * detection.depth_m
        self.sigma_mps = detection.sigma_mps  # at a known range
        self.identity: int | None = None  # once it is confirmed
        self.log_odds = log_odds  # of a moving vehicle
        self.tracks = np.empty(0, np.int64)  # identities of its points at the last observation
        self.course = Course(detection.speed_mps, float(pose[2]), 0.0)
        self._predicted_s = 0.0  # since its sides were observed
        self._sides = Sides(config.extent)

    def predict(self, dt_s: float, direction_rad: float, curvature_per_m: float) -> None:
        """Predict along the road, whose direction in the world and curvature are those at the track."""
        self._place_m = self._place_m + self.speed_mps * dt_s * rotation(direction_rad)[:, 0]
        config = self._config
        self.sigma_m = float(
            np.sqrt((self.sigma_m + config.speed_share * self.sigma_mps * dt_s) ** 2 + config.slip_mps**2 * dt_s)
        )
        self.sigma_mps = min(
            float(np.sqrt(self.sigma_mps**2 + config.acceleration_mps2**2 * dt_s)), config.most_sigma_mps
        )
        self.course = Course(self.speed_mps, direction_rad, curvature_per_m)
        self._predicted_s += dt_s
        self._sides.predict(dt_s)

    def place(self, pose: Floats) -> tuple[float, float]:
        """Forward m of the face and right m of its middle, in the axes of the vehicle at `pose`."""
        forward, right = vehicle_from_world(self._place_m, pose).tolist()
        return forward, right

    def depth_m(self, pose: Floats) -> float:
        """From the camera to the face."""
        return self.place(pose)[0] - self._camera.forward_m

    def closing_share(self, own_mps: float) -> float:
        """Closing speed as a share of the own speed: 1 for what stands, 0 for what is as fast, negative if faster."""
        return 1.0 - self.speed_mps / max(own_mps, 0.1)

    @property
    def half_m(self) -> float:
        """m, half its width."""
        return self._sides.half_m

    @property
    def is_observed(self) -> bool:
        """Whether its sides were observed since the last prediction."""
        return self._predicted_s == 0.0

    def members(self, flow: Flow) -> Bools:
        """(N,) points of the flow that belonged to this track at the last observation."""
        return among(flow.identity, self.tracks)

    def fit(
        self, tracks: Residuals, standing: Floats, own_mps: float, depth_m: float, counts: Bools
    ) -> tuple[Floats, Floats, float]:
        """Fit the rigid body that best explains the point tracks where `counts` (M,).

        Returns (M,) chi2, (M,) m, how far each point lies behind the face, and the change of speed. Speed, course and
        range vary within their uncertainty, equally for all points; each point by its own noise and its place on the
        face. Reweighted least squares (Cauchy). A point that fits the standing scene, chi2 `standing` (M,), counts by
        the odds between the two.
        """
        rate = (own_mps - self.speed_mps) / depth_m
        slope = np.stack([tracks.by_speed, tracks.by_turn, tracks.by_depth - rate * tracks.by_speed], axis=2)
        prior = np.diag(np.array([self.sigma_mps, self._config.turn_rad, self.sigma_m]) ** -2.0)
        weight = inverse(inverse(tracks.weight) + self._config.face_sigma_m**2 * _outer(tracks.by_depth))
        gain = slope.transpose(0, 2, 1) @ weight
        change, residual = np.zeros(3), tracks.residual_px
        for _ in range(3):
            chi2 = _quadratic(weight, residual)
            trust = counts / (1.0 + chi2 / self._config.chi2_limit)
            trust /= 1.0 + np.exp(np.clip(0.5 * (chi2 - standing), -20.0, 20.0))
            normal = prior + np.einsum("m,mij,mjk->ik", trust, gain, slope)
            change = np.linalg.solve(normal, np.einsum("m,mij,mj->i", trust, gain, tracks.residual_px))
            residual = tracks.residual_px - slope @ change
        behind = self._config.face_sigma_m**2 * np.einsum("mi,mij,mj->m", tracks.by_depth, weight, residual)
        return _quadratic(weight, residual), self._config.face_m + behind, float(change[0])

    def _fresh(self, dt_s: float) -> float:
        """The weight of an observation `dt_s` after the last, 1: independent of it."""
        return min(dt_s / self._config.memory_s, 1.0)

    def update_speed(self, change_mps: float, count: int, dt_s: float) -> None:
        """Update the speed at the current range by `count` point tracks of the face."""
        config = self._config
        fresh = self._fresh(dt_s)
        variance = 1.0 / (1.0 / self.sigma_mps**2 + fresh * count / config.track_sigma_mps**2)
        gain = max(1.0 - variance / self.sigma_mps**2, fresh)
        self.speed_mps = max(self.speed_mps + gain * change_mps, 0.0)
        self.sigma_mps = max(float(np.sqrt(variance)), config.least_sigma_mps)

    def update_range(self, foot_m: float, own_mps: float, pose: Floats, dt_s: float) -> None:
        """Update the range by the depth of the lowest point, taken to stand on the road.

        A tentative track may have begun with its foot in its mirror image, so it moves either way alike.
        """
        config = self._config
        forward, right = self.place(pose)
        depth = forward - self._camera.forward_m
        sigma = foot_m * (config.foot_ratio + config.foot_px * foot_m / (self._camera.fy_px * self._camera.height_m))
        if foot_m > depth and self.identity is not None:
            sigma *= config.hidden_foot
        fresh = self._fresh(dt_s)
        variance = self.sigma_m**2 + sigma**2 / fresh
        change = max(self.sigma_m**2 / variance * (foot_m - depth), LEAST_DEPTH_M - depth)
        self.sigma_m *= float(np.sqrt(1.0 - self.sigma_m**2 / variance))
        rate = (own_mps - self.speed_mps) / depth
        self.speed_mps = max(self.speed_mps - rate * change, 0.0)
        self._place_m = world_from_vehicle(np.array([forward + change, right * (1.0 + change / depth)]), pose)

    def update_extent(
        self, face: tuple[float, float], bearing: Floats, odds: Floats, pose: Floats, dt_s: float
    ) -> None:
        """Update middle and width by an observation of the sides.

        `face` are the left and right bearings (tangents) of the face; `bearing` (N,) those of the points about it, with
        their log-odds (N,) of the track against the background. A vehicle seen rather from its side shows no face.
        """
        config = self._config
        forward, right = self.place(pose)
        depth = forward - self._camera.forward_m
        newest = 1.0 - exp(-dt_s / config.side_s)
        self.width_m += newest * ((face[1] - face[0]) * depth - self.width_m)
        own = rotation(self.course.direction_rad - pose[2])  # of the track's axes in the vehicle's
        camera = own.T @ [self._camera.forward_m - forward, -right]  # in the track's axes, from the face's middle
        if not len(bearing) or -camera[0] < max(config.nearest_m, abs(camera[1])):
            return
        self._predicted_s = 0.0
        ray = np.stack([np.ones(len(bearing)), bearing], axis=1) @ own
        across = camera[1] - camera[0] * ray[:, 1] / np.maximum(ray[:, 0], LEAST_SLOPE)
        change = self._sides.update(across, odds, float(camera[1]), -float(camera[0]), self._fresh(dt_s))
        self._place_m = world_from_vehicle(np.array([forward, right]) + change * own[:, 1], pose)


def _outer(vectors: Floats) -> Floats:
    return vectors[:, :, None] * vectors[:, None, :]


def _quadratic(matrices: Floats, vectors: Floats) -> Floats:
    result: Floats = np.einsum("mi,mij,mj->m", vectors, matrices, vectors)
    return result
