"""Geometry of the obstacles of one step: the way to each, the gaps beside it, and whether it counts."""

from dataclasses import replace
from math import inf, sqrt, tan

import numpy as np

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.types import Bools, Floats

FREE_M = 1e-6  # an obstacle does not occupy its own side


class ObstacleGeometry:
    """K obstacles in lane coordinates and the car; a y is that of its middle."""

    def __init__(self, obstacles: LaneObstacles, config: LanePlannerConfig, setup: DriverSetup) -> None:
        vehicle = setup.vehicle
        self.obstacles, self._config, self._clearance = obstacles, config.obstacles, config.clearance
        self._half_width_m, self._half_length_m = 0.5 * vehicle.width_m, 0.5 * vehicle.length_m
        self._l_r_m, self._speed_reference_mps = vehicle.l_r_m, setup.speed_reference_mps
        self.way_m: Floats = obstacles.along_m - self._half_length_m  # (K,) from the bumper to each face
        self.moves: Bools = obstacles.speed_mps > 0.0  # (K,)
        self.length_m = self._lengths()  # (K,) from each face to its end, at least
        weight = self._weights()  # (K,) 0 .. 1
        self.present: Bools = weight > 0.0  # (K,) the others count for the choice of a side at most
        self.is_static: Bools = self.present & ~self.moves  # (K,)
        ahead = ~self.moves & (self.way_m > 0.0)
        self.in_row: Bools = self._same_row() & ahead & ahead[:, None]  # (K, K) static, ahead and in one row
        # (K,) w of the lateral cost. The side is chosen for a row: all of it counts as soon as the first of it does.
        self.weight: Floats = np.maximum(weight, (weight * self.in_row).max(axis=1, initial=0.0))

    def __len__(self) -> int:
        return len(self.obstacles)

    def gap(self, y_m: Floats) -> Floats:
        """(K, G) m between the car at y (G,) and each obstacle, across the road; < 0 where they overlap."""
        return self._gap(y_m, self.obstacles.left_m[:, None], self.obstacles.right_m[:, None])

    def overlap(self, y_m: float, clearance_m: float) -> Floats:
        """(K,) m by which the car at y, widened by a clearance, overlaps each obstacle; <= 0: none."""
        overlap: Floats = clearance_m - self._gap(y_m, self.obstacles.left_m, self.obstacles.right_m)
        return overlap

    def _gap(self, y_m: Floats | float, left_m: Floats, right_m: Floats) -> Floats:
        """m between the car at y and obstacles from left to right."""
        gap: Floats = np.maximum(y_m - self._half_width_m - right_m, left_m - y_m - self._half_width_m)
        return gap

    def hinders(self, y_m: float) -> Bools:
        """(K,) which obstacles ahead are nearer to the car at y than the clearance wanted."""
        hinders: Bools = self.present & (self.way_m > 0.0) & (self.overlap(y_m, self._clearance.wanted_m) > 0.0)
        return hinders

    def beside(self, some: Bools) -> Bools:
        """(K,) which obstacles ahead are in a row with some (K,) of them."""
        beside: Bools = np.any(self.in_row & some, axis=1)
        return beside

    def blocked_rows(self, y_m: float) -> Bools:
        """(K,) which obstacles ahead are in a row that leaves the car at y no way through.

        The first of a row must leave the least clearance, those behind it the one of full speed: their sides have
        larger errors, and from within the row there is no way to another gap.
        """
        nearer = self.way_m[:, None] < self.way_m
        behind = (self.in_row & nearer).any(axis=0)
        shuts = self.overlap(y_m, 0.0) > -np.where(behind, self._clearance.full_speed_m, self._clearance.least_m)
        return self.beside(shuts & self.is_static)

    def shift(self, y_m: float, goal_m: float, clearance_m: Floats | float) -> Floats:
        """(K,) m from y towards a goal across the road until the car is clear of each; <= 0 where it is."""
        margin = self._half_width_m + clearance_m
        least, most = self.obstacles.left_m - margin, self.obstacles.right_m + margin
        if goal_m >= y_m:
            return np.where(goal_m > least, most - y_m, 0.0)
        return np.where(goal_m < most, y_m - least, 0.0)

    def nearer_side(self, lane: Lane) -> Floats:
        """(K,) m to the nearer side of each obstacle in the way that is on the road and free; else 0."""
        margin = self._half_width_m + self._clearance.edge_m
        here, aside = lane.y_m, self._half_width_m + self._clearance.least_m
        least, most = self.obstacles.left_m - aside, self.obstacles.right_m + aside  # of the places that each takes
        sides = np.concatenate([least, most])
        taken = (least[:, None] < sides - FREE_M) & (sides + FREE_M < most[:, None]) & self.is_static[:, None]
        off = (sides < lane.left_m + margin) | (sides > lane.right_m - margin) | np.any(taken, axis=0)
        free = np.where(off, np.inf, np.abs(sides - here))
        in_way = (least < here) & (here < most)
        nearer = float(free.min(initial=np.inf))
        return np.where(in_way & (nearer < np.inf), nearer, 0.0)

    def between(self, lane: Lane, path_m: float) -> Lane:
        """The lane between the obstacles that the car passes, instead of between the road's edges.

        An obstacle that is passed next counts, too, unless the car or its path, now at `path_m`, leads into it: a car
        that turns towards it reaches it with a corner first.
        """
        if self._config.passage_m is None:
            return lane
        passing = (self.way_m < self._config.passage_m) & (
            self.obstacles.along_m + self.length_m > -self._half_length_m
        )
        if not passing.any():
            return lane
        left_m, right_m = self.obstacles.left_m, self.obstacles.right_m
        beside_car = self.way_m < 0.0
        least = np.where(beside_car, lane.y_m, min(lane.y_m, path_m) - self._half_width_m)
        most = np.where(beside_car, lane.y_m, max(lane.y_m, path_m) + self._half_width_m)
        right = left_m.min(where=passing & (left_m > most), initial=lane.right_m)
        left = right_m.max(where=passing & (right_m < least), initial=lane.left_m)
        return replace(lane, right_m=float(right), left_m=float(left))

    def side_slopes(self, path_m: float, slope: float) -> tuple[float, float]:
        """Largest slopes of the path to the left and right with which no side of the car swings into an obstacle.

        The path of the rear axle is at `path_m` with `slope`. Ahead of that axle a side swings the way the car turns:
        to a corner at (x, y) from there, the side of a car with half the width b, turned by a, has the gap
        y - x tan a - b / cos a across the road. It keeps the least clearance, or what is left of it.
        """
        if self._config.corner_swing is None:
            return inf, inf
        ahead = self.obstacles.along_m + self._l_r_m  # x
        beside_car = (self.way_m < 0.0) & (ahead > 0.0)
        if not beside_car.any():
            return inf, inf
        reach, on_right = ahead[beside_car], self.obstacles.middle_m[beside_car] > path_m + slope * ahead[beside_car]
        right = self._turn_slope(reach[on_right], self.obstacles.left_m[beside_car][on_right] - path_m, slope)
        left = self._turn_slope(reach[~on_right], path_m - self.obstacles.right_m[beside_car][~on_right], -slope)
        return left, right

    def _turn_slope(self, ahead_m: Floats, aside_m: Floats, slope: float) -> float:
        """Largest slope towards corners (K,) so far ahead of the rear axle and aside of its path."""
        cosine = sqrt(1.0 - slope**2)
        gap = aside_m - (ahead_m * slope + self._half_width_m) / cosine
        room = aside_m - np.minimum(gap, self._clearance.least_m)
        turned = np.arccos(np.minimum(self._half_width_m / np.hypot(room, ahead_m), 1.0)) - np.arctan2(ahead_m, room)
        return float(np.sin(turned).min(initial=inf))

    def gaps(self, lane: Lane, y_m: float, beside_m: float) -> Floats:
        """(K,) m, width of the gap at y between the edges and the obstacles met with each one.

        inf for an obstacle that is not ahead within `beside_m` of the car's side.
        """
        static = self.is_static & (self.way_m > 0.0)
        row = static & (np.abs(self.way_m - self.way_m[:, None]) < self._config.row_depth_m)
        beyond = self.obstacles.middle_m > y_m
        right = np.where(row & beyond, self.obstacles.left_m, lane.right_m).min(axis=1, initial=lane.right_m)
        left = np.where(row & ~beyond, self.obstacles.right_m, lane.left_m).max(axis=1, initial=lane.left_m)
        bounds = static & (self.overlap(y_m, beside_m) > 0.0)
        return np.where(bounds, right - left, np.inf)

    def kept_beside(self, y_m: float, minimum_m: float) -> float:
        """The minimum, no nearer to moving obstacles that a path at y passes than the clearance wanted.

        Their sides have large errors, and an obstacle farther ahead must not push the path towards them.
        """
        if self._config.keep_aside_m is None:
            return minimum_m
        passing = self.present & self.moves & (self.way_m < self._config.keep_aside_m)
        if not passing.any():
            return minimum_m
        margin = self._half_width_m + self._clearance.wanted_m
        middle = self.obstacles.middle_m
        least = float((self.obstacles.right_m + margin).max(where=passing & (middle < y_m), initial=-inf))
        most = float((self.obstacles.left_m - margin).min(where=passing & (middle > y_m), initial=inf))
        least, most = min(least, y_m), max(most, y_m)  # the path is not pushed away: the cost does that
        return min(max(minimum_m, least), most)

    def met(self, lane: Lane) -> Floats:
        """(K,) m until the front of the car meets each obstacle if it goes straight on; inf where never.

        As if all were static: for one that moves on, it is less than it takes.
        """
        slope = -tan(lane.heading_rad)
        y = lane.y_m + slope * self.obstacles.along_m  # of our front where it is beside the face
        beyond = np.maximum(self.obstacles.left_m - y, y - self.obstacles.right_m) - self._half_width_m
        nears = (self.obstacles.left_m + self.obstacles.right_m - 2.0 * y) * slope > 0.0
        further = np.maximum(beyond, 0.0) / max(abs(slope), FREE_M)
        meets = (beyond <= 0.0) | (nears & (further < self.length_m))
        return np.where(meets & (self.way_m > 0.0), self.way_m + further, np.inf)

    def _same_row(self) -> Bools:
        """(K, K) which obstacles are in one row: the face of one not far behind the rear of the other.

        A pedestrian may stand beside the rear of a truck.
        """
        behind = self.obstacles.along_m[None] - self.obstacles.along_m[:, None]
        reach = self.length_m + self._config.row_gap_m
        row: Bools = np.where(behind > 0.0, behind < reach[:, None], -behind < reach[None])
        return row

    def _lengths(self) -> Floats:
        """(K,) m; a wide obstacle may be a truck or a barrier."""
        config = self._config
        long = self.moves | (self.obstacles.width_m > config.truck_width_m)
        length: Floats = np.maximum(np.where(long, config.long_m, config.length_m), self.obstacles.length_m)
        return length

    def _weights(self) -> Floats:
        """(K,) 0 .. 1 by the distance; 0 for obstacles that have been passed or are faster."""
        config, speed = self._config, self.obstacles.speed_mps
        nears = (self._visible() - self.way_m) / (config.visible_m - config.full_m)
        weight = np.minimum(np.maximum(nears, 0.0), 1.0)
        faster = speed - self._speed_reference_mps
        runs = (faster > -config.slower_mps) & (self.way_m > config.beside_m)
        catches_up = np.maximum(faster, 0.0) * (config.catch_up_s or 0.0)
        passed = self.obstacles.along_m + self.length_m + catches_up < -self._half_length_m
        return np.where(passed | runs, 0.0, weight)

    def _visible(self) -> Floats:
        """(K,) m from bumper to face, from which on each obstacle counts."""
        speed, visible_m, meet = self.obstacles.speed_mps, self._config.visible_m, self._config.meet
        if meet is None:
            return np.full(len(self), visible_m)
        closing = np.maximum(self._speed_reference_mps - speed, 0.0)
        return np.where(self.moves, np.minimum(meet.gap_m + meet.time_s * closing, visible_m), visible_m)
