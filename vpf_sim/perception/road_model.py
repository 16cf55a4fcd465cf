"""The shape of the road ahead: parallel lines along a centre line whose curvature is piecewise linear.

The state is (y, h, k_0 .. k_3): m, the pose's place right of the centre line; rad, the road's direction minus yaw at
the foot of the pose; 1/m, the centre line's curvature at NODES_M metres along it (+ bends right).
"""

import numpy as np

from vpf_sim.types import Bools, Floats

NODES_M = np.array([0.0, 8.0, 16.0, 24.0])
SIZE = 2 + len(NODES_M)
STEP_M = 0.5
ALONG_M = np.arange(-6.0, 48.0 + 1e-9, STEP_M)  # (G,) stations along the centre line
ORIGIN = int(np.searchsorted(ALONG_M, 0.0))


def _integrated(values: Floats) -> Floats:
    """The integral along ALONG_M, axis 0, 0 at the origin (trapezia)."""
    total = np.zeros_like(values)
    np.cumsum(0.5 * STEP_M * (values[1:] + values[:-1]), axis=0, out=total[1:])
    total -= total[ORIGIN].copy()
    return total


HATS = np.stack([np.interp(ALONG_M, NODES_M, row) for row in np.eye(len(NODES_M))], axis=1)  # (G, 4) curvature
TURNS = _integrated(HATS)  # (G, 4) heading
BENDS = _integrated(TURNS)  # (G, 4) lateral place of a straight road


def lines(state: Floats, offsets_m: Floats, forward_m: Floats) -> tuple[Floats, Floats, Bools]:
    """Where lines parallel to the centre line cross rows ahead.

    Of L lines `offsets_m` right of the centre line, at R rows `forward_m` ahead of the pose: right of the vehicle
    (L, R) m, its derivative by the state (L, R, 6), and (L, R) whether the line reaches the row.
    """
    y, heading = state[0], state[1]
    direction = heading + TURNS @ state[2:]
    cosine, sine = np.cos(direction), np.sin(direction)
    centre_x = _integrated(cosine) + y * np.sin(heading)
    centre_y = _integrated(sine) - y * np.cos(heading)
    index = np.empty((len(offsets_m), len(forward_m)))
    station = np.arange(len(ALONG_M), dtype=float)
    for row, offset in enumerate(offsets_m):
        index[row] = np.interp(forward_m, centre_x - offset * sine, station, left=-1.0, right=-1.0)
    reached = index >= 0.0
    lower = np.clip(index.astype(np.intp), 0, len(ALONG_M) - 2)
    share = np.clip(index - lower, 0.0, 1.0)
    offsets = offsets_m[:, None]
    before = centre_y[lower] + offsets * cosine[lower]
    after = centre_y[lower + 1] + offsets * cosine[lower + 1]
    right = before + share * (after - before)
    jacobian = np.empty((*right.shape, SIZE))
    secant = 1.0 / cosine[lower]
    jacobian[..., 0] = -np.cos(direction[lower] - heading) * secant
    jacobian[..., 1] = forward_m + right * sine[lower] * secant
    jacobian[..., 2:] = BENDS[lower] * secant[..., None]
    return right, jacobian, reached


def moved(state: Floats, step: Floats) -> tuple[Floats, Floats]:
    """The state after the vehicle moved by `step` (forward m, right m, yaw rad) in its own axes, and its derivative."""
    y, heading, curvature = state[0], state[1], state[2]
    cosine, sine = np.cos(heading), np.sin(heading)
    along = (step[0] * cosine + step[1] * sine) / (1.0 - curvature * y)
    across = step[1] * cosine - step[0] * sine
    shift = np.stack([np.interp(NODES_M + along, NODES_M, row) for row in np.eye(len(NODES_M))], axis=1)
    derivative = np.eye(SIZE)
    derivative[0, 1] = -along
    derivative[0, 2] = -0.5 * along**2
    derivative[1, 2] = along
    derivative[2:, 2:] = shift
    after = np.empty(SIZE)
    after[0] = y + across - 0.5 * curvature * along**2
    after[1] = heading + curvature * along - step[2]
    after[2:] = shift @ state[2:]
    return after, derivative


def curvature_ahead(state: Floats, distance_m: float) -> float:
    """1/m, the constant curvature that bends the centre line as far by `distance_m` ahead as its own does."""
    bend = float(np.interp(distance_m, ALONG_M, BENDS @ state[2:]))
    return 2.0 * bend / distance_m**2
