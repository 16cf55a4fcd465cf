"""A cluster of points in the car's path that grows fast raises an alarm, whatever it is.

The rate of expansion is the inverse time to contact, for static and moving objects alike (Lee, Perception 5, 1976). An
object not yet classified is met at its due time if it is taken to stand there.
"""

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.config import CollisionAlarmConfig
from vpf_sim.perception.obstacles.prediction import none, to_current_frame
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges


class CollisionAlarm:
    """Finds objects that are met soon, and keeps them for a moment without points."""

    def __init__(self, camera: Camera, config: CollisionAlarmConfig, look_s: float) -> None:
        self.camera, self.config, self.look_s = camera, config, look_s
        self._alarm_s = 0.0  # for how long; negative: since when not
        self._obstacle: Obstacles | None = None
        self._pose: Floats = np.zeros(3)  # of it

    def look(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float, free: Bools) -> None:
        """Use the points of one frame that are `free` (N,): of no known moving obstacle."""
        found = self._cluster(self._alarming(flow, points, road, speed_mps) & free, flow, points)
        if found is not None:
            self._alarm_s = max(self._alarm_s, 0.0) + self.look_s
            self._obstacle, self._pose = found, flow.pose
        else:
            self._alarm_s = min(self._alarm_s, 0.0) - self.look_s if self.alarms else 0.0
        if self._alarm_s < -self.config.hold_s:
            self._obstacle, self._alarm_s = None, 0.0

    @property
    def alarms(self) -> bool:
        """Whether there is an alarm, or was a moment ago."""
        return self._obstacle is not None and (self._alarm_s >= self.config.after_s or self._alarm_s < 0.0)

    def obstacles(self, pose: Floats, speed_mps: float, known: Obstacles) -> Obstacles:
        """None or one: what is met soon and is not known, in vehicle axes at `pose`, as if it stood."""
        if self._obstacle is None or not self.alarms:
            return none()
        found = to_current_frame(self._obstacle, self._pose, pose, speed_mps)
        place, left, right = (float(part[0]) for part in (found.forward_m, found.left_m, found.right_m))
        return none() if place <= 0.0 or self._is_known(known, place, left, right) else found

    def _is_known(self, known: Obstacles, forward_m: float, left_m: float, right_m: float) -> bool:
        """Whether a known obstacle stands before it in the line of sight, or no farther behind than it may err."""
        nearest = np.maximum(known.forward_m, 1.0)
        margin = self.config.half_width_m
        covers = (known.left_m - margin) / nearest < right_m / forward_m
        covers &= (known.right_m + margin) / nearest > left_m / forward_m
        near = (known.forward_m > 0.0) & (known.forward_m < (1.0 + 2.0 * self.config.agree_ratio) * forward_m)
        return bool(np.any(covers & near))

    def _alarming(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float) -> Bools:
        """(N,) points that are met within the bound, in the car's path."""
        config, camera = self.config, self.camera
        x = (flow.points_px[:, 0] - camera.cx_px) / camera.fx_px
        y = (flow.points_px[:, 1] - camera.cy_px) / camera.fy_px
        drop = np.cos(camera.pitch_rad) * y + np.sin(camera.pitch_rad)
        travel = np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T)
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = 1.0 / points.inverse_per_m
            aside = x * depth - np.tan(road.heading_rad) * depth - 0.5 * road.curvature_per_m * depth**2
            soon = points.inverse_per_m - 2.0 * points.inverse_sigma_per_m > 1.0 / (
                config.bound_s * max(speed_mps, 0.5)
            )
            soon &= (depth > config.least_depth_m) & (np.abs(aside) < config.half_width_m)
            soon &= (drop > config.least_drop) & (camera.height_m - drop * depth < config.ceiling_m)
            soon &= points.chi2 < np.maximum(config.chi2_limit, config.chi2_ratio * points.chi2_ground)
            soon &= points.chi2_ground - points.chi2 > config.chi2_margin
        alarming: Bools = soon & (travel > config.least_baseline_m) & ~flow.stuck
        return alarming

    def _cluster(self, alarming: Bools, flow: Flow, points: Triangulation) -> Obstacles | None:
        """The obstacle of most of the alarming points, if these agree and it is large enough."""
        config = self.config
        chosen = np.flatnonzero(alarming)
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
        return Obstacles(forward, left, right, sigma_m, ttc, np.array([np.iinfo(np.int64).max]))
