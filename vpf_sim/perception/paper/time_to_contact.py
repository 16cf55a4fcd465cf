"""Time to contact (TTC) of image points: depth / closing speed, from the flow alone (paper, section III-B)."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.perception.egomotion.focus_of_expansion import Derotated, derotated
from vpf_sim.perception.paper.paper_settings import ContactConfig
from vpf_sim.types import Camera, Expansion, Floats, Flow

Labels = NDArray[np.int64]


def as_printed(flow: Flow, expansion: Expansion, config: ContactConfig) -> Floats:
    """(N,) s, TTC_i = |p_i - p_FOE| / |v_i|, as printed, in windows, times the window.

    It holds for pure translation, and is one window too long, since p_i is the point at the window's end.
    """
    distance = np.hypot(flow.points_px[:, 0] - expansion.x_px, flow.points_px[:, 1] - expansion.y_px)
    speed = np.hypot(*flow.displacement_px.T)
    ttc = flow.gap_s * distance / np.maximum(speed, config.floor_px)
    capped: Floats = np.minimum(ttc, config.cap_s)
    return capped


def _radial(flow: Flow, turned: Derotated, expansion: Expansion, config: ContactConfig) -> Floats:
    """(N,) s from each point's derotated motion (N, 2) away from the FOE; inf where it does not approach.

    A standing point at distance r from the FOE came from r - d in the window T, so Z r is constant, and
    TTC now = Z / (dZ / T) = T (r - d) / d.
    """
    ratio = _radial_ratio(flow, turned, expansion, config)
    with np.errstate(divide="ignore"):
        ttc = np.where(ratio > 0.0, flow.gap_s * (1.0 - ratio) / ratio, np.inf)
    return np.where(ttc > config.cap_s, np.inf, ttc)


def of_clusters(flow: Flow, displacement_px: Floats, labels: Labels, config: ContactConfig) -> Floats:
    """(K,) s by the expansion of each cluster: d = (p - c) s fitted over its points, TTC = T (1 - s) / s.

    `displacement_px` (N, 2) is without the car's rotation. `labels` (N,) counts clusters from 0; -1 is none. The centre
    c is fitted too, so that a cluster needs no FOE and may move. Clusters of too few points are inf.
    """
    count = int(labels.max(initial=-1)) + 1
    chosen = (labels >= 0) & (flow.gap_s > 0.0)
    label, gap = labels[chosen], flow.gap_s[chosen]
    points = flow.points_px[chosen]
    rate = displacement_px[chosen] / gap[:, None]  # windows differ in length, their rates agree to first order
    size = np.bincount(label, minlength=count)

    def centred(values: Floats) -> Floats:
        mean = np.empty((count, 2))
        for i in (0, 1):
            mean[:, i] = np.bincount(label, values[:, i], count)
        mean /= np.maximum(size, 1)[:, None]
        away: Floats = values - mean[label]
        return away

    p, v = centred(points), centred(rate)
    spread = np.bincount(label, np.sum(p * p, axis=1), count)
    growth = np.bincount(label, np.sum(p * v, axis=1), count) / np.maximum(spread, 1e-9)
    window = np.bincount(label, gap, count) / np.maximum(size, 1)
    with np.errstate(divide="ignore"):
        ttc = np.where((growth > 0.0) & (size >= config.least_points) & (spread > 1.0), 1.0 / growth - window, np.inf)
    return np.where(ttc > config.cap_s, np.inf, np.maximum(ttc, 0.0))


def time_to_contact(
    flow: Flow,
    expansion: Expansion,
    camera: Camera,
    config: ContactConfig,
    labels: Labels | None = None,
    turned: Derotated | None = None,
) -> Floats:
    """(N,) s of each point of the flow; points of a cluster (`labels`) take the cluster's where it has one.

    `turned` is the flow `derotated`, where it is at hand.
    """
    if config.method == "as_printed":
        return as_printed(flow, expansion, config)
    turned = turned or derotated(flow, camera)
    ttc = _radial(flow, turned, expansion, config)
    if labels is None or not np.any(labels >= 0):
        return ttc
    clusters = of_clusters(flow, turned.flow_px, labels, config)
    together = np.where(labels >= 0, clusters[np.maximum(labels, 0)], np.inf)
    return np.where(np.isfinite(together), together, ttc)


def _radial_ratio(flow: Flow, turned: Derotated, expansion: Expansion, config: ContactConfig) -> Floats:
    """(N,) d / r: radial motion over the distance from the chord's image; 0 where it is below the floor."""
    x = flow.points_px[:, 0] - (expansion.x_px - turned.shift_px)
    y = flow.points_px[:, 1] - expansion.y_px
    distance_squared = x * x + y * y + 1e-12
    along = turned.flow_px[:, 0] * x + turned.flow_px[:, 1] * y
    ratio: Floats = np.where(along > config.floor_px * np.sqrt(distance_squared), along / distance_squared, 0.0)
    return ratio
