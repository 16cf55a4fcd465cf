"""Robust fit of the focus of expansion (FOE) to derotated flow: RANSAC if needed, then reweighted least squares."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import normalised
from vpf_sim.perception.egomotion.egomotion_settings import FocusFitConfig, RansacConfig
from vpf_sim.types import Bools, Camera, Floats

Reals = NDArray[np.floating[Any]]

ITERATIONS, SETTLED_PX = 6, 0.05  # of the reweighted least squares
NEAR_PX = 5.0  # distance from the FOE at which the radial direction is uncertain
BIWEIGHT = 1.3  # residual variance over that with the weights of Tukey's biweight
LEAST_SHARE = 0.05  # of inliers, by which the covariance grows


@dataclass(frozen=True, slots=True)
class Prior:
    """Prior of the state: FOE px, and pitch, yaw and roll rate rad/s."""

    state: Floats  # (5,)
    information: Floats  # (5, 5) inverse covariance
    expected_px: Floats | None  # (2,) the last FOE


@dataclass(frozen=True, slots=True)
class Fit:
    foe_px: Floats  # (2,)
    covariance_px2: Floats  # (2, 2)
    inliers: Bools  # (N,)


def fit(
    points_px: Floats,
    flow_px: Floats,
    gap_s: Floats,
    tolerance_px: Floats,
    camera: Camera,
    prior: Prior,
    rng: np.random.Generator,
    config: FocusFitConfig,
) -> Fit | None:
    """The FOE of N points with derotated flow over `gap_s` (N,); None if the flow does not fix it.

    The noise of a row of A x = b is the flow's times the distance from the FOE. Rows are weighted by its inverse, and
    by Tukey's biweight of the flow across the radial direction against `tolerance_px` (N,). The prior holds the rates
    of rotation that are not measured near zero.
    """
    if len(points_px) < config.least_points:
        return None
    start = _start(points_px, flow_px, tolerance_px, prior, rng, config)
    if start is None:
        return None
    turn = _tilt_flow(camera, points_px, gap_s)
    points, flow = np.ascontiguousarray(points_px.T), np.ascontiguousarray(flow_px.T)
    solved = _reweighted(points, flow, tolerance_px, turn, start, prior, config)
    if solved is None:
        return None
    state, covariance = solved
    away, (u, v) = points - state[:2, None], _turned_back(flow, turn, state[2:])
    x, y = away
    inliers = (np.abs(u * y - v * x) < tolerance_px * np.sqrt(x * x + y * y)) & (u * x + v * y > 0.0)
    # Some outliers are among the inliers, the more the fewer points agree.
    share = max(float(np.count_nonzero(inliers)) / len(inliers), LEAST_SHARE)
    return Fit(state[:2], covariance / share**2, inliers)


def _start(
    points_px: Floats,
    flow_px: Floats,
    tolerance_px: Floats,
    prior: Prior,
    rng: np.random.Generator,
    config: FocusFitConfig,
) -> Floats | None:
    """(2,) px, the start of the fit: the last FOE while most points agree with it, else the one of RANSAC."""
    p, v, tolerance = (values.astype(np.float32) for values in (points_px, flow_px, tolerance_px))
    if prior.expected_px is not None:
        votes = _votes(p, v, tolerance, prior.expected_px[None].astype(np.float32))
        if votes[0] > config.temporal_prior.accepted_share * len(p):
            return prior.expected_px
    return _searched(p, v, tolerance, prior, rng, config.ransac)


def _votes(points_px: Reals, flow_px: Reals, tolerance_px: Reals, foes_px: Reals) -> Reals:
    """(H,) number of points that agree with each FOE (H, 2), weighted by their error."""
    x, y = points_px[:, 0] - foes_px[:, :1], points_px[:, 1] - foes_px[:, 1:]
    u, v = np.ascontiguousarray(flow_px.T)
    across = np.abs(u * y - v * x) / (np.sqrt(x * x + y * y) + 1e-9)
    agreement = np.maximum(1.0 - across / tolerance_px, 0.0)
    agreement[u * x + v * y <= 0.0] = 0.0
    votes: Reals = agreement.sum(axis=1)
    return votes


def _searched(
    points_px: Reals,
    flow_px: Reals,
    tolerance_px: Reals,
    prior: Prior,
    rng: np.random.Generator,
    config: RansacConfig,
) -> Floats | None:
    """(2,) px, the intersection of two flow lines with most votes.

    The log likelihood of the prior counts like votes, up to a share of all.
    """
    if len(points_px) > config.sample:
        chosen = rng.choice(len(points_px), config.sample, replace=False)
        points_px, flow_px, tolerance_px = points_px[chosen], flow_px[chosen], tolerance_px[chosen]
    foes = _intersections(points_px, flow_px, config.hypotheses, rng)
    if prior.expected_px is not None:
        foes = np.concatenate([prior.expected_px[None], foes])
    if not len(foes):
        return None
    away = foes - prior.state[:2]
    unlikely = 0.5 * np.sum(away @ prior.information[:2, :2] * away, axis=1)
    # A quarter of the points selects the hypotheses that all points vote on.
    for part, left in ((slice(None, None, 4), config.finalists), (slice(None), 1)):
        count = len(points_px[part])
        score = _votes(points_px[part], flow_px[part], tolerance_px[part], foes.astype(np.float32))
        score = score - np.minimum(unlikely * count / len(points_px), config.prior_share * count)
        best = np.argsort(-score, kind="stable")[:left]
        foes, unlikely = foes[best], unlikely[best]
    return np.asarray(foes[0], np.float64)


def _intersections(points_px: Reals, flow_px: Reals, count: int, rng: np.random.Generator) -> Reals:
    """(H, 2) px where the flow lines of random pairs of points meet."""
    first, second = rng.integers(0, len(points_px), (2, count))
    x, y, u, v = points_px[:, 0], points_px[:, 1], flow_px[:, 0], flow_px[:, 1]
    b, length = x * v - y * u, np.hypot(u, v)
    determinant = u[first] * v[second] - v[first] * u[second]
    parallel = np.abs(determinant) < 0.05 * length[first] * length[second] + 1e-12
    determinant[parallel] = 1.0
    foe_x = (b[second] * u[first] - b[first] * u[second]) / determinant
    foe_y = (v[first] * b[second] - v[second] * b[first]) / determinant
    foes: Reals = np.stack([foe_x, foe_y], axis=1)[~parallel]
    return foes


def _tilt_flow(camera: Camera, points_px: Floats, gap_s: Floats) -> Floats:
    """(2, 3, N) px per rad/s, image motion by slow turns about the camera's x, y and z axes over each window.

    To first order and up to sign (Longuet-Higgins and Prazdny 1980).
    """
    x, y = normalised(camera, points_px)
    along_x, along_y = camera.fx_px * gap_s, camera.fy_px * gap_s
    motion = np.empty((2, 3, len(x)))
    motion[0, 0], motion[0, 1], motion[0, 2] = along_x * x * y, along_x * (1.0 + x * x), -along_x * y
    motion[1, 0], motion[1, 1], motion[1, 2] = along_y * (1.0 + y * y), along_y * x * y, along_y * x
    return motion


def _reweighted(
    points: Floats,
    flow: Floats,
    tolerance_px: Floats,
    turn: Floats,
    start_px: Floats,
    prior: Prior,
    config: FocusFitConfig,
) -> tuple[Floats, Floats] | None:
    """(5,) FOE px and pitch, yaw and roll rates rad/s, and the FOE's (2, 2) covariance px^2; None if it has none.

    `points` and `flow` are (2, N) px here.
    """
    state, steady = np.array([*start_px, 0.0, 0.0, 0.0]), flow
    for _ in range(ITERATIONS):
        weight, slope, across = _linearised(points, steady, turn, state[:2], tolerance_px)
        weighted = (slope * weight[:, None]).T
        normal = weighted @ slope
        if np.count_nonzero(weight) < config.least_points or normal[0, 0] * normal[1, 1] - normal[0, 1] ** 2 < 1e-12:
            return None
        normal += prior.information
        step = np.linalg.solve(normal, weighted @ across + prior.information @ (state - prior.state))
        state = state - step
        if abs(step[0]) + abs(step[1]) < SETTLED_PX:
            break
        steady = _turned_back(flow, turn, state[2:])
    spread = BIWEIGHT * float(weight @ (across * across)) / np.count_nonzero(weight)
    return state, np.asarray(np.linalg.inv(normal)[:2, :2], np.float64) * max(1.0, spread)


def _linearised(
    points: Floats, flow: Floats, turn: Floats, foe_px: Floats, tolerance_px: Floats
) -> tuple[Floats, Floats, Floats]:
    """Weights (N,), slopes (N, 5) and values (N,) px of the flow across the radial direction, at a FOE and rates."""
    away, (u, v) = points - foe_px[:, None], flow
    x, y = away
    nearness = 1.0 / (np.sqrt(x * x + y * y) + NEAR_PX)
    away *= nearness
    across = u * y - v * x
    # The tolerance is some three standard deviations of the flow.
    size = across / tolerance_px
    size *= size
    weight = np.maximum(1.0 - 0.25 * size, 0.0) * (3.0 / tolerance_px)
    weight *= weight
    weight[u * x + v * y <= 0.0] = 0.0
    slope = np.empty((5, len(across)))
    np.multiply(v, nearness, out=slope[0])
    np.multiply(-u, nearness, out=slope[1])
    np.multiply(turn[1], x, out=slope[2:])
    slope[2:] -= turn[0] * y
    return weight, np.ascontiguousarray(slope.T), across


def _turned_back(flow: Floats, turn: Floats, rates: Floats) -> Floats:
    """(2, N) px, the flow without slow turns at these rates (3,) rad/s."""
    return np.asarray(flow - np.ascontiguousarray(turn.swapaxes(1, 2)) @ rates)
