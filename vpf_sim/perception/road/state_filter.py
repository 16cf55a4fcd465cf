"""The state of the road over time: predicted by the vehicle's own motion, corrected by the lines that are seen."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from vpf_sim.perception.road.config import NeighbourTestConfig, RoadFilterConfig
from vpf_sim.perception.road.model import CURVATURES, NODES_M, PITCH, SIZE, moved, seen_lines, seen_places
from vpf_sim.types import Bools, Camera, Floats


@dataclass(frozen=True, slots=True)
class Sightings:
    """Where the lines were seen, on a grid of L lines and R rows."""

    numbers: Floats  # (L,) of the lines
    forward_m: Floats  # (R,)
    right_m: Floats  # (L, R) seen at
    variance_m2: Floats  # (L, R)
    seen: Bools  # (L, R)


@dataclass(frozen=True, slots=True)
class Expected:
    """Where the lines should be seen, on the same grid."""

    right_m: Floats  # (L, R)
    jacobian: Floats  # (L, R, 8) its derivative by the state
    reached: Bools  # (L, R) whether the line reaches the row


def initial_covariance(
    y_m: float, heading_rad: float, width_m: float, pitch_rad: float, config: RoadFilterConfig
) -> Floats:
    """(8, 8) of a state just found, with these standard deviations of place, heading, a lane's width and the pitch."""
    covariance = np.diag([y_m**2, heading_rad**2, *np.zeros(len(NODES_M)), width_m**2, pitch_rad**2])
    steps = np.minimum.outer(np.arange(len(NODES_M)), np.arange(len(NODES_M)))
    covariance[CURVATURES, CURVATURES] = config.shared_curvature_per_m**2 + config.added_curvature_per_m**2 * steps
    return covariance


@dataclass(slots=True)
class LaneFilter:
    """Extended Kalman filter of the road's state."""

    state: Floats  # (8,)
    covariance: Floats  # (8, 8)
    camera: Camera
    config: RoadFilterConfig

    def predict(self, step: Floats) -> None:
        """After the vehicle moved by `step` (forward m, right m, yaw rad) in its own axes."""
        self.state, derivative = moved(self.state, step)
        distance = float(np.hypot(step[0], step[1]))
        self.covariance = derivative @ self.covariance @ derivative.T + np.diag(self.config.drift**2) * distance

    def expected(self, numbers: Floats, forward_m: Floats) -> Expected:
        """Where lines should be seen on rows (R,) ahead."""
        return Expected(*seen_lines(self.state, numbers, forward_m, self.camera))

    def correct(self, sightings: Sightings, expected: Expected | None = None) -> None:
        """Iterated robust least squares with the prediction as prior: sightings far off the lines count for nothing.

        `expected` is where the lines of the sightings should be, where it is at hand.
        """
        prior, information = self.state, np.linalg.inv(self.covariance)
        expected = expected or self.expected(sightings.numbers, sightings.forward_m)
        seen = sightings.seen & self._possible(sightings, expected)
        right, jacobian, reached = expected.right_m, expected.jacobian, expected.reached
        state, normal = prior, information
        for cut_m in self.config.passes_m:
            if state is not prior:
                right, jacobian, reached = seen_lines(state, sightings.numbers, sightings.forward_m, self.camera)
            chosen = seen & reached
            residual = (sightings.right_m - right)[chosen]
            tukey = np.maximum(1.0 - (residual / cut_m) ** 2, 0.0) ** 2
            weight = tukey / sightings.variance_m2[chosen]
            rows = jacobian[chosen]
            weighted = rows * weight[:, None]
            normal = information + weighted.T @ rows
            gradient = weighted.T @ residual + information @ (prior - state)
            state = state + np.linalg.solve(normal, gradient)
        self.state, self.covariance = state, np.linalg.inv(normal)

    def _possible(self, sightings: Sightings, expected: Expected) -> Bools:
        """(L, R) sightings that the prediction allows: drops, puddles and mirror images are bright in other places."""
        jacobian = expected.jacobian
        variance = np.sum((jacobian @ self.covariance) * jacobian, axis=-1) + sightings.variance_m2
        aside = np.where(sightings.seen, sightings.right_m - expected.right_m, np.inf)
        possible, gate = _along(aside, self.config.neighbour_test), self.config.innovation_gate
        if gate is not None:
            possible &= np.abs(aside) < gate.sigmas * np.sqrt(variance) + self.config.on_line_m
        return possible

    def agrees(self, sightings: Sightings) -> bool:
        """Whether more of the sightings lie on the lines than of drops, streaks and grain would by chance.

        And whether there are two of the lines far off if there are near: a mirror image far off, before or beside one
        line, is followed away from the road otherwise.
        """
        right, _ = seen_places(self.state, sightings.numbers, sightings.forward_m, self.camera)
        aside = np.where(sightings.seen, sightings.right_m - right, np.inf)
        config = self.config
        on_line = _along(aside, config.neighbour_test) & (np.abs(aside) < config.on_line_m)
        if config.chance_test is not None:
            expected = self._chance * np.count_nonzero(sightings.seen)
            if np.count_nonzero(on_line) <= expected + config.chance_test.sigmas * np.sqrt(expected):
                return False
        if config.near_part is None:
            return True
        far, least = sightings.forward_m >= config.near_part.within_m, config.near_part.least_rows
        if not sightings.seen[:, far].any():
            return True
        return _lines(on_line[:, far], least) >= min(_lines(on_line[:, ~far], least), 2)

    @property
    def _chance(self) -> float:
        """Share of uniformly distributed observations that lie on a line and have a neighbour along it."""
        config = self.config
        along = (
            1.0 if config.neighbour_test is None else 1.0 - (1.0 - config.neighbour_test.apart_m / config.reach_m) ** 2
        )
        return config.on_line_m / config.reach_m * along

    @property
    def pitch_sigma_rad(self) -> float:
        """Standard deviation of the pitch against the road."""
        return float(np.sqrt(self.covariance[PITCH, PITCH]))

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the lateral position."""
        return float(np.sqrt(self.covariance[0, 0]))


def _along(aside_m: Floats, test: NeighbourTestConfig | None) -> Bools:
    """(L, R) observations with a neighbour at nearly the same offset from the line; all of them without a test."""
    if test is None:
        return np.isfinite(aside_m)
    with np.errstate(invalid="ignore"):
        along = np.abs(np.diff(aside_m, axis=1)) < test.apart_m
    line = np.zeros(aside_m.shape, np.bool_)
    line[:, 1:] = along
    line[:, :-1] |= along
    return line


def _lines(on_line: Bools, least: int) -> int:
    """How many of L lines are seen in as many of the rows (L, R) as make a line."""
    return int(np.count_nonzero(np.count_nonzero(on_line, axis=1) >= least))


def is_sane(state: Floats, config: RoadFilterConfig, widest_m: float, turned_rad: float | None = None) -> bool:
    """Whether the model can draw this road, with lanes up to `widest_m` and a heading up to `turned_rad`."""
    turned_rad = config.turned_rad if turned_rad is None else turned_rad
    if state.shape != (SIZE,):
        return False
    values = state.tolist()
    _, heading, *curvatures, width, pitch = values
    bent = all(abs(curvature) < config.tightest_per_m for curvature in curvatures)
    straight = abs(heading) < turned_rad and abs(pitch) < config.steepest_rad
    return all(map(isfinite, values)) and straight and bent and config.narrowest_m < width < widest_m
