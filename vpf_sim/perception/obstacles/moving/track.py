"""One body that moves: where its face is, how fast it drives along the road, and how sure that is."""

from dataclasses import dataclass, field
from math import exp

import numpy as np

from vpf_sim.geometry import rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.moving.extent import Sides, SidesConfig
from vpf_sim.perception.obstacles.moving.moving_frame import Course, Residuals
from vpf_sim.perception.obstacles.point_hypotheses import among
from vpf_sim.types import Bools, Camera, Floats, Flow, Sided

FITS = 3
NEAREST_M = 1.0  # before a face, from where its sides are looked at
LEAST_SLOPE = 0.2  # of a ray along its course: a face is not seen along its plane


@dataclass(frozen=True, slots=True)
class Sight(Sided[float]):
    """What the tracks of a body say when it is found."""

    depth_m: float  # of the road behind its lowest point, from the camera
    speed_mps: float  # along the road
    sigma_mps: float
    left_m: float  # its sides, right of the vehicle's axis
    right_m: float


@dataclass(frozen=True, slots=True)
class FilterConfig:
    """Noise of the measurements and of the body's own driving."""

    foot_height_m: float = 0.12  # of the lowest points that can be followed
    foot_px: float = 1.5  # standard deviation of the foot's row
    foot_ratio: float = 0.04  # and of its depth, as a share
    foot_hidden: float = 2.5  # times as much where a believed one's seems farther: the lowest point need not be it
    acceleration_mps2: float = 1.0  # over a second
    slip_mps: float = 0.3  # of the place, what the model does not know
    face_m: float = 0.3  # points of the face lie so far behind it on average,
    face_sigma_m: float = 0.8  # give or take
    side_m: float = 2.7  # and those of the sides so far,
    side_sigma_m: float = 1.4
    turn_rad: float = 0.04  # standard deviation of its course
    memory_s: float = 0.5  # tracks that are looked at again within this time say the same
    track_sigma_mps: float = 0.5  # of what one track tells of the speed
    least_sigma_mps: float = 0.1
    side_s: float = 0.2  # time constant of the width seen
    drift_mps: float = 0.06  # by which its sides may lie farther out while they are predicted,
    drift_m: float = 0.3  # and at most: it keeps its lane
    clip: float = 2.0  # standard deviations of an innovation that are taken
    chi2_limit: float = 9.0  # of a track that belongs to the body
    sides: SidesConfig = field(default_factory=SidesConfig)


class Mover:
    """Filters of the distance, of the speed along the road, and of the place across (`Sides`).

    Tracks fix the rate (v - v_b) / Z at which the body grows, its foot the distance Z; so a correction of Z corrects
    v_b with it, at the same rate. It lives in the world, so what is not seen for a while is predicted: along the road
    at its speed.
    """

    def __init__(self, sight: Sight, camera: Camera, pose: Floats, log_odds: float, config: FilterConfig) -> None:
        self._camera, self._config = camera, config
        self.speed_mps = sight.speed_mps
        self.width_m = sight.width_m  # as it is seen
        place = np.array([camera.forward_m + sight.depth_m, sight.middle_m])
        self._place_m = world_from_vehicle(place, pose)
        self.sigma_m = 0.15 * sight.depth_m
        self.sigma_mps = sight.sigma_mps  # at a known distance
        self.identity: int | None = None  # once it is believed
        self.log_odds = log_odds  # of a body that moves, against all that stands
        self.credit = -np.inf  # log-odds that it has at least once it cannot be looked at
        self.tracks = np.empty(0, np.int64)  # identities of those that were of it at the last look
        self.course = Course(sight.speed_mps, float(pose[2]), 0.0)
        self._predicted_s = 0.0  # since its sides were seen
        self._sides = Sides(config.sides)

    def predict(self, dt_s: float, direction_rad: float, curvature_per_m: float) -> None:
        """dt seconds on along the road, which has that direction in the world and that bend there."""
        self._place_m = self._place_m + self.speed_mps * dt_s * rotation(direction_rad)[:, 0]
        config = self._config
        self.sigma_m = float(np.sqrt((self.sigma_m + 0.3 * self.sigma_mps * dt_s) ** 2 + config.slip_mps**2 * dt_s))
        self.sigma_mps = min(float(np.sqrt(self.sigma_mps**2 + config.acceleration_mps2**2 * dt_s)), 2.0)
        self.course = Course(self.speed_mps, direction_rad, curvature_per_m)
        self._predicted_s += dt_s
        self._sides.predict(dt_s)

    def place(self, pose: Floats) -> tuple[float, float]:
        """Forward m of the face and right m of its middle, in the axes of the vehicle."""
        forward, right = vehicle_from_world(self._place_m, pose).tolist()
        return forward, right

    def depth_m(self, pose: Floats) -> float:
        """From the camera to the face."""
        return self.place(pose)[0] - self._camera.forward_m

    def closing_share(self, own_mps: float) -> float:
        """How fast we come nearer as a share of our speed: 1 to what stands, 0 to what is as fast, negative to what
        runs away."""
        return 1.0 - self.speed_mps / max(own_mps, 0.1)

    @property
    def half_m(self) -> float:
        """m, half the width that it takes, as wide as a vehicle is."""
        return self._sides.half_m

    @property
    def reach_m(self) -> float:
        """m from its middle to where its sides may be by now."""
        return self.half_m + min(self._config.drift_mps * self._predicted_s, self._config.drift_m)

    @property
    def is_seen(self) -> bool:
        """Whether its sides were seen since it was last predicted."""
        return self._predicted_s == 0.0

    def mine(self, flow: Flow) -> Bools:
        """(N,) points that were of this body at the last look."""
        return among(flow.identity, self.tracks)

    def fit(
        self, tracks: Residuals, standing: Floats, own_mps: float, depth_m: float, counts: Bools
    ) -> tuple[Floats, Floats, float]:
        """(M,) chi2 of the tracks on the one rigid body that explains those best that count (M,), (M,) m, by how much
        each point lies behind its face, and the change of speed it has.

        Speed, course and distance may differ from what is believed by what is not known of them, for all tracks alike;
        a track by its own noise and by where on the face its point is. Reweighted least squares (Cauchy); a track that
        has the chi2 `standing` (M,) as one that stands counts by the odds between the two.
        """
        rate = (own_mps - self.speed_mps) / depth_m
        slope = np.stack([tracks.by_speed, tracks.by_turn, tracks.by_depth - rate * tracks.by_speed], axis=2)
        prior = np.diag(np.array([self.sigma_mps, self._config.turn_rad, self.sigma_m]) ** -2.0)
        inverse = _inverse(_inverse(tracks.weight) + self._config.face_sigma_m**2 * _outer(tracks.by_depth))
        gain = slope.transpose(0, 2, 1) @ inverse
        change, residual = np.zeros(3), tracks.residual_px
        for _ in range(FITS):
            chi2 = _quadratic(inverse, residual)
            trust = counts / (1.0 + chi2 / self._config.chi2_limit)
            trust /= 1.0 + np.exp(np.clip(0.5 * (chi2 - standing), -20.0, 20.0))
            normal = prior + np.einsum("m,mij,mjk->ik", trust, gain, slope)
            change = np.linalg.solve(normal, np.einsum("m,mij,mj->i", trust, gain, tracks.residual_px))
            residual = tracks.residual_px - slope @ change
        behind = self._config.face_sigma_m**2 * np.einsum("mi,mij,mj->m", tracks.by_depth, inverse, residual)
        return _quadratic(inverse, residual), self._config.face_m + behind, float(change[0])

    def grow(self, change_mps: float, count: int, dt_s: float) -> None:
        """One look at so many tracks of its face, dt seconds after the last: the speed at the distance believed."""
        config = self._config
        fresh = min(dt_s / config.memory_s, 1.0)
        variance = 1.0 / (1.0 / self.sigma_mps**2 + fresh * count / config.track_sigma_mps**2)
        gain = max(1.0 - variance / self.sigma_mps**2, fresh)
        self.speed_mps = max(self.speed_mps + gain * change_mps, 0.0)
        self.sigma_mps = max(float(np.sqrt(variance)), config.least_sigma_mps)

    def stand(self, foot_m: float, own_mps: float, pose: Floats, dt_s: float) -> None:
        """It stands on the road behind its lowest point: once it is believed, not beyond it, and with less weight not
        before it. What is only suspected may have begun with a foot in its mirror image."""
        config = self._config
        forward, right = self.place(pose)
        depth = forward - self._camera.forward_m
        sigma = foot_m * (config.foot_ratio + config.foot_px * foot_m / (self._camera.fy_px * self._camera.height_m))
        if foot_m > depth and self.identity is not None:
            sigma *= config.foot_hidden
        fresh = min(dt_s / config.memory_s, 1.0)
        variance = self.sigma_m**2 + sigma**2 / fresh
        limit = config.clip * float(np.sqrt(variance))
        change = self.sigma_m**2 / variance * min(max(foot_m - depth, -limit), limit)
        change = max(change, 0.5 - depth)
        self.sigma_m *= float(np.sqrt(1.0 - self.sigma_m**2 / variance))
        rate = (own_mps - self.speed_mps) / depth
        self.speed_mps = max(self.speed_mps - rate * change, 0.0)
        self._place_m = world_from_vehicle(np.array([forward + change, right * (1.0 + change / depth)]), pose)

    def spread(self, width_m: float, bearing: Floats, odds: Floats, pose: Floats, dt_s: float) -> None:
        """One look at its sides: how wide it seems, and the bearings (N,) of points about it, tangents, with their
        log-odds (N,) to be of it and not of what stands behind it. From its side more than from behind nothing is."""
        self.width_m += (1.0 - exp(-dt_s / self._config.side_s)) * (width_m - self.width_m)
        forward, right = self.place(pose)
        own = rotation(self.course.direction_rad - pose[2])  # of its axes in the vehicle's
        camera = own.T @ [self._camera.forward_m - forward, -right]  # in its axes, from the face's middle
        if not len(bearing) or -camera[0] < max(NEAREST_M, abs(camera[1])):
            return
        self._predicted_s = 0.0
        ray = np.stack([np.ones(len(bearing)), bearing], axis=1) @ own
        across = camera[1] - camera[0] * ray[:, 1] / np.maximum(ray[:, 0], LEAST_SLOPE)
        change = self._sides.look(across, odds, float(camera[1]), -float(camera[0]), dt_s)
        self._place_m = world_from_vehicle(np.array([forward, right]) + change * own[:, 1], pose)


def _outer(vectors: Floats) -> Floats:
    return vectors[:, :, None] * vectors[:, None, :]


def _inverse(matrices: Floats) -> Floats:
    """(M, 2, 2) of symmetric matrices (M, 2, 2)."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    adjoint = np.stack([d, -b, -b, a], axis=1).reshape(-1, 2, 2)
    result: Floats = adjoint / (a * d - b * b)[:, None, None]
    return result


def _quadratic(matrices: Floats, vectors: Floats) -> Floats:
    result: Floats = np.einsum("mi,mij,mj->m", vectors, matrices, vectors)
    return result
