"""The robust variant's visual potential field: target, road and obstacle potential across the lane, and its minimum.

All three are functions of y, the place across the road (`vpf_sim.planning.lane.frame`), in the same units:

    U(y) = k y^2                                                            target: the middle of the own lane
         + h_w ((1 - g_r(y) / d_w)^2 + (1 - g_l(y) / d_w)^2), each for g < d_w    road: g is the gap to the edge
         + max over bodies of w(t) {h_o + s_o (c - d) for d < c, else h_t e^(-(d - c) / d_t)}     obstacles
           to which nearer than d_n, where no gap is passed, comes h_n (1 - d / d_n), h_n at most
         + max over rows of w(t) h_r (1 - b / b_r) between two bodies of a row, or one and an edge, leaving room,
           but b < b_r

d is the lateral gap between our body and the other, negative where they overlap, c the clearance wanted, and w(t) fades
in with the distance t to the body, or to the first of its row. Bodies take the maximum, not the sum, so that many
points of one body weigh as one. Where no place is free, h_o and s_o are larger for bodies before which the car can no
longer stop: it keeps clear of those, and stops before the others.

The paper follows the local gradient; here the car goes to the global minimum, since dead ahead of a body the gradient
vanishes and the side would be left to chance. What has been decided is kept: a term in the distance
from the last minimum, and a latch on the side of every body that is near. It is a light one where a gap between two
bodies proves narrow and the car does not go there yet: something low, told last, may close it, and a free side is
better. What lies behind a body and cannot be reached before it (`vpf_sim.planning.lane.kinematic_limits`) costs, and
places beyond an edge are no choice: the car stops rather than go there. A tie goes to the minimum that is nearer to the
last one, then to the side with more road, then to the left.
"""

from dataclasses import dataclass
from math import tan

import numpy as np

from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.gap_cost import narrowness
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.lateral_cost_config import LateralCostConfig
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.stopping_distance import stopping_way
from vpf_sim.types import Bools, Floats, VehicleModel

TIE = 1e-9
TURNED_RAD = 0.05  # to one side of a body, from the road: it has been chosen, however far off the body is
NO_CHOICE = 1e3  # more than any body, side or memory costs
CROSSING_S, CROSSING_M = 2.5, 1.0  # to the other side of a body that moves, and what is kept from it
BEHIND_M = 0.5  # off its middle: who is not farther aside goes behind it, and has not chosen a side yet
STOP_MPS2, STOP_REACTION_S = 3.0, 0.3  # of a stop in need
WITHIN_M = 0.5  # a place that a body covers so far is on no side of it; its sides are told no better than this


@dataclass(frozen=True, slots=True)
class LanePotential:
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
    """Composes the field of each frame and finds its minimum; remembers the last one."""

    def __init__(
        self, config: LateralCostConfig, vehicle: VehicleModel, speed_reference_mps: float, reach: KinematicLimits
    ) -> None:
        self._config = config
        self._reach = reach
        self._speed_reference_mps = speed_reference_mps
        self._half_width_m = 0.5 * vehicle.width_m
        half = np.arange(1, round(config.reach_m / config.spacing_m) + 1) * config.spacing_m
        self._y_m: Floats = np.concatenate([-half[::-1], [0.0], half])  # symmetric to the last bit
        self._target: Floats = config.target_per_m2 * self._y_m**2
        self._nothing: Floats = np.zeros(len(self._y_m))
        self._nothing.flags.writeable = False  # it is of all steps without a body
        touching = config.obstacle_height + config.obstacle_slope_per_m * config.clearance_m + config.narrow_height
        self._touching = touching  # U at no gap
        self._last_m: float | None = None

    def update(self, lane: Lane, neighbours: ObstacleGeometry, speed_mps: float = 0.0) -> LanePotential:
        """The field about the vehicle now."""
        gaps = self._edge_gaps(lane)
        road = self._road(*gaps)
        shut = self._beyond(*gaps)
        obstacle = rows = self._nothing
        if len(neighbours):
            obstacle, shut = self._obstacle(neighbours), shut + self._unreached(neighbours, lane)
            if not ((obstacle < self._touching) & (shut == 0.0)).any():
                obstacle = self._obstacle(neighbours, self._unstopped(neighbours, speed_mps)[:, None])
            rows = self._rows(neighbours, lane)
            obstacle = obstacle + rows
        kept = self._target + road + obstacle + shut
        if self._last_m is not None:
            kept = kept + self._memory(neighbours, lane, rows)
        self._last_m = self._minimum(kept, lane)
        return LanePotential(self._y_m, self._target, road, obstacle, self._last_m)

    def keep(self, y_m: float) -> None:
        """Decide for a place: the car got there by other means."""
        self._last_m = y_m

    def _road(self, right_m: Floats, left_m: Floats) -> Floats:
        config = self._config
        reach = config.wall_reach_m
        wall: Floats = np.maximum(1.0 - right_m / reach, 0.0) ** 2 + np.maximum(1.0 - left_m / reach, 0.0) ** 2
        return config.wall_height * wall

    def _beyond(self, right_m: Floats, left_m: Floats) -> Floats:
        """(G,) what keeps the minimum on the road: the worst body is one to stop before, not to leave the road for."""
        return np.where(np.minimum(right_m, left_m) < self._config.edge_gap_m, NO_CHOICE, 0.0)

    def _edge_gaps(self, lane: Lane) -> tuple[Floats, Floats]:
        """(G,) m between our body at y and the right and the left edge."""
        right: Floats = lane.right_m - self._y_m - self._half_width_m
        left: Floats = self._y_m - lane.left_m - self._half_width_m
        return right, left

    def _obstacle(self, neighbours: ObstacleGeometry, unstopped: Floats | float = 0.0) -> Floats:
        config = self._config
        if not neighbours.weight.any():
            return self._nothing
        lacking = config.clearance_m - neighbours.gap(self._y_m)
        narrow = 1.0 - np.minimum(np.maximum((config.clearance_m - lacking) / config.narrow_m, 0.0), 1.0)
        inside = config.obstacle_height + config.obstacle_slope_per_m * lacking + config.narrow_height * narrow
        inside = inside * (1.0 + config.unstopped_share * unstopped)
        outside = config.tail_height * np.exp(np.minimum(lacking, 0.0) / config.tail_decay_m)
        each = neighbours.weight[:, None] * np.where(lacking > 0.0, inside, outside)
        worst: Floats = each.max(axis=0)
        return worst

    def _rows(self, neighbours: ObstacleGeometry, lane: Lane) -> Floats:
        """(G,) what a gap between two bodies of a row, or one and an edge, costs that is wide enough, but narrow."""
        widths_m = 2.0 * (self._half_width_m + self._config.clearance_m), self._config.row_gap_m
        narrow = narrowness(neighbours.bodies, neighbours.in_row, neighbours.weight, lane, self._y_m, widths_m)
        return self._config.row_height * narrow

    def _unstopped(self, neighbours: ObstacleGeometry, speed_mps: float) -> Floats:
        """(K,) 0 .. 1, which bodies are too near for a stop."""
        way = neighbours.way_m
        closing = np.maximum(speed_mps - neighbours.bodies.speed_mps, 0.0)
        stop = stopping_way(closing, STOP_MPS2, STOP_REACTION_S)
        return np.where(way > 0.0, np.clip(stop - way, 0.0, 1.0), 0.0)

    def _memory(self, neighbours: ObstacleGeometry, lane: Lane, rows: Floats) -> Floats:
        """(G,) what keeps the decision: leaving the last minimum costs, changing the side of a near body costs more.

        As much if the car has turned to that side already; less if it has not and the gap there proves narrow.
        """
        config = self._config
        last = self._last_m if self._last_m is not None else 0.0
        away = np.abs(self._y_m - last) / config.memory_m
        memory: Floats = config.memory_height * np.minimum(np.maximum(away - 1.0, 0.0), 1.0)
        if not len(neighbours):
            return memory
        gap, middle = neighbours.way_m, neighbours.bodies.middle_m
        turned = (abs(lane.heading_rad) > TURNED_RAD) & (-lane.heading_rad * (last - middle) > 0.0)
        turned &= ~neighbours.moves
        near = neighbours.present & ((gap < config.latch_m) | turned)
        if not near.any():
            return memory
        # Behind a body that moves there is room to change sides only if it is not reached meanwhile.
        speed = neighbours.bodies.speed_mps
        room = CROSSING_M + CROSSING_S * np.maximum(self._speed_reference_mps - speed, 0.0)
        aside = (np.abs(lane.y_m - middle) > BEHIND_M) | (gap < CROSSING_M)
        beside = (gap < np.where(neighbours.moves, room, 0.0)) & aside
        chosen = np.where(beside, lane.y_m, last) - middle
        other = (self._y_m[None] - middle[:, None]) * np.sign(chosen)[:, None] < 0.0
        goes, wide = turned | (abs(lane.y_m - last) < config.memory_m), np.interp(last, self._y_m, rows) == 0.0
        kept = np.where(goes | wide, config.latch_height, config.plan_height)
        # A body told where the car was going has no side yet: that takes a place beside it.
        covers = neighbours.overlap(last, 0.0)
        kept = np.where(turned, kept, kept * np.minimum(np.maximum(1.0 - covers / WITHIN_M, 0.0), 1.0))
        height = np.where(near, np.where(beside, config.beside_height, kept), 0.0)
        latched: Floats = memory + (other * height[:, None]).max(axis=0)
        return latched

    def _unreached(self, neighbours: ObstacleGeometry, lane: Lane) -> Floats:
        """(G,) what keeps the minimum this side of bodies that stand too near to get to their other side before them.

        Beside a body, its other side and its own place are out of reach whatever else there is.
        """
        if not neighbours.stands.any():
            return self._nothing
        config, bodies, y, here = self._config, neighbours.bodies, self._y_m, lane.y_m
        least, most = bodies.left_m - self._half_width_m, bodies.right_m + self._half_width_m  # of the places it takes
        beside = neighbours.stands & (neighbours.way_m <= 0.0)
        from_m = least.min(where=beside & (here <= least), initial=np.inf)
        up_to_m = most.max(where=beside & (here >= most), initial=-np.inf)
        taken: Floats = config.beside_height * ((y > from_m) | (y < up_to_m))
        ahead = neighbours.stands & (neighbours.way_m > 0.0)
        if not ahead.any():
            return taken
        far_right, far_left = self._far(neighbours, least, most, lane)
        from_m = most.min(where=ahead & (here < most) & far_right, initial=np.inf)
        up_to_m = least.max(where=ahead & (here > least) & far_left, initial=-np.inf)
        unreached: Floats = np.maximum(taken, config.unreached_height * ((y >= from_m) | (y <= up_to_m)))
        return unreached

    def _far(self, neighbours: ObstacleGeometry, least_m: Floats, most_m: Floats, lane: Lane) -> tuple[Bools, Bools]:
        """(K,) whether to get free of a body's places, between `least_m` and `most_m` (K,), to the right, and to the
        left, takes more way than there is."""
        way, slope = neighbours.way_m, np.array([[-tan(lane.heading_rad)], [tan(lane.heading_rad)]])
        shift = np.array([most_m - lane.y_m, lane.y_m - least_m]) - self._reach.brought(way, slope)
        slow = np.array(self._edge_way(least_m, most_m, lane)) > way
        right, left = (shift > self._reach.aside(way)) | slow
        return right, left

    def _edge_way(self, least_m: Floats, most_m: Floats, lane: Lane) -> tuple[Floats, Floats]:
        """(K,) m of way that it takes to get free of a body's places, to the right, and to the left, because the edge
        on that side lets the car come near but slowly.

        It counts for who has not chosen that side yet: halfway there, no other may be left.
        """
        right, left = lane.right_m - self._half_width_m, lane.left_m + self._half_width_m
        slope = -tan(lane.heading_rad)
        to_right = self._reach.edge_way(right - lane.y_m, right - most_m, slope)
        to_left = self._reach.edge_way(lane.y_m - left, least_m - left, -slope)
        last = lane.y_m if self._last_m is None else self._last_m
        return np.where(last < most_m, to_right, -np.inf), np.where(last > least_m, to_left, -np.inf)

    def _minimum(self, total: Floats, lane: Lane) -> float:
        """y of the global minimum, between the grid's points by a parabola."""
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
