"""The shape of the road ahead: parallel lines, a lane's width apart, whose curvature is piecewise linear.

The state is (y, h, k_0 .. k_3, w, p, v_l, v_r): m, the pose's place right of line 0; rad, the road's direction minus
yaw at the foot of the pose; 1/m, the curvature of line 0 at NODES_M metres along it (+ bends right); m, the lane width;
rad, the camera's pitch against the road beyond its calibration (+ down); m, the verges' places right of line 0. Line i
is i lanes right of line 0, and the verges run along with the lines, at distances of their own.

With a pitch each row shows the road nearer or farther than assumed, and larger or smaller: parallel lines seem to meet.
A frame with lines a few metres apart determines p to a hundredth of a degree.
"""

import numpy as np

from vpf_sim.types import Bools, Camera, Floats, Integers

NODES_M = np.array([0.0, 8.0, 16.0, 24.0])
CURVATURES = slice(2, 2 + len(NODES_M))
WIDTH = 2 + len(NODES_M)
PITCH = WIDTH + 1
VERGE = {-np.inf: PITCH + 1, np.inf: PITCH + 2}  # index in the state of the left and the right verge, by number
STATES = PITCH + 3
LEAST_DIP_RAD = 0.02  # of a row below the horizon; what is higher shows no line
ALONG_M = np.arange(-6.0, 48.1, 0.5)  # (G,) stations along line 0


def _integrated(values: Floats) -> Floats:
    """The integral along ALONG_M, the last axis, 0 at the origin (trapezia)."""
    total = np.empty_like(values)
    total[..., 0] = 0.0
    step_m = ALONG_M[1] - ALONG_M[0]
    (0.5 * step_m * (values[..., 1:] + values[..., :-1])).cumsum(axis=-1, out=total[..., 1:])
    total -= total[..., ALONG_M == 0.0]
    return total


def _hats(places_m: Floats) -> Floats:
    """(4, N) curvature at places along line 0 for a curvature of 1 at one node."""
    return np.array([np.interp(places_m, NODES_M, row) for row in np.eye(len(NODES_M))])


TURNS = np.ascontiguousarray(_integrated(_hats(ALONG_M)).T)  # (G, 4) heading
BENDS = np.ascontiguousarray(_integrated(TURNS.T).T)  # (G, 4) lateral place of a straight road


def state_of(place_m: float, heading_rad: float, curvature_per_m: float, lane_width_m: float) -> Floats:
    """(10,) the state of a road of one curvature, with a camera without pitch and unknown verges."""
    return np.array([place_m, heading_rad, *np.full(len(NODES_M), curvature_per_m), lane_width_m, 0.0, 0.0, 0.0])


def _offset_rates(numbers: Floats) -> Floats:
    """(L, 10) the derivative by the state of the lines' places right of line 0, which are this times the state."""
    rates = np.zeros((len(numbers), STATES))
    is_line = np.isfinite(numbers)
    rates[is_line, WIDTH] = numbers[is_line]
    for number, index in VERGE.items():
        rates[numbers == number, index] = 1.0
    return rates


def _crossings(state: Floats, numbers: Floats, forward_m: Floats) -> tuple[Floats, Bools, Integers, Floats]:
    """Where L lines cross R rows: (L, R) m right of the pose, and whether they reach the row.

    Then the last station before each crossing (L, R), and line 0's direction at all stations (G,).
    """
    y, heading = state[0], state[1]
    offsets_m = (_offset_rates(numbers)[:, WIDTH:] @ state[WIDTH:])[:, None]
    direction = heading + TURNS @ state[CURVATURES]
    cosine, sine = course = np.array([np.cos(direction), np.sin(direction)])
    centre_x, centre_y = _integrated(course)
    centre_x += y * np.sin(heading)
    centre_y -= y * np.cos(heading)
    # A tight bend leads back: the first crossing counts.
    ahead = np.maximum.accumulate(centre_x - offsets_m * sine, axis=1)
    stations = np.arange(len(ALONG_M), dtype=float)
    index = np.array([np.interp(forward_m, along, stations, left=-1.0, right=-1.0) for along in ahead])
    lower = np.minimum(np.maximum(index.astype(np.intp), 0), len(ALONG_M) - 2)
    share = np.minimum(np.maximum(index - lower, 0.0), 1.0)
    before, after = (centre_y.take(at) + offsets_m * cosine.take(at) for at in (lower, lower + 1))
    return before + share * (after - before), index >= 0.0, lower, direction


def seen_lines(state: Floats, numbers: Floats, forward_m: Floats, camera: Camera) -> tuple[Floats, Floats, Bools]:
    """Where the camera sees lines of the road cross rows ahead.

    Of L lines, by their numbers, at R rows `forward_m` ahead of the pose for a camera without pitch: right of the
    vehicle (L, R) m, its derivative by the state (L, R, 10), and (L, R) whether the line reaches the row. A number may
    be a fraction: the middle of the lane right of line i is i + 1/2. The verges have the numbers of `VERGE`. What a row
    shows seems larger by sin(a + p) / sin(a) than it is, with a as in `rows_seen`.
    """
    ahead, dip = rows_seen(float(state[PITCH]), forward_m, camera)
    right, reached, lower, direction = _crossings(state, numbers, ahead)
    secant = 1.0 / np.cos(direction).take(lower)
    slope = np.sin(direction).take(lower) * secant
    sine, apparent = np.sin(dip), np.sin(dip - state[PITCH])
    scale = sine / apparent
    jacobian = np.empty((*right.shape, STATES))
    jacobian[..., 0] = -np.cos(direction - state[1]).take(lower) * secant
    jacobian[..., 1] = ahead + right * slope
    jacobian[..., CURVATURES] = BENDS.take(lower, axis=0) * secant[..., None]
    jacobian[..., WIDTH:] = _offset_rates(numbers)[:, None, WIDTH:] * secant[..., None]
    jacobian *= scale[:, None]
    jacobian[..., PITCH] = right * np.cos(dip) / apparent - slope * scale * camera.height_m / sine**2
    return right * scale, jacobian, reached & (dip > LEAST_DIP_RAD)


def seen_places(state: Floats, numbers: Floats, forward_m: Floats, camera: Camera) -> tuple[Floats, Bools]:
    """`seen_lines` without the derivative."""
    ahead, dip = rows_seen(float(state[PITCH]), forward_m, camera)
    right, reached, _, _ = _crossings(state, numbers, ahead)
    return right * (np.sin(dip) / np.sin(dip - state[PITCH])), reached & (dip > LEAST_DIP_RAD)


def rows_seen(pitch_rad: float, forward_m: Floats, camera: Camera) -> tuple[Floats, Floats]:
    """(R,) m from the pose, the road that rows assumed at `forward_m` show, and (R,) rad their dip below the horizon.

    A row with a dip of a without pitch has a + p with it, and shows the road h / tan(a + p) before the lens.
    """
    dip = np.maximum(np.arctan2(camera.height_m, forward_m - camera.forward_m) + pitch_rad, LEAST_DIP_RAD)
    return camera.forward_m + camera.height_m / np.tan(dip), dip


def moved(state: Floats, step: Floats) -> tuple[Floats, Floats]:
    """The state after the vehicle moved by `step` (forward m, right m, yaw rad) in its own axes, and its derivative."""
    y, heading, curvature = state[0], state[1], state[2]
    cosine, sine = np.cos(heading), np.sin(heading)
    along = (step[0] * cosine + step[1] * sine) / (1.0 - curvature * y)
    across = step[1] * cosine - step[0] * sine
    shift = _hats(NODES_M + along).T
    derivative = np.eye(STATES)
    derivative[0, 1] = -along
    derivative[0, 2] = -0.5 * along**2
    derivative[1, 2] = along
    derivative[CURVATURES, CURVATURES] = shift
    after = state.copy()
    after[0] = y + across - 0.5 * curvature * along**2
    after[1] = heading + curvature * along - step[2]
    after[CURVATURES] = shift @ state[CURVATURES]
    return after, derivative


def curvature_ahead(state: Floats, distance_m: float) -> float:
    """1/m, the constant curvature that bends line 0 as far by `distance_m` ahead as its own does."""
    bend = float(np.interp(distance_m, ALONG_M, BENDS @ state[CURVATURES]))
    return 2.0 * bend / distance_m**2
