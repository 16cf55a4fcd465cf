"""The state of the road over time: predicted by the vehicle's own motion, corrected by the lines that are seen."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from vpf_sim.perception.road.model import CURVATURES, NODES_M, PITCH, SIZE, moved, seen_lines, seen_places
from vpf_sim.types import Bools, Camera, Floats

# Standard deviations that a metre of road adds: pose (m), heading (rad), curvature (1/m) at each node, a lane's width
# (m), the camera's pitch against the road (rad). The far node sees new road; the others are told of it as the vehicle
# moves on.
DRIFT = np.array([0.002, 0.0003, 0.0001, 0.0002, 0.0004, 0.002, 0.0005, 0.0001])
DRIFTS = np.diag(DRIFT**2)
# Curvature before anything is seen: what all nodes share, and what each adds to the one before it.
SHARED_CURVATURE, ADDED_CURVATURE = 0.007, 0.0007
TIGHTEST = 0.06  # 1/m, curvature of any of its lines
NARROWEST_M, WIDEST_M = 2.5, 4.5  # lanes, usually
TURNED_RAD = 1.0  # heading: from so far aside no line is followed
STEEPEST_RAD = 0.02  # pitch: beyond it the camera is mounted otherwise, or these are no parallel lines
PASSES = (0.6, 0.4, 0.25)  # m, Tukey's cut-off in each pass
# Sightings further from the prediction than so many standard deviations, plus so much, are of something else.
GATE, GATE_M = 4.0, 0.15
NEIGHBOUR_M = 0.12  # and so are those that are further aside than the sightings in both rows beside them
REACH_M = 0.5  # about the prediction, to which lines are sought
# Of sightings of nothing, as likely anywhere within reach, the share that comes to lie on a line and along it.
CHANCE = GATE_M / REACH_M * (1.0 - (1.0 - NEIGHBOUR_M / REACH_M) ** 2)
BEYOND_CHANCE = 3.0  # standard deviations by which more of them must, for a look to have seen the lines
NEAR_M = 14.0  # from here on a look is far off,
FEWEST = 3  # sightings that make a line there


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


def initial_covariance(y_m: float, heading_rad: float, width_m: float, pitch_rad: float) -> Floats:
    """(8, 8) of a state just found, with these standard deviations of place, heading, a lane's width and the pitch."""
    covariance = np.diag([y_m**2, heading_rad**2, *np.zeros(len(NODES_M)), width_m**2, pitch_rad**2])
    steps = np.minimum.outer(np.arange(len(NODES_M)), np.arange(len(NODES_M)))
    covariance[CURVATURES, CURVATURES] = SHARED_CURVATURE**2 + ADDED_CURVATURE**2 * steps
    return covariance


@dataclass(slots=True)
class LaneFilter:
    """Extended Kalman filter of the road's state."""

    state: Floats  # (8,)
    covariance: Floats  # (8, 8)
    camera: Camera

    def predict(self, step: Floats) -> None:
        """After the vehicle moved by `step` (forward m, right m, yaw rad) in its own axes."""
        self.state, derivative = moved(self.state, step)
        distance = float(np.hypot(step[0], step[1]))
        self.covariance = derivative @ self.covariance @ derivative.T + DRIFTS * distance

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
        for cut_m in PASSES:
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
        possible: Bools = _along(aside) & (np.abs(aside) < GATE * np.sqrt(variance) + GATE_M)
        return possible

    def agrees(self, sightings: Sightings) -> bool:
        """Whether more of the sightings lie on the lines than of drops, streaks and grain would by chance.

        And whether there are two of the lines far off if there are near: a mirror image far off, before or beside one
        line, is followed away from the road otherwise.
        """
        right, _ = seen_places(self.state, sightings.numbers, sightings.forward_m, self.camera)
        aside = np.where(sightings.seen, sightings.right_m - right, np.inf)
        on_line = _along(aside) & (np.abs(aside) < GATE_M)
        expected = CHANCE * np.count_nonzero(sightings.seen)
        if np.count_nonzero(on_line) <= expected + BEYOND_CHANCE * np.sqrt(expected):
            return False
        far = sightings.forward_m >= NEAR_M
        if not sightings.seen[:, far].any():
            return True
        return _lines(on_line[:, far]) >= min(_lines(on_line[:, ~far]), 2)

    def turn(self, down_rad: float) -> None:
        """The camera has come to look so much farther down."""
        self.state[PITCH] += down_rad

    @property
    def pitch_sigma_rad(self) -> float:
        """Standard deviation of the pitch against the road."""
        return float(np.sqrt(self.covariance[PITCH, PITCH]))

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the lateral position."""
        return float(np.sqrt(self.covariance[0, 0]))


def _along(aside_m: Floats) -> Bools:
    """(L, R) sightings so far aside of their lines as one in a row beside them."""
    with np.errstate(invalid="ignore"):
        along = np.abs(np.diff(aside_m, axis=1)) < NEIGHBOUR_M
    line = np.zeros(aside_m.shape, np.bool_)
    line[:, 1:] = along
    line[:, :-1] |= along
    return line


def _lines(on_line: Bools) -> int:
    """How many of L lines are seen in as many of the rows (L, R) as make a line."""
    return int(np.count_nonzero(np.count_nonzero(on_line, axis=1) >= FEWEST))


def is_sane(state: Floats, turned_rad: float = TURNED_RAD, widest_m: float = WIDEST_M) -> bool:
    """Whether the model can still draw this road, to which the vehicle is turned by less than so much, and whose lanes
    are no wider."""
    if state.shape != (SIZE,):
        return False
    values = state.tolist()
    _, heading, *curvatures, width, pitch = values
    bent = all(abs(curvature) < TIGHTEST for curvature in curvatures)
    straight = abs(heading) < turned_rad and abs(pitch) < STEEPEST_RAD
    return all(map(isfinite, values)) and straight and bent and NARROWEST_M < width < widest_m
