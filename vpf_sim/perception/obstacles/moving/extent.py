"""Where across the road a vehicle is and how wide, from its points and those of the background.

A vehicle's point lies anywhere in its silhouette, so a cluster narrower than the vehicle bounds its middle to an
interval. The background is seen beside it. Each hypothesis is a uniform density over the places of its points, with
outliers. The belief is a normal density of the middle and a weight for each width. An observation multiplies it by the
likelihood of the points on a grid, and the moments of the product are kept (assumed density filtering, Maybeck,
Stochastic Models, Estimation, and Control 2, 1982, ch. 12).
"""

import numpy as np

from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import ExtentConfig
from vpf_sim.types import Floats

WIDTHS = 4  # hypotheses
REACH_M = 1.6  # of the grid of middles, to each side
GRID_M = 0.1 * np.arange(-16, 17)


class Sides:
    """Belief of one vehicle's middle, along the axis across its course, and of its width."""

    def __init__(self, config: ExtentConfig) -> None:
        self._config = config
        self.sigma_m = config.sigma_m
        self._width_m = np.linspace(config.narrowest_m, config.widest_m, WIDTHS)
        self._log = -0.5 * ((self._width_m - config.narrowest_m) / config.width_sigma_m) ** 2
        self.half_m = self._half_m()

    def _half_m(self) -> float:
        """m, half the width expected."""
        weight = np.exp(self._log - self._log.max())
        return 0.5 * float(weight @ self._width_m / weight.sum())

    def predict(self, dt_s: float) -> None:
        """dt seconds on."""
        self.sigma_m = float(np.hypot(self.sigma_m, self._config.drift_mps * np.sqrt(dt_s)))

    def update(self, across_m: Floats, odds: Floats, camera_m: float, depth_m: float, fresh: float) -> float:
        """m, by which an observation moves the middle to the right; `fresh` is its weight, 1: independent.

        The rays of N points meet the face's plane `across_m` (N,) right of the middle. Their log-odds `odds` (N,) are
        those of the vehicle against the background. The camera is `camera_m` right of the middle and `depth_m` before
        the face.
        """
        config = self._config
        if not len(across_m):
            return 0.0
        log = self._log[:, None] - 0.5 * (GRID_M / self.sigma_m) ** 2
        log += fresh * self._likelihood(across_m, np.clip(odds, -config.cap, config.cap), camera_m, depth_m)
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        place = weight.sum(axis=0)
        change = float(place @ GRID_M)
        self.sigma_m = max(float(np.sqrt(place @ (GRID_M - change) ** 2)), config.least_sigma_m)
        self._log = np.log(weight.sum(axis=1) + 1e-4)  # no width becomes impossible
        self.half_m = self._half_m()
        return change

    def _likelihood(self, across_m: Floats, odds: Floats, camera_m: float, depth_m: float) -> Floats:
        """(W, K) log-likelihood of the points for each width and each middle of the grid."""
        config = self._config
        chance = 1.0 / (1.0 + np.exp(-odds))
        weight = np.abs(2.0 * chance - 1.0)
        decided = np.flatnonzero(weight > 0.0)
        inside, size = self._silhouette(across_m[decided], camera_m, depth_m)
        span = 2.0 * (REACH_M + config.widest_m)
        own = inside * ((1.0 - config.stray) / size) + config.stray / span
        other = (1.0 - inside) * ((1.0 - config.through) / (span - size)) + config.through / span
        density = other + chance[decided, None, None] * (own - other)
        crowd = (np.abs(across_m[:, None] - across_m) < config.window_rad * depth_m) @ weight
        weight = weight / np.maximum(crowd, 1.0)
        likelihood: Floats = np.tensordot(weight[decided], np.log(density), axes=1)
        return likelihood

    def _silhouette(self, across_m: Floats, camera_m: float, depth_m: float) -> tuple[Floats, Floats]:
        """(N, W, K) from 0 to 1, how far points lie in the face or the flank we see, and (W, K) m, their size.

        The ray of a point of the flank meets the face's plane beside the face.
        """
        config = self._config
        blur = config.blur_m + config.blur_rad * depth_m
        share = config.flank_m / (depth_m + config.flank_m)
        half = 0.5 * self._width_m[:, None]
        left, right = GRID_M - half, GRID_M + half
        left_side, right_side = share * np.maximum(left - camera_m, 0.0), share * np.maximum(camera_m - right, 0.0)
        point = across_m[:, None, None]
        inside = np.clip((point - (left - left_side - blur)) / (left_side + 2.0 * blur), 0.0, 1.0)
        inside *= np.clip(((right + right_side + blur) - point) / (right_side + 2.0 * blur), 0.0, 1.0)
        return inside, right - left + 0.5 * (left_side + right_side)
