"""The focus of expansion (FOE): the image of the direction in which the camera moves (paper, section III-A)."""

from dataclasses import dataclass
from math import sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import rotation_flow
from vpf_sim.types import Bools, Camera, Expansion, Floats, Flow

Reals = NDArray[np.floating[Any]]

HYPOTHESES = 96
FINALISTS = 16  # of them, that all voters judge
SAMPLE = 128  # points that vote in RANSAC
ITERATIONS = 6  # of the reweighting, at most
SETTLED_PX = 0.05  # a step of the reweighting after which another is not worth while
LEAST = 8  # moving points without which there is no FOE


@dataclass(frozen=True, slots=True)
class ExpansionConfig:
    method: Literal["as_printed", "least_squares", "robust"] = "robust"
    tolerance_px: float = 0.25  # error across the radial direction that one step between frames may have, plus
    tolerance_ratio: float = 0.03  # this share of its length; over n chained steps it grows with sqrt(n)
    min_flow_px: float = 1.7  # shorter motions do not vote: the far road creeps towards the pixel grid
    rotation_sd_radps: tuple[float, float, float] = (0.03, 0.001, 0.03)  # usual unmeasured pitch, yaw and roll rate

    def __post_init__(self) -> None:
        if self.method not in ("as_printed", "least_squares", "robust"):
            raise ValueError(f"method: expected as_printed, least_squares or robust, got '{self.method}'")
        if min(self.tolerance_px, self.tolerance_ratio, self.min_flow_px) <= 0.0:
            raise ValueError("tolerance_px, tolerance_ratio, min_flow_px: expected > 0")


def lines(points_px: Floats, flow_px: Floats) -> tuple[Floats, Floats]:
    """A (N, 2) and b (N,) of the lines through the points along their flow: a = (v_y, -v_x), b = x v_y - y v_x."""
    a = np.stack([flow_px[:, 1], -flow_px[:, 0]], axis=1)
    b: Floats = np.sum(a * points_px, axis=1)
    return a, b


def least_squares(points_px: Floats, flow_px: Floats) -> Floats:
    """(2,) px, FOE = (A^T A)^-1 A^T b, the paper's definition; rows weigh by |v|, which is right (METHOD A3)."""
    a, b = lines(points_px, flow_px)
    return np.asarray(np.linalg.lstsq(a, b, rcond=None)[0], np.float64)


def as_printed(points_px: Floats, flow_px: Floats) -> Floats:
    """(2,) px, the paper's closed form as printed: wrong sign, wrong first product of the denominator (METHOD A2).

    FOE = -1 / (sum a0^2 a1^2 - (sum a0 a1)^2) * (sum b a0 sum a1^2 - sum b a1 sum a0 a1, -sum b a0 sum a0 a1 + sum b a1
    sum a0^2). It points nowhere near the FOE and is kept as a documented misprint.
    """
    a, b = lines(points_px, flow_px)
    a0, a1 = a.T
    denominator = np.sum(a0**2 * a1**2) - np.sum(a0 * a1) ** 2
    numerator = np.array(
        [
            np.sum(a0 * b) * np.sum(a1**2) - np.sum(a1 * b) * np.sum(a0 * a1),
            np.sum(a1 * b) * np.sum(a0**2) - np.sum(a0 * b) * np.sum(a0 * a1),
        ]
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        solution: Floats = -numerator / denominator
    return solution


def derotate(flow: Flow, camera: Camera) -> Floats:
    """(N, 2) px, the displacement that the camera's translation alone gives, in the axes of the camera now.

    The past point is turned by the known yaw change over its window, so the line through it and the point now passes
    through the image of the chord that the camera's centre moved along.
    """
    yaw_change = flow.pose[2] - flow.past_pose[:, 2]
    past = flow.points_px - flow.displacement_px
    turned: Floats = past - rotation_flow(camera, past, -yaw_change)
    return flow.points_px - turned


def chord_shift(flow: Flow, camera: Camera) -> Floats:
    """(N,) px by which the FOE now lies right of each point's chord: half the turn over its window (METHOD A3)."""
    yaw_change = np.remainder(flow.pose[2] - flow.past_pose[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    shift: Floats = camera.fx_px * np.tan(0.5 * yaw_change)
    return shift


def _across(points_px: Reals, flow_px: Reals, foe_px: Reals) -> Reals:
    """(H, N) px, flow across the direction away from each of the FOEs (H, 2); inf where it points inward."""
    x, y = points_px[:, 0] - foe_px[:, :1], points_px[:, 1] - foe_px[:, 1:]
    u, v = np.ascontiguousarray(flow_px.T)
    across: Reals = np.abs(u * y - v * x) / (np.sqrt(x * x + y * y) + 1e-9)
    across[u * x + v * y <= 0.0] = np.inf
    return across


def _ransac(points_px: Floats, flow_px: Floats, tolerance_px: Floats, rng: np.random.Generator) -> Floats | None:
    """(2,) px, the intersection of two flow lines that most points agree with; all hypotheses at once."""
    if len(points_px) > SAMPLE:
        chosen = rng.choice(len(points_px), SAMPLE, replace=False)
        points_px, flow_px, tolerance_px = points_px[chosen], flow_px[chosen], tolerance_px[chosen]
    a, b = lines(points_px, flow_px)
    first, second = rng.integers(0, len(a), (2, HYPOTHESES))
    determinant = a[first, 0] * a[second, 1] - a[first, 1] * a[second, 0]
    length = np.hypot(a[:, 0], a[:, 1])
    parallel = np.abs(determinant) < 0.05 * length[first] * length[second] + 1e-12
    determinant = np.where(parallel, 1.0, determinant)
    x = (b[first] * a[second, 1] - b[second] * a[first, 1]) / determinant
    y = (a[first, 0] * b[second] - a[second, 0] * b[first]) / determinant
    foes = np.stack([x, y], axis=1)[~parallel]
    if not len(foes):
        return None
    # Exact enough to count votes; a quarter of the points tells which hypotheses all of them should judge.
    p, v, tolerance = (values.astype(np.float32) for values in (points_px, flow_px, tolerance_px))
    for part, left in ((slice(None, None, 4), FINALISTS), (slice(None), 1)):
        votes = np.maximum(1.0 - _across(p[part], v[part], foes.astype(np.float32)) / tolerance[part], 0.0).sum(axis=1)
        foes = foes[np.argsort(-votes, kind="stable")[:left]]
    best: Floats = foes[0]
    return best


def _tilt_flow(camera: Camera, points_px: Floats, gap_s: Floats) -> Floats:
    """(N, 2, 3) px per rad/s: motion of the image under a slow turn about the camera's x, y and z axes in each window.

    To first order and up to sign (Longuet-Higgins and Prazdny 1980); the turns it measures are small and unknown.
    """
    x = (points_px[:, 0] - camera.cx_px) / camera.fx_px
    y = (points_px[:, 1] - camera.cy_px) / camera.fy_px
    motion = np.empty((len(x), 2, 3))
    motion[:, 0, 0], motion[:, 0, 1], motion[:, 0, 2] = x * y, 1.0 + x * x, -y
    motion[:, 1, 0], motion[:, 1, 1], motion[:, 1, 2] = 1.0 + y * y, x * y, x
    motion *= np.array([[camera.fx_px], [camera.fy_px]])
    motion *= gap_s[:, None, None]
    return motion


@dataclass(frozen=True, slots=True)
class Fit:
    foe_px: Floats  # (2,)
    covariance_px2: Floats  # (2, 2)
    inliers: Bools  # (N,)


def robust(
    points_px: Floats,
    flow_px: Floats,
    gap_s: Floats,
    steps: Floats,
    camera: Camera,
    config: ExpansionConfig,
    rng: np.random.Generator,
) -> Fit | None:
    """The FOE of a derotated flow by RANSAC and then reweighted least squares; None where the flow fixes none.

    A row of A x = b has the noise of the flow times the distance from the FOE, so rows weigh by its inverse, and by
    Tukey's biweight of the flow across the radial direction. Pitch, roll and what the yaw rate's sensor misses turn
    the picture too; these rates are fitted along, held near zero by their usual size. `steps` (N,) is the number of
    frames that each displacement was chained over.
    """
    length = np.hypot(flow_px[:, 0], flow_px[:, 1])
    tolerance = np.sqrt(steps) * (config.tolerance_px + config.tolerance_ratio * length / steps)
    usable = length > config.min_flow_px
    p, v, limit = points_px[usable], flow_px[usable], tolerance[usable]
    if len(p) < LEAST:
        return None
    start = _ransac(p, v, limit, rng)
    if start is None:
        return None
    turn = _tilt_flow(camera, p, gap_s[usable])
    fitted = _reweighted(p, v, limit, turn, start, config)
    if fitted is None:
        return None
    state, covariance = fitted
    inliers = np.zeros(len(usable), np.bool_)
    inliers[usable] = _across(p, v - turn @ state[2:], state[None, :2])[0] < limit
    return Fit(state[:2], covariance, inliers)


def _reweighted(
    points_px: Floats, flow_px: Floats, limit_px: Floats, turn: Floats, start_px: Floats, config: ExpansionConfig
) -> tuple[Floats, Floats] | None:
    """(5,) FOE px and pitch, yaw and roll rates rad/s, and the FOE's (2, 2) covariance px^2; None if it has none."""
    prior = np.array([0.0, 0.0, *(1.0 / max(sd, 1e-9) ** 2 for sd in config.rotation_sd_radps)])
    state = np.array([*start_px, 0.0, 0.0, 0.0])
    for _ in range(ITERATIONS):
        weight, slope, across = _linearise(points_px, flow_px - turn @ state[2:], turn, state[:2], limit_px)
        weighted = (slope * weight[:, None]).T
        normal = weighted @ slope
        determinant = normal[0, 0] * normal[1, 1] - normal[0, 1] ** 2
        if np.count_nonzero(weight) < LEAST or determinant < 1e-12:
            return None
        normal.flat[::6] += prior
        step = np.linalg.solve(normal, weighted @ across + prior * state)
        state = state - step
        if abs(step[0]) + abs(step[1]) < SETTLED_PX:
            break
    return state, np.asarray(np.linalg.inv(normal)[:2, :2], np.float64)


def _linearise(
    points_px: Floats, flow_px: Floats, turn: Floats, foe_px: Floats, limit_px: Floats
) -> tuple[Floats, Floats, Floats]:
    """Weights (N,), slopes (N, 5) and values (N,) px of the flow across the radial direction, at a FOE and rates."""
    x, y = points_px[:, 0] - foe_px[0], points_px[:, 1] - foe_px[1]
    u, v = flow_px[:, 0], flow_px[:, 1]
    nearness = 1.0 / (np.sqrt(x * x + y * y) + 5.0)
    x, y = x * nearness, y * nearness
    across = u * y - v * x
    # The tolerance is some three standard deviations of the flow.
    size = across / limit_px
    size *= size
    weight = np.maximum(1.0 - 0.25 * size, 0.0) * (3.0 / limit_px)
    weight *= weight
    weight[u * x + v * y <= 0.0] = 0.0
    slope = np.empty((len(across), 5))
    slope[:, 0], slope[:, 1] = v * nearness, -u * nearness
    slope[:, 2:] = turn[:, 1] * x[:, None] - turn[:, 0] * y[:, None]
    return weight, slope, across


def estimate(flow: Flow, camera: Camera, config: ExpansionConfig, rng: np.random.Generator) -> Expansion:
    """The FOE of one frame. Without enough motion it is the principal point, with confidence 0."""
    moving = np.hypot(flow.displacement_px[:, 0], flow.displacement_px[:, 1]) > 1e-9
    if np.count_nonzero(moving) < 2:
        return _unknown(camera, len(flow))
    if config.method != "robust":
        solve = least_squares if config.method == "least_squares" else as_printed
        x, y = solve(flow.points_px[moving], flow.displacement_px[moving])
        if not (np.isfinite(x) and np.isfinite(y)):
            return _unknown(camera, len(flow))
        return Expansion(float(x), float(y), np.full((2, 2), np.nan), moving, 1.0)
    derotated = derotate(flow, camera)
    shift = chord_shift(flow, camera)
    # Moving a line by the shift moves its intersection with the others from the chord's image to the present FOE.
    points = flow.points_px.copy()
    points[:, 0] += shift
    fit = robust(points, derotated, flow.gap_s, _steps(flow), camera, config, rng)
    if fit is None:
        return _unknown(camera, len(flow))
    voters = int(np.count_nonzero(np.hypot(derotated[:, 0], derotated[:, 1]) > config.min_flow_px))
    share = float(np.count_nonzero(fit.inliers)) / max(1, voters)
    sharp = 1.0 / (1.0 + sqrt(fit.covariance_px2[0, 0] + fit.covariance_px2[1, 1]) / 5.0)
    x, y = (float(value) for value in fit.foe_px)
    return Expansion(x, y, fit.covariance_px2, fit.inliers, min(1.0, share * sharp))


def _steps(flow: Flow) -> Floats:
    """(N,) frames that each window was chained over: the youngest points are no older than their windows."""
    young = flow.gap_s > 0.0
    rate_hz = np.min(flow.age_frames[young] / flow.gap_s[young], initial=np.inf)
    steps: Floats = np.maximum(flow.gap_s * rate_hz, 1.0)
    return steps


def _unknown(camera: Camera, count: int) -> Expansion:
    horizon = camera.cy_px - camera.fy_px * float(np.tan(camera.pitch_rad))
    return Expansion(camera.cx_px, horizon, np.full((2, 2), np.inf), np.zeros(count, np.bool_), 0.0)
