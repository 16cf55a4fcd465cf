"""Where across the road a body is and how wide, from the points that are of it and those that are not.

A point of a body lies anywhere in its silhouette: so a cluster narrower than the body bounds its place to an interval,
and does not say where in it the body's middle is. What stands behind it is seen beside it. Each reading is a uniform
density over where its points can be seen, with some that stray; the belief is a normal density of the middle and a
weight for each width, a look multiplies it by the likelihood of the points on a grid, and the moments of the product
are kept (assumed density filtering, Maybeck, Stochastic Models, Estimation, and Control 2, 1982, ch. 12).
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Floats

UNLIKELY = 1e-4  # a width is not given up for good


@dataclass(frozen=True, slots=True)
class TrackExtentConfig:
    """How points tell of a body's sides."""

    narrowest_m: float = 1.9  # vehicle, with its mirrors, and
    widest_m: float = 2.6
    width_sigma_m: float = 0.25  # by which most are wider than the narrowest
    widths: int = 4  # that are weighed
    length_m: float = 4.5  # of its side, over which its points grow rarer
    blur_m: float = 0.15  # of a silhouette's edge, and
    blur_rad: float = 0.01
    reach_m: float = 1.6  # of the grid to each side of the middle believed
    step_m: float = 0.1
    stray: float = 0.1  # of the points of a body that seem to lie elsewhere
    through: float = 0.2  # and of those behind it that seem to lie in it
    window_rad: float = 0.02  # points nearer across share windows of the flow, and count as one
    sigma_m: float = 0.6  # of the middle of a body that is found,
    least_sigma_m: float = 0.08  # and of one well seen
    drift_mps: float = 0.25  # across its course, in a second
    memory_s: float = 0.5  # tracks that are looked at again within this time say the same
    cap: float = 4.0  # log-odds of one point

    def __post_init__(self) -> None:
        if not 0.0 < self.narrowest_m < self.widest_m:
            raise ValueError(f"narrowest_m: expected 0 < it < widest_m = {self.widest_m}, got {self.narrowest_m}")


class Sides:
    """The belief of one body's middle, along the axis across its course, and of its width."""

    def __init__(self, config: TrackExtentConfig) -> None:
        self._config = config
        self.sigma_m = config.sigma_m
        self._width_m = np.linspace(config.narrowest_m, config.widest_m, config.widths)
        self._log = -0.5 * ((self._width_m - config.narrowest_m) / config.width_sigma_m) ** 2
        count = round(config.reach_m / config.step_m)
        self._grid_m = config.step_m * np.arange(-count, count + 1)
        self.half_m = self._half_m()

    def _half_m(self) -> float:
        """m, half the width expected."""
        weight = np.exp(self._log - self._log.max())
        return 0.5 * float(weight @ self._width_m / weight.sum())

    def predict(self, dt_s: float) -> None:
        """dt seconds on."""
        self.sigma_m = float(np.hypot(self.sigma_m, self._config.drift_mps * np.sqrt(dt_s)))

    def look(self, across_m: Floats, odds: Floats, camera_m: float, depth_m: float, dt_s: float) -> float:
        """m, by which the middle lies farther right after a look, dt seconds after the last.

        The rays of N points meet the face's plane `across_m` (N,) right of the middle believed, and `odds` (N,) are
        their log-odds to be of the body against being of what stands behind. The camera is `camera_m` right of the
        middle and `depth_m` before the face.
        """
        config = self._config
        if not len(across_m):
            return 0.0
        fresh = min(dt_s / config.memory_s, 1.0)
        log = self._log[:, None] - 0.5 * (self._grid_m / self.sigma_m) ** 2
        log += fresh * self._likelihood(across_m, np.clip(odds, -config.cap, config.cap), camera_m, depth_m)
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        place = weight.sum(axis=0)
        change = float(place @ self._grid_m)
        self.sigma_m = max(float(np.sqrt(place @ (self._grid_m - change) ** 2)), config.least_sigma_m)
        self._log = np.log(weight.sum(axis=1) + UNLIKELY)
        self.half_m = self._half_m()
        return change

    def _likelihood(self, across_m: Floats, odds: Floats, camera_m: float, depth_m: float) -> Floats:
        """(W, K) log-likelihood of the points for each width and each middle of the grid."""
        config = self._config
        chance = 1.0 / (1.0 + np.exp(-odds))
        tells = np.abs(2.0 * chance - 1.0)
        crowd = (np.abs(across_m[:, None] - across_m) < config.window_rad * depth_m) @ tells
        told = np.flatnonzero(tells > 0.0)
        inside, size = self._silhouette(across_m[told], camera_m, depth_m)
        span = 2.0 * (config.reach_m + config.widest_m)
        own = inside * ((1.0 - config.stray) / size) + config.stray / span
        other = (1.0 - inside) * ((1.0 - config.through) / (span - size)) + config.through / span
        density = other + chance[told, None, None] * (own - other)
        likelihood: Floats = np.tensordot(tells[told] / np.maximum(crowd[told], 1.0), np.log(density), axes=1)
        return likelihood

    def _silhouette(self, across_m: Floats, camera_m: float, depth_m: float) -> tuple[Floats, Floats]:
        """(N, W, K) from 0 to 1, how far points lie in the face or in the side turned to us, and (W, K) m, its size.

        The ray of a point of that side meets the face's plane beside the face, so far as the side is long.
        """
        config = self._config
        blur = config.blur_m + config.blur_rad * depth_m
        share = config.length_m / (depth_m + config.length_m)
        half = 0.5 * self._width_m[:, None]
        left, right = self._grid_m - half, self._grid_m + half
        left_side, right_side = share * np.maximum(left - camera_m, 0.0), share * np.maximum(camera_m - right, 0.0)
        point = across_m[:, None, None]
        inside = np.clip((point - (left - left_side - blur)) / (left_side + 2.0 * blur), 0.0, 1.0)
        inside *= np.clip(((right + right_side + blur) - point) / (right_side + 2.0 * blur), 0.0, 1.0)
        return inside, right - left + 0.5 * (left_side + right_side)
