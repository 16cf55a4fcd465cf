"""The focus of expansion (FOE): the image of the direction in which the camera moves (paper, section III-A)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vpf_sim.geometry import rotation_flow
from vpf_sim.types import Bools, Camera, Expansion, Floats, Flow

HYPOTHESES = 64
SAMPLE = 160  # points that vote in RANSAC


@dataclass(frozen=True, slots=True)
class ExpansionConfig:
    method: Literal["as_printed", "least_squares", "robust"] = "robust"
    tolerance_px: float = 0.25  # flow across the radial direction that an inlier may have, plus
    tolerance_ratio: float = 0.04  # this share of its length
    min_flow_px: float = 0.3  # shorter motions do not vote

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
    solution = np.asarray(np.linalg.lstsq(a, b, rcond=None)[0], np.float64)
    return solution


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


def _across(points_px: Floats, flow_px: Floats, foe_px: Floats) -> Floats:
    """(H, N) px, flow across the direction away from each of the FOEs (H, 2); inf where it points inward."""
    away = points_px[None] - foe_px[:, None]
    cross = flow_px[:, 0] * away[..., 1] - flow_px[:, 1] * away[..., 0]
    along = flow_px[:, 0] * away[..., 0] + flow_px[:, 1] * away[..., 1]
    distance = np.sqrt(away[..., 0] ** 2 + away[..., 1] ** 2) + 1e-9
    across: Floats = np.where(along > 0.0, np.abs(cross) / distance, np.inf)
    return across


def _ransac(points_px: Floats, flow_px: Floats, tolerance_px: Floats, rng: np.random.Generator) -> Floats | None:
    """(2,) px, the intersection of two flow lines that most points agree with; all hypotheses at once."""
    if len(points_px) > SAMPLE:
        chosen = rng.choice(len(points_px), SAMPLE, replace=False)
        points_px, flow_px, tolerance_px = points_px[chosen], flow_px[chosen], tolerance_px[chosen]
    a, b = lines(points_px, flow_px)
    first, second = rng.integers(0, len(a), (2, HYPOTHESES))
    determinant = a[first, 0] * a[second, 1] - a[first, 1] * a[second, 0]
    parallel = np.abs(determinant) < 0.05 * np.hypot(*a[first].T) * np.hypot(*a[second].T) + 1e-12
    determinant = np.where(parallel, 1.0, determinant)
    x = (b[first] * a[second, 1] - b[second] * a[first, 1]) / determinant
    y = (a[first, 0] * b[second] - a[second, 0] * b[first]) / determinant
    foes = np.stack([x, y], axis=1)[~parallel]
    if not len(foes):
        return None
    votes = np.sum(np.clip(1.0 - _across(points_px, flow_px, foes) / tolerance_px, 0.0, 1.0), axis=1)
    best: Floats = foes[np.argmax(votes)]
    return best


def robust(
    points_px: Floats, flow_px: Floats, config: ExpansionConfig, rng: np.random.Generator
) -> tuple[Floats, Floats, Bools]:
    """FOE (2,) px, its covariance (2, 2) px^2, inliers (N,) of a derotated flow: RANSAC, then reweighted least squares.

    The noise of a row of A x = b is that of the flow times the distance from the FOE, so rows weigh by its inverse, and
    by Tukey's biweight of the flow across the radial direction.
    """
    length = np.hypot(flow_px[:, 0], flow_px[:, 1])
    tolerance = config.tolerance_px + config.tolerance_ratio * length
    usable = length > config.min_flow_px
    none = np.zeros(len(points_px), np.bool_)
    unknown = np.array([np.nan, np.nan]), np.full((2, 2), np.inf), none
    if np.count_nonzero(usable) < 8:
        return unknown
    p, v, limit = points_px[usable], flow_px[usable], tolerance[usable]
    foe = _ransac(p, v, limit, rng)
    if foe is None:
        return unknown
    a, b = lines(p, v)
    covariance = np.full((2, 2), np.inf)
    for _ in range(4):
        across = _across(p, v, foe[None])[0]
        distance = np.hypot(*(p - foe).T) + 1.0
        weight = np.clip(1.0 - (across / (2.0 * limit)) ** 2, 0.0, None) ** 2 / (distance * limit) ** 2
        normal = (a * weight[:, None]).T @ a
        if np.linalg.det(normal) < 1e-18 or np.count_nonzero(weight) < 8:
            return unknown
        foe = np.linalg.solve(normal, (a * weight[:, None]).T @ b)
        # The tolerance is some three standard deviations of the flow.
        covariance = np.linalg.inv(normal) / 9.0
    inliers = usable & (_across(points_px, flow_px, foe[None])[0] < tolerance)
    return foe, covariance, inliers


def estimate(flow: Flow, camera: Camera, config: ExpansionConfig, rng: np.random.Generator) -> Expansion:
    """The FOE of one frame. Without enough motion it is the principal point, with confidence 0."""
    moving = np.hypot(*flow.displacement_px.T) > 1e-9 if len(flow) else np.zeros(0, np.bool_)
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
    points = flow.points_px + np.stack([shift, np.zeros_like(shift)], axis=1)
    foe, covariance, inliers = robust(points, derotated, config, rng)
    if not np.all(np.isfinite(foe)):
        return _unknown(camera, len(flow))
    voters = int(np.count_nonzero(np.hypot(*derotated.T) > config.min_flow_px))
    share = float(np.count_nonzero(inliers)) / max(1, voters)
    sharp = 1.0 / (1.0 + float(np.sqrt(np.trace(covariance))) / 5.0)
    return Expansion(float(foe[0]), float(foe[1]), covariance, inliers, float(np.clip(share * sharp, 0.0, 1.0)))


def _unknown(camera: Camera, count: int) -> Expansion:
    horizon = camera.cy_px - camera.fy_px * float(np.tan(camera.pitch_rad))
    return Expansion(camera.cx_px, horizon, np.full((2, 2), np.inf), np.zeros(count, np.bool_), 0.0)
