"""The lateral cost: of target, road and obstacles, across the lane, and its minimum.

All three are functions of y, the position across the road (`vpf_sim.planning.lane.frame`), in the same units:

    U(y) = k y^2                                                            target: the middle of the own lane
         + h_w ((1 - g_r(y) / d_w)^2 + (1 - g_l(y) / d_w)^2), each for g < d_w    road: g is the gap to the edge
         + max over obstacles of w(t) {h_o + s_o (c - d) for d < c, else h_t e^(-(d - c) / d_t)}
           and, for d below the least clearance d_n, h_n (1 - d / d_n), h_n at most
         + max over rows of w(t) h_r (1 - b / b_r), in a gap b < b_r that is wide enough

d is the lateral gap between the car and an obstacle, negative where they overlap, c the clearance wanted, and w(t)
fades in with the distance t to the obstacle, or to the first of its row. Obstacles take the maximum, not the sum, so
that many points of one obstacle weigh as one.

The paper follows the local gradient. Here the car goes to the global minimum, since dead ahead of an obstacle the
gradient vanishes and the side would be left to chance. A decision is kept by costs on top: memory,
latch and what cannot be reached. Places beyond an edge are excluded: the car stops rather than go there. A tie goes to
the minimum that is nearer to the last one, then to the side with more road, then to the left.
"""

from dataclasses import dataclass
from math import tan

import numpy as np

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.gap_cost import narrowness
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.lane_settings import BesideConfig, LanePlannerConfig, LatchConfig
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.stopping_distance import stopping_way
from vpf_sim.types import Bools, Floats

TIE = 1e-9
EXCLUDED = 1e3  # more than any obstacle, side or memory costs


@dataclass(frozen=True, slots=True)
class CostProfile:
    """U on the grid, in its three parts, and its minimum."""

    y_m: Floats  # (G,)
    target: Floats  # (G,)
    road: Floats  # (G,)
    obstacle: Floats  # (G,)
    minimum_m: float

    @property
    def total(self) -> Floats:
        return self.target + self.road + self.obstacle

    def slope(self, y_m: float) -> Floats:
        """(3,) dU / dy at y of target, road and obstacle."""
        index = min(max(int(self.y_m.searchsorted(y_m)), 1), len(self.y_m) - 1)
        rise = np.array([part[index] - part[index - 1] for part in (self.target, self.road, self.obstacle)])
        slope: Floats = rise / (self.y_m[index] - self.y_m[index - 1])
        return slope


class LateralCost:
    """Adds up the costs of each frame and finds their minimum; remembers the last one."""

    def __init__(self, planner: LanePlannerConfig, setup: DriverSetup, kinematics: KinematicLimits) -> None:
        config = self._config = planner.lateral_cost
        self._clearance, self._braking, self._kinematics = planner.clearance, planner.braking, kinematics
        self._speed_reference_mps, self._half_width_m = setup.speed_reference_mps, 0.5 * setup.vehicle.width_m
        half = np.arange(1, round(config.reach_m / config.spacing_m) + 1) * config.spacing_m
        self._y_m: Floats = np.concatenate([-half[::-1], [0.0], half])  # symmetric to the last bit
        self._target: Floats = config.target_per_m2 * self._y_m**2
        self._nothing: Floats = np.zeros(len(self._y_m))
        self._nothing.flags.writeable = False  # shared by all steps without an obstacle
        touching = config.obstacle_height + config.obstacle_slope_per_m * self._clearance.wanted_m
        self._touching = touching + config.narrow_height  # U at no gap
        self._last_m: float | None = None

    def update(self, lane: Lane, geometry: ObstacleGeometry, speed_mps: float = 0.0) -> CostProfile:
        """The cost about the vehicle now."""
        gaps = self._edge_gaps(lane)
        road = self._road(*gaps)
        blocked = self._beyond(*gaps)
        obstacle = rows = self._nothing
        if len(geometry):
            obstacle, blocked = self._obstacle(geometry), blocked + self._unreached(geometry, lane)
            higher = self._config.unstopped_share
            if higher is not None and not ((obstacle < self._touching) & (blocked == 0.0)).any():
                obstacle = self._obstacle(geometry, self._unstopped(higher, geometry, speed_mps)[:, None])
            rows = self._rows(geometry, lane)
            obstacle = obstacle + rows
        kept = self._target + road + obstacle + blocked
        if self._last_m is not None:
            kept = kept + self._memory(self._last_m, geometry, lane, rows)
        self._last_m = self._minimum(kept, lane)
        return CostProfile(self._y_m, self._target, road, obstacle, self._last_m)

    def keep(self, y_m: float) -> None:
        """Set the last minimum: the car got there by other means."""
        self._last_m = y_m

    def _road(self, right_m: Floats, left_m: Floats) -> Floats:
        reach = self._config.wall_reach_m
        wall: Floats = np.maximum(1.0 - right_m / reach, 0.0) ** 2 + np.maximum(1.0 - left_m / reach, 0.0) ** 2
        return self._config.wall_height * wall

    def _beyond(self, right_m: Floats, left_m: Floats) -> Floats:
        """(G,) the cost that keeps the minimum on the road."""
        return np.where(np.minimum(right_m, left_m) < self._clearance.edge_m, EXCLUDED, 0.0)

    def _edge_gaps(self, lane: Lane) -> tuple[Floats, Floats]:
        """(G,) m between the car at y and the right and the left edge."""
        right: Floats = lane.right_m - self._y_m - self._half_width_m
        left: Floats = self._y_m - lane.left_m - self._half_width_m
        return right, left

    def _obstacle(self, geometry: ObstacleGeometry, higher: Floats | float = 0.0) -> Floats:
        config = self._config
        if not geometry.weight.any():
            return self._nothing
        wanted_m, least_m = self._clearance.wanted_m, self._clearance.least_m
        lacking = wanted_m - geometry.gap(self._y_m)
        inside = config.obstacle_height + config.obstacle_slope_per_m * lacking
        narrow = 1.0 - np.minimum(np.maximum((wanted_m - lacking) / least_m, 0.0), 1.0)
        inside = (inside + config.narrow_height * narrow) * (1.0 + higher)
        outside: Floats = self._nothing
        if config.tail is not None:
            outside = config.tail.height * np.exp(np.minimum(lacking, 0.0) / config.tail.decay_m)
        each = geometry.weight[:, None] * np.where(lacking > 0.0, inside, outside)
        worst: Floats = each.max(axis=0)
        return worst

    def _rows(self, geometry: ObstacleGeometry, lane: Lane) -> Floats:
        """(G,) the cost of narrow gaps between two obstacles of a row, or one and an edge."""
        config = self._config.row
        if config is None:
            return self._nothing
        widths_m = 2.0 * (self._half_width_m + self._clearance.wanted_m), config.gap_m
        narrow = narrowness(geometry.obstacles, geometry.in_row, geometry.weight, lane, self._y_m, widths_m)
        return config.height * narrow

    def _unstopped(self, share: float, geometry: ObstacleGeometry, speed_mps: float) -> Floats:
        """(K,) the share by which obstacles that are too near for a stop cost more."""
        way = geometry.way_m
        closing = np.maximum(speed_mps - geometry.obstacles.speed_mps, 0.0)
        stop = stopping_way(closing, self._braking.emergency_mps2, self._braking.reaction_s)
        return share * np.where(way > 0.0, np.clip(stop - way, 0.0, 1.0), 0.0)

    def _memory(self, last_m: float, geometry: ObstacleGeometry, lane: Lane, rows: Floats) -> Floats:
        """(G,) what keeps the decision: the cost of leaving the last minimum, and of changing sides."""
        memory, config = self._nothing, self._config.memory
        if config is not None:
            away = np.abs(self._y_m - last_m) / config.reach_m
            memory = config.height * np.minimum(np.maximum(away - 1.0, 0.0), 1.0)
        latch, beside = self._config.latch, self._config.beside
        if not len(geometry) or (latch is None and beside is None):
            return memory
        near, kept = self._latch(latch, last_m, geometry, lane, rows)
        if not near.any():
            return memory
        chosen_m, middle = np.full(len(geometry), last_m), geometry.obstacles.middle_m
        if beside is not None:
            beside_car = self._beside_car(beside, geometry, lane)
            chosen_m, kept = np.where(beside_car, lane.y_m, last_m), np.where(beside_car, beside.height, kept)
        height = np.where(near, kept, 0.0)
        other = (self._y_m[None] - middle[:, None]) * np.sign(chosen_m - middle)[:, None] < 0.0
        latched: Floats = memory + (other * height[:, None]).max(axis=0)
        return latched

    def _latch(
        self, config: LatchConfig | None, last_m: float, geometry: ObstacleGeometry, lane: Lane, rows: Floats
    ) -> tuple[Bools, Floats]:
        """(K,) which obstacles are near enough to have a side, and the cost of changing it."""
        if config is None:
            return geometry.present, np.zeros(len(geometry))
        middle, turned = geometry.obstacles.middle_m, np.zeros(len(geometry), np.bool_)
        if config.turned_rad is not None:
            is_turned = abs(lane.heading_rad) > config.turned_rad
            turned = is_turned & (-lane.heading_rad * (last_m - middle) > 0.0) & ~geometry.moves
        kept = np.full(len(geometry), config.height)
        plan = config.narrow_plan
        if plan is not None:
            goes = turned | (abs(lane.y_m - last_m) < plan.near_m)
            wide = np.interp(last_m, self._y_m, rows) == 0.0
            kept = np.where(goes | wide, config.height, plan.height)
        if config.overlap_m is not None:  # its side is reported no better than that
            overlap = geometry.overlap(last_m, 0.0)
            sided = np.minimum(np.maximum(1.0 - overlap / config.overlap_m, 0.0), 1.0)
            kept = np.where(turned, kept, kept * sided)
        return geometry.present & ((geometry.way_m < config.ahead_m) | turned), kept

    def _beside_car(self, config: BesideConfig, geometry: ObstacleGeometry, lane: Lane) -> Bools:
        """(K,) which obstacles are beside the car, or move and would be reached while it changes sides behind them."""
        way, crossing = geometry.way_m, config.crossing
        if crossing is None:
            return way < 0.0
        closing = np.maximum(self._speed_reference_mps - geometry.obstacles.speed_mps, 0.0)
        room = crossing.gap_m + crossing.time_s * closing
        aside = np.abs(lane.y_m - geometry.obstacles.middle_m) > crossing.behind_m
        return (way < np.where(geometry.moves, room, 0.0)) & (aside | (way < crossing.gap_m))

    def _unreached(self, geometry: ObstacleGeometry, lane: Lane) -> Floats:
        """(G,) the cost of places beyond static obstacles beside the car, or too near to get past them in time."""
        if not geometry.is_static.any():
            return self._nothing
        obstacles, here = geometry.obstacles, lane.y_m
        least, most = obstacles.left_m - self._half_width_m, obstacles.right_m + self._half_width_m  # overlapping
        taken = self._nothing
        if self._config.beside is not None:
            beside_car = geometry.is_static & (geometry.way_m <= 0.0)
            from_m = least.min(where=beside_car & (here <= least), initial=np.inf)
            up_to_m = most.max(where=beside_car & (here >= most), initial=-np.inf)
            taken = self._config.beside.height * ((self._y_m > from_m) | (self._y_m < up_to_m))
        ahead = geometry.is_static & (geometry.way_m > 0.0)
        if self._config.unreached_height is None or not ahead.any():
            return taken
        far_right, far_left = self._far(geometry, least, most, lane)
        from_m = most.min(where=ahead & (here < most) & far_right, initial=np.inf)
        up_to_m = least.max(where=ahead & (here > least) & far_left, initial=-np.inf)
        beyond = (self._y_m >= from_m) | (self._y_m <= up_to_m)
        unreached: Floats = np.maximum(taken, self._config.unreached_height * beyond)
        return unreached

    def _far(self, geometry: ObstacleGeometry, least_m: Floats, most_m: Floats, lane: Lane) -> tuple[Bools, Bools]:
        """(K,) whether the way is too short to get past an obstacle on its right, and on its left.

        `least_m`, `most_m` (K,): the lateral positions in which the car would overlap it.
        """
        way, slope = geometry.way_m, np.array([[-tan(lane.heading_rad)], [tan(lane.heading_rad)]])
        shift = np.array([most_m - lane.y_m, lane.y_m - least_m]) - self._kinematics.heading_shift(way, slope)
        slow = np.array(self._edge_way(least_m, most_m, lane)) > way
        right, left = (shift > self._kinematics.largest_shift(way)) | slow
        return right, left

    def _edge_way(self, least_m: Floats, most_m: Floats, lane: Lane) -> tuple[Floats, Floats]:
        """(K,) m of way past an obstacle on its right and left, where an edge lets the car come near slowly.

        It counts for a car that has not chosen that side yet: halfway there, no other may be left.
        """
        right, left = lane.right_m - self._half_width_m, lane.left_m + self._half_width_m
        slope = -tan(lane.heading_rad)
        to_right = self._kinematics.edge_way(right - lane.y_m, right - most_m, slope)
        to_left = self._kinematics.edge_way(lane.y_m - left, least_m - left, -slope)
        last = lane.y_m if self._last_m is None else self._last_m
        return np.where(last < most_m, to_right, -np.inf), np.where(last > least_m, to_left, -np.inf)

    def _minimum(self, total: Floats, lane: Lane) -> float:
        """y of the global minimum, between grid points by a parabola."""
        (lowest,) = (total <= total.min() + TIE).nonzero()
        index = int(lowest[0]) if len(lowest) == 1 else self._break_tie(lowest, lane)
        if not 0 < index < len(total) - 1:
            return float(self._y_m[index])
        before, here, after = total[index - 1 : index + 2].tolist()
        bend = before - 2.0 * here + after
        shift = 0.5 * (before - after) / bend if bend > TIE else 0.0
        return float(self._y_m[index] + self._config.spacing_m * min(max(shift, -0.5), 0.5))

    def _break_tie(self, lowest: "np.typing.NDArray[np.intp]", lane: Lane) -> int:
        y = self._y_m[lowest]
        last = self._last_m if self._last_m is not None else lane.y_m
        distance = np.abs(y - last)
        nearest = lowest[distance <= distance.min() + TIE]
        wider_right = lane.right_m - last > last - lane.left_m + TIE
        return int(nearest[-1] if wider_right else nearest[0])
