"""Tracker of static obstacles: points above the road and low obstacles, kept in the world until passed."""

from dataclasses import replace
from functools import partial

import numpy as np

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.egomotion.triangulation import Triangulation, triangulate
from vpf_sim.perception.obstacles.crossing import Crossers, nobody
from vpf_sim.perception.obstacles.moving.place import is_on_carriageway
from vpf_sim.perception.obstacles.obstacle_clusters import ObstacleClusters
from vpf_sim.perception.obstacles.oncoming import oncoming_vehicles
from vpf_sim.perception.obstacles.planar_parallax.detector import PlanarParallax
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks
from vpf_sim.perception.obstacles.point_detection import PointDetector
from vpf_sim.perception.obstacles.point_hypotheses import PointHypotheses, among, followed
from vpf_sim.perception.obstacles.prediction import none, to_current_frame
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.perception.obstacles.track_refinement import Match, candidates, refined
from vpf_sim.perception.road.occlusion import footprints
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Bools, Camera, Floats, Flow, Image, Integers, Obstacles, RoadEdges


class StaticObstacleTracker:
    """Confirms points over frames, clusters them to obstacles, and keeps these in the world.

    An obstacle is pruned once the car has passed it; never because it can no longer be measured. Fragments of an
    obstacle are pruned once their tracks are lost.
    """

    def __init__(self, camera: Camera, config: StaticObstacleConfig, rate_hz: float, window_px: int) -> None:
        """`window_px` is the side of the flow's window."""
        self.camera, self.config, self.rate_hz, self._window_px = camera, config, rate_hz, window_px
        self._schedule = Schedule(config.update_period_s, rate_hz)
        self._obstacles = self._tall = none()
        self._pose: Floats = np.zeros(3)  # of these
        self._detector = PointDetector(camera, config, rate_hz, self._schedule.rate_hz)
        self.points = PointHypotheses.none()
        self._clusters = ObstacleClusters(camera, config, self.points, window_px)
        self.parallax = PlanarParallax(camera, config.planar_parallax, rate_hz)
        next_identity, near_m = self._clusters.next_identity, config.planar_parallax.near_m
        self.low_tracks = LowObstacleTracks(config.low_tracks, next_identity, near_m, config.behind_m)

    def triangulate(self, flow: Flow) -> Triangulation:
        """The points of the flow by their chained tracks, as if all of them stood."""
        return self._triangulate(flow, flow.age_frames / self.rate_hz)

    def refined(
        self, flow: Flow, points: Triangulation, road: RoadEdges, match: Match, speed_mps: float
    ) -> Triangulation:
        """The same, those that may be above the road matched with the frame of their first observation."""
        config = self.config.track_refinement
        rows = candidates(points, road, self.camera, config, self.config.range_factor(speed_mps))
        if not len(rows):
            return points
        return refined(flow, points, rows, match, config, partial(self.matched, flow), self.camera)

    def matched(self, flow: Flow, rows: Integers, aside_px: Floats) -> Triangulation:
        """Some points of the flow, first observed `aside_px` from where it says, and matched there."""
        some = flow.select(rows)
        return self._triangulate(replace(some, first_px=some.first_px + aside_px), np.zeros(len(rows)))

    def _triangulate(self, flow: Flow, age_s: Floats) -> Triangulation:
        return triangulate(flow, self.camera, self._window_px, age_s, self.config.noise)

    def update(
        self,
        flow: Flow,
        road: RoadEdges,
        speed_mps: float,
        time_s: float,
        points: Triangulation,
        moving: Bools | None = None,
    ) -> Obstacles:
        """The static obstacles ahead after this frame, in vehicle axes at `flow.pose`.

        `points` are those of `triangulate`; `moving` (N,) marks those of moving obstacles.
        """
        if self._schedule.step():
            if moving is not None and moving.any():
                self.points.keep(~among(self.points.identity, flow.identity[moving]))
            range_factor = self.config.range_factor(speed_mps)
            seen = self._detector.observe(flow, points, road, moving, range_factor)
            self.points.record(seen, self.config, self._schedule.rate_hz, time_s)
            self._prune(flow)
            tracks = self.low_tracks.bodies(flow.pose)
            self._tall, self._obstacles = self._clusters.obstacles(flow.pose, road, tracks, range_factor)
            self._pose = flow.pose
        return to_current_frame(self._obstacles, self._pose, flow.pose)

    def relief(self, obstacles: Obstacles) -> Floats:
        """(K,) as `PlanarParallax.relief`; nan of tall obstacles, whose shadows lie in the road's plane."""
        tall = among(obstacles.identity, self._tall.identity)
        return np.where(tall, np.nan, self.parallax.relief(obstacles))

    def oncoming(self, points: Triangulation, road: RoadEdges, speed_mps: float) -> Crossers:
        """Oncoming vehicles by the points of the last update."""
        rows, config = self._detector.coming, self.config.oncoming
        if not len(rows) or rows[-1] >= len(points.depth_m):
            return nobody()
        return oncoming_vehicles(points, rows, road, self.camera, config, speed_mps)

    def _prune(self, flow: Flow) -> None:
        points = self.points
        fragment = among(points.identity, self._clusters.fragments)
        ahead = vehicle_from_world(points.place_m, flow.pose)[:, 0] > -self.config.behind_m
        wanted = ((points.confirmed & ~fragment) | followed(points.identity, flow)) & ahead
        if not wanted.all():
            points.keep(wanted)

    def compare_road(
        self,
        image: Image | None,
        pose: Floats,
        road: RoadEdges,
        moving: Obstacles | None = None,
        speed_mps: float = 0.0,
    ) -> None:
        """Observe low obstacles in the frame (H, W) taken at `pose`; None under the wiper.

        Ignores pixels that a known obstacle occludes, in this frame or, if it moves, in the reference frame.
        """
        known = None
        if image is not None and self.parallax.looks:
            hiding = to_current_frame(self._tall, self._pose, pose)
            if moving is not None and len(moving):
                hiding = hiding.concatenate(moving)
            since_s = self.config.planar_parallax.baseline_m / max(speed_mps, 1.0)
            known = footprints(hiding, road, since_s)
        found = self.parallax.update(image, pose, known)
        if found is not None:
            margin_m = self.config.edge_margin_m
            inside = [one for one in found if is_on_carriageway(one.forward_m, one.middle_m, road, margin_m)]
            self.low_tracks.record(inside, pose)
