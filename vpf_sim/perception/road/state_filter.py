"""The state of the road over time: predicted by the vehicle's own motion, corrected by the lines that are seen."""

from dataclasses import dataclass, field

import numpy as np

from vpf_sim.perception.road.model import CURVATURES, NODES_M, PITCH, VERGE, moved, seen_lines, seen_places
from vpf_sim.perception.road.road_settings import NeighbourTestConfig, RoadFilterConfig
from vpf_sim.types import Bools, Camera, Floats

UNKNOWN_M = 10.0  # standard deviation of the place of a verge that is not known


@dataclass(frozen=True, slots=True)
class Sightings:
    """Where the lines were seen, on a grid of L lines and R rows."""

    numbers: Floats  # (L,) of the lines
    forward_m: Floats  # (R,)
    right_m: Floats  # (L, R) seen at
    variance_m2: Floats  # (L, R)
    seen: Bools  # (L, R)

    @property
    def lines(self) -> "Sightings":
        """Without those of verges."""
        is_line = np.isfinite(self.numbers)
        rows = self.right_m[is_line], self.variance_m2[is_line], self.seen[is_line]
        return Sightings(self.numbers[is_line], self.forward_m, *rows)

    def joined(self, others: "Sightings") -> "Sightings":
        """With other lines in the same rows."""
        pairs = ((getattr(self, name), getattr(others, name)) for name in ("numbers", "right_m", "variance_m2", "seen"))
        numbers, right_m, variance_m2, seen = (np.concatenate(pair) for pair in pairs)
        return Sightings(numbers, self.forward_m, right_m, variance_m2, seen)


def initial_covariance(
    y_m: float, heading_rad: float, width_m: float, pitch_rad: float, config: RoadFilterConfig
) -> Floats:
    """(10, 10) of a state just found, with these standard deviations of place, heading, a lane's width and pitch."""
    unknown = [UNKNOWN_M**2, UNKNOWN_M**2]
    covariance = np.diag([y_m**2, heading_rad**2, *np.zeros(len(NODES_M)), width_m**2, pitch_rad**2, *unknown])
    steps = np.minimum.outer(np.arange(len(NODES_M)), np.arange(len(NODES_M)))
    covariance[CURVATURES, CURVATURES] = config.shared_curvature_per_m**2 + config.added_curvature_per_m**2 * steps
    return covariance


@dataclass(slots=True)
class LaneFilter:
    """Extended Kalman filter of the road's state."""

    state: Floats  # (10,)
    covariance: Floats  # (10, 10)
    camera: Camera
    config: RoadFilterConfig
    verges: dict[float, float] = field(default_factory=dict)  # 0 .. 1, visible shares of the known ones, by number

    def predict(self, step: Floats) -> None:
        """After the vehicle moved by `step` (forward m, right m, yaw rad) in its own axes."""
        self.state, derivative = moved(self.state, step)
        distance = float(np.hypot(step[0], step[1]))
        self.covariance = derivative @ self.covariance @ derivative.T + np.diag(self.config.drift**2) * distance

    def correct(self, found: Sightings) -> None:
        """Iterated robust least squares with the prediction as prior; outliers have no weight."""
        prior, information = self.state, np.linalg.inv(self.covariance)
        state, normal, possible = prior, information, found.seen
        for cut_m in self.config.passes_m:
            right, jacobian, reached = seen_lines(state, found.numbers, found.forward_m, self.camera)
            if state is prior:
                possible = found.seen & self._possible(found, right, jacobian)
            chosen = possible & reached
            residual = (found.right_m - right)[chosen]
            tukey = np.maximum(1.0 - (residual / cut_m) ** 2, 0.0) ** 2
            weight = tukey / found.variance_m2[chosen]
            rows = jacobian[chosen]
            weighted = rows * weight[:, None]
            normal = information + weighted.T @ rows
            gradient = weighted.T @ residual + information @ (prior - state)
            state = state + np.linalg.solve(normal, gradient)
        self.state, self.covariance = state, np.linalg.inv(normal)

    @property
    def verge_numbers(self) -> Floats:
        """Of the known verges."""
        return np.array(list(self.verges))

    def add_verge(self, number: float, place_m: float, sigma_m: float, share: float) -> None:
        """Take a verge `place_m` right of line 0 into the state. Where it was seen, the pose's place was uncertain."""
        index, self.verges[number] = VERGE[number], share
        self.state[index] = place_m
        self.covariance[index] = self.covariance[0]
        self.covariance[:, index] = self.covariance[:, 0]
        self.covariance[index, index] = self.covariance[0, 0] + sigma_m**2

    def drop_verge(self, number: float) -> None:
        """Forget a verge."""
        index = VERGE[number]
        del self.verges[number]
        self.covariance[index] = self.covariance[:, index] = 0.0
        self.covariance[index, index] = UNKNOWN_M**2

    def _possible(self, found: Sightings, right_m: Floats, jacobian: Floats) -> Bools:
        """(L, R) observations that the prediction allows: drops, puddles and mirror images lie elsewhere."""
        aside = np.where(found.seen, found.right_m - right_m, np.inf)
        variance = np.sum((jacobian @ self.covariance) * jacobian, axis=-1) + found.variance_m2
        possible = _along(aside, self.config.neighbour_test)
        possible &= np.abs(aside) < self.config.innovation_sigmas * np.sqrt(variance) + self.config.on_line_m
        return possible

    def agrees(self, found: Sightings) -> bool:
        """Whether more observations lie on the lines than by chance, and on two lines far ahead if on two nearby.

        A mirror image far ahead, beside a single line, would lead the road astray.
        """
        if not found.seen.any():
            return False
        right, _ = seen_places(self.state, found.numbers, found.forward_m, self.camera)
        aside = np.where(found.seen, found.right_m - right, np.inf)
        config = self.config
        on_line = _along(aside, config.neighbour_test) & (np.abs(aside) < config.on_line_m)
        expected = self._chance * np.count_nonzero(found.seen)
        if np.count_nonzero(on_line) <= expected + config.chance_test.sigmas * np.sqrt(expected):
            return False
        far, least = found.forward_m >= config.near_part.within_m, config.near_part.least_rows
        if not found.seen[:, far].any():
            return True
        far_lines, near_lines = (
            int(np.count_nonzero(np.count_nonzero(on_line[:, part], axis=1) >= least)) for part in (far, ~far)
        )
        return bool(far_lines >= min(near_lines, 2))

    @property
    def _chance(self) -> float:
        """Share of uniformly distributed observations that lie on a line and have a neighbour along it."""
        config = self.config
        along = 1.0 - (1.0 - config.neighbour_test.apart_m / config.reach_m) ** 2
        return config.on_line_m / config.reach_m * along

    @property
    def pitch_sigma_rad(self) -> float:
        """Standard deviation of the pitch against the road."""
        return float(np.sqrt(self.covariance[PITCH, PITCH]))

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the lateral position."""
        return float(np.sqrt(self.covariance[0, 0]))


def _along(aside_m: Floats, test: NeighbourTestConfig) -> Bools:
    """(L, R) observations with a neighbour at nearly the same offset from the line."""
    with np.errstate(invalid="ignore"):
        along = np.abs(np.diff(aside_m, axis=1)) < test.apart_m
    line = np.zeros(aside_m.shape, np.bool_)
    line[:, 1:] = along
    line[:, :-1] |= along
    return line
