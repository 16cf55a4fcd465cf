"""The paper's obstacle map O_t: which points stand out from the road, as a smoothed binary plane (section III-C)."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.perception.egomotion.ground_plane import ground_flow
from vpf_sim.perception.paper.obstacle_region import Surroundings, inside
from vpf_sim.perception.paper.paper_settings import ObstacleMapConfig
from vpf_sim.types import Bools, Camera, Floats, Flow, ObstacleMap


def otsu(values: Floats) -> float:
    """The threshold that maximises the variance between the two classes (Otsu 1979), exact for a sparse set."""
    if len(values) < 2:
        return np.inf
    ordered = np.sort(values)
    count = np.arange(1, len(ordered))
    below = np.cumsum(ordered)[:-1]
    total = below[-1] + ordered[-1]
    mean_gap = below / count - (total - below) / (len(ordered) - count)
    between = count * (len(ordered) - count) * mean_gap**2
    best = int(np.argmax(between))
    return float(0.5 * (ordered[best] + ordered[best + 1]))


def on_obstacle(flow: Flow, camera: Camera, config: ObstacleMapConfig, around: Surroundings | None = None) -> Bools:
    """(N,) which points of the region are not of the road. The absolute test is |r| > 3 sigma + ratio |g|.

    g is the flow of the flat road under the own motion, r = v - g. Otsu on |v| takes the near road for the obstacle;
    Otsu on |r| always finds some; the absolute test finds none where there is none.
    """
    candidates = flow.gap_s > 0.0
    if around is not None and config.region is not None:
        candidates = candidates & inside(flow.points_px, camera, around, config.region)
    if config.method == "otsu_flow":
        size = np.hypot(*flow.displacement_px.T)
        moving: Bools = candidates & (size > otsu(size[candidates]))
        return moving
    road = ground_flow(camera, flow.points_px, flow.past_pose, flow.pose)
    residual = np.hypot(*(flow.displacement_px - road).T)
    if config.method == "otsu_residual":
        threshold: Floats | float = otsu(residual[candidates])
    else:
        threshold = 3.0 * config.noise_px + config.ratio * np.hypot(*road.T)
    marked: Bools = candidates & (residual > threshold)
    return marked


def rasterise(points_px: Floats, camera: Camera, config: ObstacleMapConfig, weight: Floats | None = None) -> Floats:
    """(h, w) plane of the reduced image: 1, or the largest weight (N,) in [0, 1], on the discs about the points."""
    height, width = (-(-size // config.reduction) for size in (camera.height_px, camera.width_px))
    plane = np.zeros((height, width), np.float32)
    rows, columns = _cells(points_px, config.reduction, plane.shape)
    if weight is None:
        plane[rows, columns] = 1.0
    else:
        np.maximum.at(plane, (rows, columns), weight.astype(np.float32))
    return cv2.dilate(plane, _disc(config.disc_px / config.reduction)).astype(np.float64)


def smoothed_gradient(plane: Floats, config: ObstacleMapConfig) -> Floats:
    """(2, h, w) grad (G * O) per pixel of the full image, O = 0 outside the frame; 0 without a sigma.

    The Gaussian is separable, so the convolution with zero padding is one matrix from each side, and its gradient the
    same with the Gaussian's derivative. Printed, G has the factor 1 / (2 pi sigma) instead of 1 / (2 pi sigma^2).
    """
    height, width = plane.shape
    if config.sigma_px is None:
        return np.zeros((2, height, width))
    rows, rows_slope = _gaussian(height, config.reduction, config.sigma_px)
    columns, columns_slope = _gaussian(width, config.reduction, config.sigma_px)
    gain = config.sigma_px if config.normalisation == "as_printed" else 1.0
    return gain * np.stack([rows @ (plane @ columns_slope.T), rows_slope @ (plane @ columns.T)])


def cluster_labels(obstacle_map: ObstacleMap, flow: Flow) -> NDArray[np.int64]:
    """(N,) connected part of the plane that each marked point lies in, from 0; -1 for the others."""
    _, parts = cv2.connectedComponents(obstacle_map.plane.astype(np.uint8))
    rows, columns = _cells(flow.points_px, obstacle_map.reduction, obstacle_map.plane.shape)
    label = parts[rows, columns].astype(np.int64)
    return np.where(obstacle_map.on_obstacle, label - 1, -1)


def _cells(points_px: Floats, reduction: int, shape: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(N,) rows and (N,) columns of the reduced image that hold the points, or the nearest ones."""
    cell = ((points_px + 0.5) / reduction).astype(np.intp)
    cell = np.minimum(np.maximum(cell, 0), (shape[1] - 1, shape[0] - 1))
    return cell[:, 1], cell[:, 0]


def detect(flow: Flow, camera: Camera, config: ObstacleMapConfig, around: Surroundings | None = None) -> ObstacleMap:
    """O_t of one frame and the gradient g = grad (G * O_t); `around` where the configuration `needs_surroundings`."""
    marked = on_obstacle(flow, camera, config, around)
    plane = rasterise(flow.points_px[marked], camera, config)
    if config.min_points > 1 and np.any(marked):
        label = cluster_labels(ObstacleMap(marked, plane, np.empty((2, 0, 0)), config.reduction), flow)
        size = np.bincount(label[label >= 0])
        marked = marked & (size[np.maximum(label, 0)] >= config.min_points)
        plane = rasterise(flow.points_px[marked], camera, config)
    weighted = plane
    if config.weight == "ttc" and around is not None:
        urgency = np.clip(1.0 - around.ttc_s[marked] / config.horizon_s, 0.0, 1.0)
        weighted = rasterise(flow.points_px[marked], camera, config, urgency)
    return ObstacleMap(marked, plane, smoothed_gradient(weighted, config), config.reduction)


@lru_cache(maxsize=8)
def _disc(radius_cells: float) -> NDArray[np.uint8]:
    reach = int(np.ceil(radius_cells))
    offset = np.arange(-reach, reach + 1)
    return (offset[:, None] ** 2 + offset**2 <= radius_cells**2 + 1e-9).astype(np.uint8)


@lru_cache(maxsize=8)
def _gaussian(cells: int, reduction: int, sigma_px: float) -> tuple[Floats, Floats]:
    """Matrices (cells, cells) of the one-dimensional Gaussian and its derivative, integrated over a cell's width."""
    place = reduction * np.arange(cells, dtype=np.float64)
    offset = (place[:, None] - place) / sigma_px
    bell = np.exp(-0.5 * offset**2) * reduction / (np.sqrt(2.0 * np.pi) * sigma_px)
    return bell, -offset / sigma_px * bell
