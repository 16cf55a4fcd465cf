"""The focus of expansion (FOE): the image of the direction in which the camera moves (paper, section III-A)."""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, sqrt

import numpy as np

from vpf_sim.geometry import rotation_flow, straight_ahead_px
from vpf_sim.perception.egomotion.egomotion_settings import ExpansionConfig, FocusFitConfig, TemporalPriorConfig
from vpf_sim.perception.egomotion.focus_fit import Prior, fit
from vpf_sim.types import Camera, Expansion, Floats, Flow

LEAST_CONFIDENCE = 0.1  # below it results of the flow are not reliable


def lines(points_px: Floats, flow_px: Floats) -> tuple[Floats, Floats]:
    """A (N, 2) and b (N,) of the lines through the points along their flow: a = (v_y, -v_x), b = x v_y - y v_x."""
    a = np.stack([flow_px[:, 1], -flow_px[:, 0]], axis=1)
    b: Floats = np.sum(a * points_px, axis=1)
    return a, b


def least_squares(points_px: Floats, flow_px: Floats) -> Floats:
    """(2,) px, FOE = (A^T A)^-1 A^T b, the paper's definition; rows weigh by |v|, which is right."""
    a, b = lines(points_px, flow_px)
    return np.asarray(np.linalg.lstsq(a, b, rcond=None)[0], np.float64)


def as_printed(points_px: Floats, flow_px: Floats) -> Floats:
    """(2,) px, the paper's closed form as printed: wrong sign, wrong first product of the denominator.

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
    """(N, 2) px, the displacement by the camera's translation alone, in the axes of the camera now.

    The past point is turned by the measured yaw change over its window. The line through it and the point now then
    passes through the image of the chord of the camera's path.
    """
    yaw_change = flow.pose[2] - flow.past_pose[:, 2]
    past = flow.points_px - flow.displacement_px
    turned: Floats = past - rotation_flow(camera, past, -yaw_change)
    return flow.points_px - turned


@dataclass(frozen=True, slots=True)
class Derotated:
    """Flow without rotation."""

    flow_px: Floats  # (N, 2) see `derotate`
    shift_px: Floats  # (N,) by which the FOE now is right of each point's chord: half the turn over its window


def derotated(flow: Flow, camera: Camera) -> Derotated:
    """The derotated flow and its shift, for stages to share."""
    yaw_change = np.remainder(flow.pose[2] - flow.past_pose[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    return Derotated(derotate(flow, camera), camera.fx_px * np.tan(0.5 * yaw_change))


def estimate(
    flow: Flow,
    camera: Camera,
    config: ExpansionConfig,
    rng: np.random.Generator,
    before: Expansion | None = None,
    turned: Derotated | None = None,
) -> Expansion:
    """The FOE of one frame; `before` is the last frame's, `turned` the flow `derotated` if it is at hand.

    Without enough motion it is the last one with a growing covariance, or the point straight ahead, with confidence 0.
    The confidence of the robust FOE is the share of inliers among moving and windscreen points, lower with a large
    covariance.
    """
    if config.method == "robust" and config.fit is not None:
        return _robust(flow, camera, config.fit, rng, before, turned)
    moving = np.hypot(flow.displacement_px[:, 0], flow.displacement_px[:, 1]) > 1e-9
    if np.count_nonzero(moving) < 2:
        return _unknown(camera, len(flow))
    solve = least_squares if config.method == "least_squares" else as_printed
    x, y = solve(flow.points_px[moving], flow.displacement_px[moving])
    if not (np.isfinite(x) and np.isfinite(y)):
        return _unknown(camera, len(flow))
    return Expansion(float(x), float(y), np.full((2, 2), np.nan), moving, 1.0)


def _robust(
    flow: Flow,
    camera: Camera,
    config: FocusFitConfig,
    rng: np.random.Generator,
    before: Expansion | None,
    turned: Derotated | None,
) -> Expansion:
    rate_hz = _rate_hz(flow)
    if rate_hz == inf:
        return _held(before, camera, config, rate_hz, len(flow))
    turned = turned or derotated(flow, camera)
    points = flow.points_px.copy()
    # The shift moves the lines' intersection from the chord's image to the present FOE.
    points[:, 0] += turned.shift_px
    steps = np.maximum(flow.gap_s * rate_hz, 1.0)
    length = np.hypot(turned.flow_px[:, 0], turned.flow_px[:, 1])
    voters = np.flatnonzero((length > config.min_flow_px) & ~flow.on_glass)
    tolerance = np.sqrt(steps) * (config.tolerance_px + config.tolerance_ratio * length / steps)
    prior = _prior(camera, config, before, rate_hz)
    points, moved, gap_s, tolerance = (
        values.take(voters, axis=0) for values in (points, turned.flow_px, flow.gap_s, tolerance)
    )
    found = fit(points, moved, gap_s, tolerance, camera, prior, rng, config)
    if found is None:
        return _held(before, camera, config, rate_hz, len(flow))
    inliers = np.zeros(len(flow), np.bool_)
    inliers[voters] = found.inliers
    share = float(np.count_nonzero(found.inliers)) / (len(voters) + np.count_nonzero(flow.on_glass))
    spread_rad = sqrt(found.covariance_px2[0, 0] + found.covariance_px2[1, 1]) / camera.fx_px
    x, y = (float(value) for value in found.foe_px)
    return Expansion(x, y, found.covariance_px2, inliers, min(1.0, share / (1.0 + spread_rad / config.sharp_rad)))


def _prior(camera: Camera, config: FocusFitConfig, before: Expansion | None, rate_hz: float) -> Prior:
    """Usual direction and rates of a vehicle, combined with the last FOE."""
    usual = _usual(camera, config)
    if before is None or not np.isfinite(before.covariance_px2).all():
        return usual
    information = usual.information.copy()
    last = np.array([before.x_px, before.y_px])
    known = _inverse(_drifted(before.covariance_px2, camera, config.temporal_prior, rate_hz))
    pull = information[:2, :2] @ usual.state[:2] + known @ last
    information[:2, :2] += known
    x, y = (_inverse(information[:2, :2]) @ pull).tolist()
    return Prior(np.array([x, y, 0.0, 0.0, 0.0]), information, last)


@lru_cache(maxsize=8)
def _usual(camera: Camera, config: FocusFitConfig) -> Prior:
    """The prior without a last frame; it must not be changed."""
    information = np.zeros((5, 5))
    direction, rotation = config.direction_prior, config.rotation
    sides_rad = (direction.side_sd_rad, direction.height_sd_rad) if direction else (inf, inf)
    rates = (rotation.tilt_sd_radps, rotation.yaw_sd_radps, rotation.tilt_sd_radps)
    sides = np.array(sides_rad) * [camera.fx_px, camera.fy_px]
    information.flat[::6] = [*sides**-2.0, *(max(sd, 1e-9) ** -2.0 for sd in rates)]
    return Prior(np.array([*straight_ahead_px(camera), 0.0, 0.0, 0.0]), information, None)


def _inverse(matrix: Floats) -> Floats:
    """(2, 2), in closed form: `np.linalg.inv` takes ten times as long."""
    (a, b), (c, d) = matrix.tolist()
    inverse: Floats = np.array(((d, -b), (-c, a))) / (a * d - b * c)
    return inverse


def _drifted(covariance_px2: Floats, camera: Camera, config: TemporalPriorConfig, rate_hz: float) -> Floats:
    """(2, 2) px^2, a frame later."""
    later: Floats = covariance_px2 + (config.drift_sd_rad * camera.fx_px) ** 2 / rate_hz * np.eye(2)
    return later


def _rate_hz(flow: Flow) -> float:
    """Frames a second, by the youngest points; inf without tracked points."""
    young = flow.gap_s > 0.0
    return float((flow.age_frames[young] / flow.gap_s[young]).min(initial=inf))


def _held(before: Expansion | None, camera: Camera, config: FocusFitConfig, rate_hz: float, count: int) -> Expansion:
    if before is None:
        return _unknown(camera, count)
    covariance = _drifted(before.covariance_px2, camera, config.temporal_prior, rate_hz)
    return Expansion(before.x_px, before.y_px, covariance, np.zeros(count, np.bool_), 0.0)


def _unknown(camera: Camera, count: int) -> Expansion:
    x, y = (float(value) for value in straight_ahead_px(camera))
    return Expansion(x, y, np.full((2, 2), np.inf), np.zeros(count, np.bool_), 0.0)
