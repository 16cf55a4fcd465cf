"""Points of one frame that are above the road, or on it, by their triangulated tracks."""

import numpy as np

from vpf_sim.geometry import ground_from_pixels, world_from_vehicle
from vpf_sim.perception.egomotion.corners import eigenvalues, is_corner
from vpf_sim.perception.egomotion.ground_plane import below_horizon, past_image
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.looming_consistency import LoomingConsistency
from vpf_sim.perception.obstacles.low_obstacles import is_low, off_lines
from vpf_sim.perception.obstacles.oncoming import come_towards
from vpf_sim.perception.obstacles.point_hypotheses import PointObservations, frames
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, RoadEdges


class PointDetector:
    """Finds the points of a frame above the road."""

    def __init__(self, camera: Camera, config: StaticObstacleConfig, rate_hz: float, update_hz: float) -> None:
        """`rate_hz` of the flow's frames, `update_hz` of those that are passed to `observe`."""
        self._camera, self._config, self._rate_hz = camera, config, rate_hz
        self._looming = LoomingConsistency(config.looming_consistency, update_hz)
        self.coming: Integers = np.empty(0, np.int64)  # rows of the last frame's points of oncoming traffic

    def observe(
        self, flow: Flow, points: Triangulation, road: RoadEdges, moving: Bools | None, range_factor: float
    ) -> PointObservations:
        """The points above the road that are not of obstacles that `moving` (N,) marks.

        `range_factor` is that of `StaticObstacleConfig`.
        """
        self._looming.record(flow)
        texture, _ = eigenvalues(flow.structure)
        tall = self._are_tall(flow, points, road, range_factor * self._config.far_m)
        low = self._are_low(flow, points, texture, road) & ~tall
        found = tall | low if moving is None else (tall | low) & ~moving
        rows = np.flatnonzero(found)
        depth, right = points.depth_m[rows], points.right_m[rows]
        place = np.stack([self._camera.forward_m + depth, right], axis=1)
        return PointObservations(
            identity=flow.identity[rows],
            place_m=world_from_vehicle(place, flow.pose),
            sigma_m=points.sigma_m[rows],
            sight_rad=flow.pose[2] + np.arctan(right / depth),
            depth_m=depth,
            seed_weight=np.where(low[rows], 0.0, self._seed_weight(flow, points, texture, road, rows)),
            low=low[rows],
            margin=points.chi2_ground[rows] - points.chi2[rows],
        )

    def _are_tall(self, flow: Flow, points: Triangulation, road: RoadEdges, far_m: float) -> Bools:
        """(N,) points that surely stand above the carriageway."""
        config = self._config
        depth = points.depth_m
        with np.errstate(invalid="ignore", divide="ignore"):
            above = (depth > config.near_m) & (depth < far_m)
            above &= flow.age_frames >= frames(config.min_age_s, self._rate_hz)
            above &= np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T) > config.travel_share * depth
            above &= points.sigma_m / depth < config.depth_ratio
            above &= (points.chi2 < config.chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
            above &= points.height_m > config.min_height_m + 2.0 * points.height_sigma_m
            above &= points.height_m < config.max_height_m + 2.0 * points.height_sigma_m
        rows = np.flatnonzero(above)
        left, right = carriageway_offsets(self._camera.forward_m + depth[rows], road)
        aside = points.right_m[rows]
        margin = config.edge_margin_m
        near = (aside > left - road.oncoming_m + margin) & (aside < right - margin)
        rows, inside = rows[near], (aside > left + margin)[near]
        comes = come_towards(points, rows, road, self._camera, config)
        self.coming, rows = rows[comes], rows[inside & ~comes]
        return self._moving_as_placed(flow, points, rows[~self._are_far(flow, points, rows)])

    def _are_far(self, flow: Flow, points: Triangulation, rows: Integers) -> Bools:
        """Which rows are far away and move; only points before far road may be."""
        far = np.zeros(len(rows), np.bool_)
        high = np.flatnonzero(self._before_far_road(flow.points_px[rows]))
        if len(high):
            far[high] = self._looming.keeps_together(rows[high], 1.0 / points.depth_m[rows[high]])
        return far

    def _before_far_road(self, points_px: Floats) -> Bools:
        """(N,) pixels whose ray meets the road far away, or not at all."""
        far: Bools = below_horizon(self._camera, points_px) * self._config.foot_m < self._camera.height_m
        return far

    def _are_low(self, flow: Flow, points: Triangulation, texture: Floats, road: RoadEdges) -> Bools:
        """(N,) points a hand's breadth above the carriageway, off its lines."""
        config = self._config
        if config.low_obstacles is None:
            return np.zeros(len(flow), np.bool_)
        age_s = flow.age_frames / self._rate_hz
        rows = np.flatnonzero(is_low(points, age_s, texture, config.low_obstacles, config.precise_m, config.chi2_limit))
        return self._moving_as_placed(flow, points, rows[self._off_lines(flow.points_px[rows], road)])

    def _off_lines(self, points_px: Floats, road: RoadEdges) -> Bools:
        """(N,) pixels whose place on the flat road is within the carriageway and on no painted line."""
        config = self._config.low_obstacles
        if config is None:
            return np.ones(len(points_px), np.bool_)
        return off_lines(self._camera, ground_from_pixels(self._camera, points_px), road, config)

    def _moving_as_placed(self, flow: Flow, points: Triangulation, rows: Integers) -> Bools:
        """(N,) those rows whose last motion fits the place by the whole track: others slipped to something else."""
        config, found = self._config.recent_motion, np.zeros(len(flow), np.bool_)
        if len(rows):
            depth = points.depth_m[rows]
            place = np.stack([self._camera.forward_m + depth, points.right_m[rows], points.height_m[rows]], axis=1)
            before = flow.points_px[rows] - flow.displacement_px[rows]
            error = np.hypot(*(before - past_image(self._camera, place, flow.past_pose[rows], flow.pose)).T)
            rows = rows[error < config.error_px + config.ratio * np.hypot(*flow.displacement_px[rows].T)]
        found[rows] = True
        return found

    def _seed_weight(
        self, flow: Flow, points: Triangulation, texture: Floats, road: RoadEdges, rows: Integers
    ) -> Floats:
        """(M,) from 0 to 1, how far each of the rows may begin an obstacle."""
        config, points_px = self._config, flow.points_px[rows]
        corner = is_corner(flow.structure[rows], config.corner_texture, config.corner_ratio)
        weight = np.where(self._before_far_road(points_px), config.far_road.share * corner, 1.0)
        weight[texture[rows] <= config.seed_texture] = 0.0
        far = points.depth_m[rows] > config.precise_m
        slides = np.flatnonzero(far & (points.height_m[rows] < config.dash_seed.height_m))
        if len(slides):
            weight[slides] *= self._off_lines(points_px[slides], road)
        return weight
