"""The safety net: something in our way that grows fast, whatever it is.

The rate at which a cluster of points expands gives the time until they are met, 1 / (w v) with w their inverse depth as
standing points, for bodies that stand and for bodies that move (Lee, Perception 5, 1976). So what has not yet been told
to be the one or the other is met at its due time if it is taken to stand there.
"""

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.config import CollisionAlarmConfig
from vpf_sim.perception.obstacles.extent import none, to_current_frame
from vpf_sim.perception.obstacles.point_hypotheses import Integers
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges

IDENTITY = np.iinfo(np.int64).max


class CollisionAlarm:
    """Watches for what is met soon; keeps its place while it is not seen for a moment."""

    def __init__(self, camera: Camera, config: CollisionAlarmConfig, look_s: float) -> None:
        self.camera, self.config, self.look_s = camera, config, look_s
        self._alarm_s = 0.0  # for how long; negative: since when not
        self._body: Obstacles | None = None
        self._seen_from: Floats = np.zeros(3)

    def look(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float, free: Bools) -> None:
        """One look, at those of the points that are `free` (N,): of no body that is known to move."""
        found = self._cluster(self._alarming(flow, points, road, speed_mps) & free, flow, points)
        if found is not None:
            self._alarm_s = max(self._alarm_s, 0.0) + self.look_s
            self._body, self._seen_from = found, flow.pose
        else:
            self._alarm_s = min(self._alarm_s, 0.0) - self.look_s if self.alarms else 0.0
        if self._alarm_s < -self.config.hold_s:
            self._body, self._alarm_s = None, 0.0

    @property
    def alarms(self) -> bool:
        """Whether there is an alarm, or was a moment ago."""
        return self._body is not None and (self._alarm_s >= self.config.after_s or self._alarm_s < 0.0)

    def obstacles(self, pose: Floats, speed_mps: float, known: Obstacles) -> Obstacles:
        """None or one: what is met soon and is not known, in the axes of the vehicle at `pose`, as if it stood."""
        if self._body is None or not self.alarms:
            return none()
        body = to_current_frame(self._body, self._seen_from, pose, speed_mps)
        place, left, right = (float(part[0]) for part in (body.forward_m, body.left_m, body.right_m))
        return none() if place <= 0.0 or self._is_known(known, place, left, right) else body

    def _is_known(self, known: Obstacles, forward_m: float, left_m: float, right_m: float) -> bool:
        """Whether one of the bodies stands before it in the line of sight, or no farther behind than it may err."""
        nearest = np.maximum(known.forward_m, 1.0)
        margin = self.config.half_way_m
        covers = (known.left_m - margin) / nearest < right_m / forward_m
        covers &= (known.right_m + margin) / nearest > left_m / forward_m
        near = (known.forward_m > 0.0) & (known.forward_m < (1.0 + 2.0 * self.config.agree_ratio) * forward_m)
        return bool(np.any(covers & near))

    def _alarming(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float) -> Bools:
        """(N,) points that are met within the bound, in our way."""
        config, camera = self.config, self.camera
        x = (flow.points_px[:, 0] - camera.cx_px) / camera.fx_px
        y = (flow.points_px[:, 1] - camera.cy_px) / camera.fy_px
        drop = np.cos(camera.pitch_rad) * y + np.sin(camera.pitch_rad)
        way = np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T)
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = 1.0 / points.inverse_per_m
            aside = x * depth - np.tan(road.heading_rad) * depth - 0.5 * road.curvature_per_m * depth**2
            soon = points.inverse_per_m - 2.0 * points.inverse_sigma_per_m > 1.0 / (
                config.bound_s * max(speed_mps, 0.5)
            )
            soon &= (depth > config.least_depth_m) & (np.abs(aside) < config.half_way_m)
            soon &= (drop > config.least_drop) & (camera.height_m - drop * depth < config.ceiling_m)
            soon &= points.chi2 < np.maximum(config.chi2_limit, config.chi2_ratio * points.chi2_ground)
            soon &= points.chi2_ground - points.chi2 > config.chi2_margin
        alarming: Bools = soon & (way > config.least_baseline_m) & ~flow.stuck
        return alarming

    def _cluster(self, alarming: Bools, flow: Flow, points: Triangulation) -> Obstacles | None:
        """The body that most of the alarming points make, if they agree and are a body's in size."""
        config = self.config
        chosen: Integers = np.flatnonzero(alarming).astype(np.int64)
        if len(chosen) < config.least_points:
            return None
        inverse = points.inverse_per_m[chosen]
        middle = median(inverse)
        agrees = np.abs(inverse - middle) < config.agree_ratio * middle
        if np.count_nonzero(agrees) < max(config.least_points, config.least_share * len(chosen)):
            return None
        pixels = flow.points_px[chosen[agrees]]
        across = (pixels[:, 0] - self.camera.cx_px) / (self.camera.fx_px * middle)
        height = pixels[:, 1] / (self.camera.fy_px * middle)
        if np.ptp(across) < config.least_width_m or np.ptp(height) < config.least_height_m:
            return None
        face, sigma = self.camera.forward_m + 1.0 / middle, config.agree_ratio / middle
        forward, left, right, sigma_m, ttc = np.array([[face], [across.min()], [across.max()], [sigma], [np.inf]])
        return Obstacles(forward, left, right, sigma_m, ttc, np.full(1, IDENTITY))
