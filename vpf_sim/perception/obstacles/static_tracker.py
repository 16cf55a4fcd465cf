"""Bodies on the road: followed points that stand above it, kept in the world until the car has passed them."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from vpf_sim.geometry import ground_from_pixels, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.egomotion.corners import eigenvalues, is_corner
from vpf_sim.perception.egomotion.ground_plane import below_horizon, past_image
from vpf_sim.perception.egomotion.triangulation import Triangulation, triangulate
from vpf_sim.perception.obstacles.config import StaticObstacleConfig
from vpf_sim.perception.obstacles.extent import none, to_current_frame
from vpf_sim.perception.obstacles.free_road import FreeRoadEvidence
from vpf_sim.perception.obstacles.looming_consistency import LoomingConsistency
from vpf_sim.perception.obstacles.low_obstacles import is_low, off_lines
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation, PlanarParallax
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks, in_sight
from vpf_sim.perception.obstacles.point_hypotheses import (
    ConfirmationRule,
    Integers,
    PointHypotheses,
    Sightings,
    among,
    followed,
    frames,
)
from vpf_sim.perception.obstacles.static_obstacles import Bodies
from vpf_sim.perception.obstacles.track_refinement import Match, candidates, refined
from vpf_sim.perception.road.geometry import carriageway_offsets, near_edge_line
from vpf_sim.perception.road.occlusion import driven_over, footprints
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Bools, Camera, Floats, Flow, Image, Obstacles, RoadEdges

SLOWEST_MPS = 1.0  # own speed, below which what passed by the road ahead earlier is not looked for


class StaticObstacleTracker:
    """Confirms points over frames, joins them to bodies, and remembers these in the world.

    A body is never forgotten because it can no longer be measured; only because the car has passed it, or because its
    own points turn out to lie on the road. But points that parted from it and are none of their own are, once lost.
    """

    def __init__(self, camera: Camera, config: StaticObstacleConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.rate_hz = rate_hz
        self._schedule = Schedule(config.update_period_s, rate_hz)
        self._seen = self._tall = none()
        self._seen_from: Floats = np.zeros(3)
        judged_hz = self._schedule.rate_hz
        self._rules = ConfirmationRule(
            rate_hz=judged_hz,
            hits=frames(config.hits_s, judged_hz),
            most_hits=2 * frames(config.single_hits_s, judged_hz),
            share=config.hits_share,
            steady_m=config.steady_m,
            steady_ratio=config.steady_ratio,
        )
        self._points = PointHypotheses.none()
        self._bodies = Bodies(camera, config, self._points, judged_hz)
        self._parallax = PlanarParallax(camera, config.residual, rate_hz)
        self._low_tracks = LowObstacleTracks(config.spots, self._bodies.number, config.residual.near_m)
        self._free_road = FreeRoadEvidence(config.free_road) if config.free_road else None
        self._looming = (
            LoomingConsistency(config.looming_consistency, judged_hz) if config.looming_consistency else None
        )
        self._refuted: Integers = np.empty(0, np.int64)  # identities of bodies in whose place the road was seen

    def triangulate(self, flow: Flow) -> Triangulation:
        """The points of the flow by their chained tracks, as if all of them stood."""
        age_s = flow.age_frames / self.rate_hz
        return triangulate(flow, self.camera, self.config.window_px, age_s, self.config.noise)

    def refined(self, flow: Flow, points: Triangulation, road: RoadEdges, match: Match) -> Triangulation:
        """The same, but those that may stand on the road by a match of what they show with the frame of their first
        sighting."""
        config = self.config.track_refinement
        if config is None:
            return points
        rows = candidates(points, road, self.camera, config)
        if not len(rows):
            return points
        return refined(flow, points, rows, match, config, partial(self._found, flow), self.camera)

    def _found(self, flow: Flow, rows: Integers, aside_px: Floats) -> Triangulation:
        """Some points of the flow, which were first seen aside of where it says, and found there from now."""
        some = flow.chosen(rows)
        some = replace(some, first_px=some.first_px + aside_px)
        return triangulate(some, self.camera, self.config.window_px, np.zeros(len(rows)), self.config.noise)

    def update(
        self,
        flow: Flow,
        road: RoadEdges,
        speed_mps: float,
        time_s: float,
        points: Triangulation | None = None,
        moving: Bools | None = None,
    ) -> Obstacles:
        """The standing bodies ahead after this frame, in the axes of the vehicle at `flow.pose`.

        `points` are of `triangulate`; those which are of bodies that `moving` (N,) are no static points.
        """
        if self._schedule.step():
            self._judge(flow, road, time_s, points, moving)
            self._tall, self._seen = self._bodies.told(flow.pose, road, self._low_tracks.bodies(flow.pose))
            self._seen_from = flow.pose
        return to_current_frame(self._seen, self._seen_from, flow.pose, speed_mps)

    @property
    def looks(self) -> bool:
        """Whether the next frame is one that `look` looks at."""
        return self._parallax.looks

    def low_sensing_range_m(self, speed_mps: float, speed_reference_mps: float) -> tuple[float, float]:
        """m ahead of the pose, up to which a low body on the road would be suspected by now at that speed; 0: nowhere.

        Then up to which it would be with a good view at the reference speed.
        """
        sight, sightings = self._parallax.sight, self._low_tracks.config.doubts
        good_m = sight.good_m(sight.needed_m(speed_reference_mps, sightings))
        return sight.distance_m(sight.needed_m(speed_mps, sightings)), good_m

    def tentative(self, pose: Floats) -> Obstacles:
        """What seems to lie low on the road and is not believed yet, in the axes of the vehicle at `pose`."""
        return self._low_tracks.tentative(pose)

    def look(
        self,
        image: Image | None,
        pose: Floats,
        road: RoadEdges,
        moving: Obstacles | None = None,
        speed_mps: float = 0.0,
    ) -> None:
        """Compare the road ahead in the frame (H, W) taken at `pose` with how it looked before, for `update` to tell.

        None for a frame that shows something else, as a wiper.
        What is no road counts where no body is known that hides it, now or, of those `moving`, when it was seen before.
        """
        known = None
        if image is not None and self._parallax.looks:
            tall = self._tall.chosen(~among(self._tall.identity, self._refuted))
            hiding = to_current_frame(tall, self._seen_from, pose, 0.0)
            if moving is not None and len(moving):
                hiding = hiding.concatenate(moving)
                if self.config.swept:
                    self._make_way(moving, pose, road)
            since_s = self.config.residual.baseline_m / max(speed_mps, SLOWEST_MPS)
            known = footprints(hiding, road, self.config.occlusion, since_s)
        spots = self._parallax.update(image, pose, known)
        if spots is None:
            return
        bodies = to_current_frame(self._seen, self._seen_from, pose, 0.0)
        if self._free_road is not None and self.config.free_road is not None:
            difference = self._parallax.difference_at(bodies)
            for index in self._free_road.record(bodies.identity, difference, pose[:2]):
                self.remove(bodies, index, pose, self.config.free_road.about_m)
        views = self._parallax.lenses_m
        seen = (self._in_sight(spot, views, bodies) for spot in spots if self._is_inside(spot, road))
        self._low_tracks.record([spot for spot in seen if spot is not None], pose)

    def _make_way(self, moving: Obstacles, pose: Floats, road: RoadEdges) -> None:
        """Forget what was thought to stand where a body drives now."""

        def stands(places_m: Floats) -> Bools:
            return ~driven_over(places_m, moving, road, self.config.occlusion)

        self._points.keep(stands(vehicle_from_world(self._points.place_m, pose)))
        self._low_tracks.keep(stands, pose)

    def refute(self, identity: Integers) -> None:
        """Bodies (N,) that a second look takes away hide nothing: one told too near hides the one that is there."""
        if self.config.rejected_hide_nothing:
            self._refuted = identity

    def _in_sight(self, spot: LowObservation, views: Iterable[Floats], bodies: Obstacles) -> LowObservation | None:
        """What is seen of a spot from each of the places (2,), past tall bodies; low ones hide what is just behind."""
        seen: LowObservation | None = spot
        hides = among(bodies.identity, self._tall.identity)
        near = self.config.low_occlusion
        hides |= bodies.forward_m > spot.forward_m - (near.behind_m if near else np.inf)
        bodies = bodies.chosen(hides & ~among(bodies.identity, self._refuted))
        for view in views:
            seen = seen and in_sight(seen, view, bodies, self.config.spots)
        return seen

    def remove(self, bodies: Obstacles, index: int, pose: Floats, about_m: tuple[float, float]) -> None:
        """Delete an obstacle of few points where the road is seen; its points elsewhere stay."""
        identity, (along_m, across_m) = int(bodies.identity[index]), about_m
        place = vehicle_from_world(self._points.place_m, pose)
        far = np.abs(place[:, 0] - bodies.forward_m[index]) > along_m
        far |= (place[:, 1] < bodies.left_m[index] - across_m) | (place[:, 1] > bodies.right_m[index] + across_m)
        if not self.is_well_supported(bodies)[index]:
            self._points.keep(far | (self._points.body != identity))
            self._low_tracks.forget(identity)

    def is_well_supported(self, bodies: Obstacles) -> Bools:
        """(K,) bodies that more points well above the road tell than err together: no look refutes these."""
        marks, config = self._points, self.config.support
        if config is None:
            return np.zeros(len(bodies), np.bool_)
        counts = np.minimum(config.known_m / marks.sigma_m, 1.0) * (marks.believed & ~marks.low)
        support = (marks.body == bodies.identity[:, None]) @ counts
        return np.asarray((support > config.points) & (bodies.identity >= 0), np.bool_)

    def is_verified(self, bodies: Obstacles) -> Bools:
        """(K,) bodies that no second look refutes: those told surely, and low ones that points and the comparison of
        the road tell of both. A painted line behind a pallet's foot looks like road all across it."""
        return self.is_well_supported(bodies) | among(bodies.identity, self._bodies.cross_confirmed)

    def _is_inside(self, spot: LowObservation, road: RoadEdges) -> bool:
        """Whether a spot's middle lies within the carriageway."""
        left, right = carriageway_offsets(np.array([spot.forward_m]), road)
        margin = self.config.spots.edge_m
        return bool(left[0] + margin < spot.middle_m < right[0] - margin)

    def _judge(
        self, flow: Flow, road: RoadEdges, time_s: float, points: Triangulation | None, moving: Bools | None
    ) -> None:
        """Count what the points of this frame tell."""
        if self._looming is not None:
            self._looming.record(flow)
        points = self.triangulate(flow) if points is None else points
        texture, _ = eigenvalues(flow.structure)
        above = self._above(flow, points, road)
        low = self._low(flow, points, texture, road) & ~above
        if moving is not None and moving.any():
            above, low = above & ~moving, low & ~moving
            self._points.keep(~among(self._points.identity, flow.identity[moving]))
        seen = self._sightings(flow, points, texture, road, above | low, low)
        self._points.record(seen, flow.identity[self._on_road(flow, points)], self._rules, time_s)
        self._forget(flow)

    def _above(self, flow: Flow, points: Triangulation, road: RoadEdges) -> Bools:
        """(N,) points that stand above the carriageway beyond doubt."""
        config = self.config
        depth = points.depth_m
        near_m = config.near_m
        if config.turned and abs(road.heading_rad) >= config.turned.angle_rad:
            near_m = config.turned.near_m
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = points.sigma_m / depth
            above = (depth > near_m) & (depth < config.far_m)
            above &= flow.age_frames >= frames(config.min_age_s, self.rate_hz)
            if config.travel:
                above &= np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T) > config.travel.share * depth
            above &= ratio < config.depth_ratio
            above &= (points.chi2 < config.chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
            above &= points.height_m > config.min_height_m + 2.0 * points.height_sigma_m
            above &= points.height_m < config.max_height_m + 2.0 * points.height_sigma_m
        chosen = np.flatnonzero(above)
        if not len(chosen):
            return above
        left, right = carriageway_offsets(self.camera.forward_m + depth[chosen], road)
        aside = points.right_m[chosen]
        inside = (aside > left + config.edge_margin_m) & (aside < right - config.edge_margin_m)
        if config.edge_lines is not None:
            strip = config.edge_lines
            sliding = near_edge_line(self.camera, flow.points_px[chosen], road, strip.inside_m, strip.outside_m)
            inside &= ~(sliding & ~is_corner(flow.structure[chosen], config.corner_texture, config.corner_ratio))
        chosen = chosen[inside]
        chosen = chosen[~self._is_far(flow, points, chosen)]
        confirmed = np.zeros(len(flow), np.bool_)
        if len(chosen):
            confirmed[chosen] = self._moves_so_now(flow, points, chosen)
        return confirmed

    def _is_far(self, flow: Flow, points: Triangulation, chosen: Integers) -> Bools:
        """Which of the chosen points are far off and move; only what is seen beside the far road may be."""
        far = np.zeros(len(chosen), np.bool_)
        high = np.flatnonzero(self._beside_far_road(flow.points_px[chosen]))
        if len(high) and self._looming is not None:
            far[high] = self._looming.keeps_together(chosen[high], 1.0 / points.depth_m[chosen[high]])
        return far

    def _beside_far_road(self, points_px: Floats) -> Bools:
        """(N,) pixels whose ray meets the road far away, if at all."""
        far: Bools = below_horizon(self.camera, points_px) * self.config.foot_m < self.camera.height_m
        return far

    def _low(self, flow: Flow, points: Triangulation, texture: Floats, road: RoadEdges) -> Bools:
        """(N,) points that seem to stand a hand's breadth above the carriageway, off its lines."""
        if self.config.low_obstacles is None:
            return np.zeros(len(flow), np.bool_)
        low = is_low(points, flow.age_frames / self.rate_hz, texture, self.config.low_obstacles)
        chosen = np.flatnonzero(low)
        if not len(chosen):
            return low
        chosen = chosen[self._off_lines(flow.points_px[chosen], road)]
        confirmed = np.zeros(len(flow), np.bool_)
        if len(chosen):
            confirmed[chosen] = self._moves_so_now(flow, points, chosen)
        return confirmed

    def _off_lines(self, points_px: Floats, road: RoadEdges) -> Bools:
        """(N,) pixels whose place on the flat road is within the carriageway and on no painted line."""
        if self.config.low_obstacles is None:
            return np.ones(len(points_px), np.bool_)
        return off_lines(self.camera, ground_from_pixels(self.camera, points_px), road, self.config.low_obstacles)

    def _moves_so_now(self, flow: Flow, points: Triangulation, chosen: Integers) -> Bools:
        """Which of the chosen points moved in the last window as the place found from the whole track does.

        A track does not that has slipped on to something else, or is swept along by the edge of a nearer body.
        """
        config = self.config.recent_motion
        if config is None:
            return np.ones(len(chosen), np.bool_)
        place = np.stack(
            [self.camera.forward_m + points.depth_m[chosen], points.right_m[chosen], points.height_m[chosen]], axis=1
        )
        before = flow.points_px[chosen] - flow.displacement_px[chosen]
        expected = past_image(self.camera, place, flow.past_pose[chosen], flow.pose)
        error = np.hypot(*(before - expected).T)
        length = np.hypot(*flow.displacement_px[chosen].T)
        confirmed: Bools = error < config.error_px + config.ratio * length
        return confirmed

    def _on_road(self, flow: Flow, points: Triangulation) -> Bools:
        """(N,) points that lie on the road beyond doubt, if there are landmarks: the only evidence that clears one."""
        if not len(self._points) or not self.config.road_points:
            return np.zeros(len(flow), np.bool_)
        low = among(flow.identity, self._points.identity[self._points.low])
        config = self.config.low_obstacles
        least = np.where(low, config.min_height_m if config else np.inf, self.config.min_height_m)
        with np.errstate(invalid="ignore"):
            return (points.chi2_ground < self.config.chi2_limit) & (
                points.height_m + 2.0 * points.height_sigma_m < least
            )

    def _sightings(
        self, flow: Flow, points: Triangulation, texture: Floats, road: RoadEdges, above: Bools, low: Bools
    ) -> Sightings:
        forward = self.camera.forward_m + points.depth_m[above]
        place = world_from_vehicle(np.stack([forward, points.right_m[above]], axis=1), flow.pose)
        seed_weight = self._founding(flow, points, texture, road, above)
        seed_weight[low[above]] = 0.0
        sigma, depth, height = points.sigma_m[above], points.depth_m[above], points.height_m[above]
        bearing = points.right_m[above] / depth
        sight = flow.pose[2] + np.arctan(bearing)
        margin = points.chi2_ground[above] - points.chi2[above]
        return Sightings(
            flow.identity[above],
            place,
            sigma,
            sight,
            depth,
            height,
            seed_weight,
            low[above],
            margin,
            texture[above],
        )

    def _founding(self, flow: Flow, points: Triangulation, texture: Floats, road: RoadEdges, above: Bools) -> Floats:
        """(M,) from 0 to 1, how far each of the points `above` (N,) may found a body."""
        config, points_px, structure = self.config, flow.points_px[above], flow.structure[above]
        seed_weight: Floats = np.ones(len(points_px))
        if config.far_road:
            corner = is_corner(structure, config.corner_texture, config.corner_ratio)
            seed_weight = np.where(self._beside_far_road(points_px), config.far_road.share * corner, 1.0)
        if config.seed_texture:
            seed_weight[texture[above] <= config.seed_texture.least] = 0.0
        if config.dash_seed:
            far = points.depth_m[above] > config.dash_seed.far_m
            slides = np.flatnonzero(far & (points.height_m[above] < config.dash_seed.height_m))
            if len(slides):
                seed_weight[slides] *= self._off_lines(points_px[slides], road)
        return seed_weight

    def _forget(self, flow: Flow) -> None:
        marks = self._points
        if not len(marks):
            return
        parts = among(marks.identity, self._bodies.parts)
        ahead = vehicle_from_world(marks.place_m, flow.pose)[:, 0] > -self.config.behind_m
        wanted = ((marks.believed & ~parts) | followed(marks.identity, flow)) & ahead & (marks.hits > 0)
        wanted &= ~among(marks.identity, self._bodies.gone)
        if not wanted.all():
            marks.keep(wanted)
