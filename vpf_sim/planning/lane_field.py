"""The robust variant's visual potential field: target, road and obstacle potential across the lane, and its minimum.

All three are functions of y, the place across the road (`vpf_sim.planning.lane`), in the same units:

    U(y) = k y^2                                                            target: the middle of the own lane
         + h_w ((1 - g_r(y) / d_w)^2 + (1 - g_l(y) / d_w)^2), each for g < d_w    road: g is the gap to the edge
         + max over bodies of w(t) {h_o + s_o (c - d) for d < c, else h_t e^(-(d - c) / d_t)}     obstacles
           to which nearer than d_n, where no gap is passed, comes h_n (1 - d / d_n), h_n at most
         + max over rows of w(t) h_r (1 - b / b_r) between two bodies of a row leaving room, but b < b_r

d is the lateral gap between our body and the other, negative where they overlap, c the clearance wanted, and w(t) fades
in with the distance t to the body. Bodies take the maximum, not the sum, so that many points of one body weigh as one.
Where no place is free, h_o and s_o are larger for bodies before which the car can no longer stop: it keeps clear of
those, and stops before the others.

The paper follows the local gradient; here the car goes to the global minimum, since dead ahead of a body the gradient
vanishes and the side would be left to chance (METHOD A9, A10). What has been decided is kept: a term in the distance
from the last minimum, and a latch on the side of every body that is near. It is a light one where a gap between two
bodies proves narrow and the car does not go there yet: something low, told last, may close it, and a free side is
better. What lies behind a body and cannot be reached before it (`vpf_sim.planning.reach`) costs, and places beyond an
edge are no choice: the car stops rather than go there. A tie goes to the minimum that is nearer to the last one, then
to the side with more road, then to the left.
"""

from dataclasses import dataclass, replace
from math import tan

import numpy as np

from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.planning.lane_field_config import LaneFieldConfig
from vpf_sim.planning.reach import Reach
from vpf_sim.planning.rows import ROW_M, narrowness
from vpf_sim.planning.stopping import stopping_way
from vpf_sim.types import Bools, Floats, VehicleModel

TIE = 1e-9
TURNED_RAD = 0.05  # to one side of a body, from the road: it has been chosen, however far off the body is
NEXT_M = 4.0  # ahead, what stands beside our way is passed next
FREE_M = 1e-6  # a body's own side is free of it
NO_CHOICE = 1e3  # more than any body, side or memory costs
BOUNDS_M = 1.5  # of our body, what stands bounds the gap that it goes through
CROSSING_S, CROSSING_M = 2.5, 1.0  # to the other side of a body that moves, and what is kept from it
BEHIND_M = 0.5  # off its middle: who is not farther aside goes behind it, and has not chosen a side yet
SOON_S, SOON_M = 3.0, 5.0  # until a body that moves is met, and what is kept from it
PASSING_M = 3.0  # from bumper to face: a body that moves is being passed
STOP_MPS2, STOP_REACTION_S = 3.0, 0.3  # of a stop in need
CATCH_UP_S = 4.0  # a faster body behind counts if it is beside us within this time


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
        index = min(max(int(np.searchsorted(self.y_m, y_m)), 1), len(self.y_m) - 1)
        ends = np.array([part[index - 1 : index + 1] for part in (self.target, self.road, self.obstacle)])
        slope: Floats = (ends[:, 1] - ends[:, 0]) / (self.y_m[index] - self.y_m[index - 1])
        return slope


class LaneField:
    """Composes the field of each frame and finds its minimum; remembers the last one."""

    def __init__(
        self, config: LaneFieldConfig, vehicle: VehicleModel, speed_reference_mps: float, reach: Reach
    ) -> None:
        self._config = config
        self._reach = reach
        self._speed_reference_mps = speed_reference_mps
        self._half_width_m = 0.5 * vehicle.width_m
        self._half_length_m = 0.5 * vehicle.length_m
        half = np.arange(1, round(config.reach_m / config.spacing_m) + 1) * config.spacing_m
        self._y_m: Floats = np.concatenate([-half[::-1], [0.0], half])  # symmetric to the last bit
        self._target: Floats = config.target_per_m2 * self._y_m**2
        touching = config.obstacle_height + config.obstacle_slope_per_m * config.clearance_m + config.narrow_height
        self._touching = touching  # U at no gap
        self._last_m: float | None = None
        self._weighed: tuple[LaneObstacles, Floats] | None = None  # the bodies of this step, and their weights

    def update(self, lane: Lane, obstacles: LaneObstacles, speed_mps: float = 0.0) -> LanePotential:
        """The field about the vehicle now."""
        road = self._road(lane)
        obstacle = self._obstacle(obstacles)
        shut = self._beyond(lane) + self._unreached(obstacles, lane)
        if not np.any((obstacle < self._touching) & (shut == 0.0)):
            obstacle = self._obstacle(obstacles, self._unstopped(obstacles, speed_mps))
        rows = self._rows(obstacles)
        obstacle = obstacle + rows
        total = self._target + road + obstacle
        kept = total + shut
        if self._last_m is not None:
            kept = kept + self._memory(obstacles, lane, rows)
        self._last_m = self._minimum(kept, lane)
        return LanePotential(self._y_m, self._target, road, obstacle, self._last_m)

    def keep(self, y_m: float) -> None:
        """Decide for a place: the car got there by other means."""
        self._last_m = y_m

    def overlap(self, obstacles: LaneObstacles, y_m: float, clearance_m: float) -> Floats:
        """(K,) m by which our body at y, widened by a clearance, covers each body across the road; <= 0: it is free."""
        return clearance_m - self._gap(obstacles, np.array([y_m]))[:, 0]

    def hinders(self, obstacles: LaneObstacles, y_m: float) -> Bools:
        """(K,) which bodies ahead have not the clearance that is wanted from our body at y."""
        near = (self.present(obstacles) > 0.0) & (self.bumper(obstacles) > 0.0)
        hinders: Bools = near & (self.overlap(obstacles, y_m, self._config.clearance_m) > 0.0)
        return hinders

    def shift(self, obstacles: LaneObstacles, y_m: float, goal_m: float, clearance_m: Floats | float) -> Floats:
        """(K,) m from y towards a goal across the road until our body is clear of each; <= 0 where it is."""
        margin = self._half_width_m + clearance_m
        least, most = obstacles.left_m - margin, obstacles.right_m + margin
        if goal_m >= y_m:
            return np.where(goal_m > least, most - y_m, 0.0)
        return np.where(goal_m < most, y_m - least, 0.0)

    def nearer_side(self, obstacles: LaneObstacles, lane: Lane, clearance_m: float) -> Floats:
        """(K,) m from here to the nearer side of each body that lies on the road and where no other stands; else 0."""
        margin = self._half_width_m + self._config.edge_gap_m
        here, aside = lane.y_m, self._half_width_m + clearance_m
        least, most = obstacles.left_m - aside, obstacles.right_m + aside  # of the places that each takes
        sides = np.concatenate([least, most])
        stands = (self.present(obstacles) > 0.0) & (obstacles.speed_mps == 0.0)
        taken = (least[:, None] < sides - FREE_M) & (sides + FREE_M < most[:, None]) & stands[:, None]
        off = (sides < lane.left_m + margin) | (sides > lane.right_m - margin) | np.any(taken, axis=0)
        free = np.where(off, np.inf, np.abs(sides - here))
        in_way = (least < here) & (here < most)
        nearer = float(free.min(initial=np.inf))
        return np.where(in_way & (nearer < np.inf), nearer, 0.0)

    def beside(self, obstacles: LaneObstacles, lane: Lane, path_m: float) -> Lane:
        """The lane between the bodies that the car is passing, instead of between the edges of the road.

        A body that is passed next counts as well where neither the car nor its path, now at `path_m`, leads into it:
        who turns towards it reaches it with a corner first.
        """
        if not len(obstacles):
            return lane
        front, rear = self.bumper(obstacles), obstacles.along_m + self._length(obstacles)
        passing = (front < NEXT_M) & (rear > -self._half_length_m)
        least = np.where(front < 0.0, lane.y_m, min(lane.y_m, path_m) - self._half_width_m)
        most = np.where(front < 0.0, lane.y_m, max(lane.y_m, path_m) + self._half_width_m)
        right = np.min(obstacles.left_m, where=passing & (obstacles.left_m > most), initial=lane.right_m)
        left = np.max(obstacles.right_m, where=passing & (obstacles.right_m < least), initial=lane.left_m)
        return replace(lane, right_m=float(right), left_m=float(left))

    def gap(self, obstacles: LaneObstacles, lane: Lane, y_m: float) -> tuple[float, float]:
        """m, how wide the gap at y is between the edges and what stands in the next row, and the way to it, or inf."""
        way = self.bumper(obstacles)
        stands = (self.present(obstacles) > 0.0) & (obstacles.speed_mps == 0.0) & (way > 0.0)
        near = stands & (self.overlap(obstacles, y_m, BOUNDS_M) > 0.0)
        first = float(np.min(way, where=near, initial=np.inf))
        stands &= way < first + ROW_M
        middle = obstacles.middle_m
        right = float(np.min(obstacles.left_m, where=stands & (middle > y_m), initial=lane.right_m))
        left = float(np.max(obstacles.right_m, where=stands & (middle <= y_m), initial=lane.left_m))
        return right - left, first

    def kept_beside(self, obstacles: LaneObstacles, y_m: float, minimum_m: float) -> float:
        """The minimum, no nearer to bodies that move and are being passed by a path at y than the clearance wanted.

        Their sides are told with large errors, and what is farther ahead must not push the path towards them.
        """
        passing = (self.present(obstacles) > 0.0) & (obstacles.speed_mps > 0.0) & (self.bumper(obstacles) < PASSING_M)
        if not np.any(passing):
            return minimum_m
        margin = self._half_width_m + self._config.clearance_m
        middle = obstacles.middle_m
        least = float(np.max(obstacles.right_m + margin, where=passing & (middle < y_m), initial=-np.inf))
        most = float(np.min(obstacles.left_m - margin, where=passing & (middle > y_m), initial=np.inf))
        least, most = min(least, y_m), max(most, y_m)  # the path is not pushed away: the field does that
        return min(max(minimum_m, least), most)

    def bumper(self, obstacles: LaneObstacles) -> Floats:
        """(K,) m from our bumper to each face."""
        return obstacles.along_m - self._half_length_m

    def met(self, obstacles: LaneObstacles, lane: Lane) -> Floats:
        """(K,) m until our body meets each with its front, if it goes straight on as it is headed; inf where never.

        As if all stood: of one that drives on, that is less than it takes.
        """
        way, slope = self.bumper(obstacles), -tan(lane.heading_rad)
        y = lane.y_m + slope * obstacles.along_m  # of our front where it is abreast of the face
        beyond = np.maximum(obstacles.left_m - y, y - obstacles.right_m) - self._half_width_m
        nears = (obstacles.left_m + obstacles.right_m - 2.0 * y) * slope > 0.0
        further = np.maximum(beyond, 0.0) / max(abs(slope), FREE_M)
        meets = (beyond <= 0.0) | (nears & (further < self._length(obstacles)))
        return np.where(meets & (way > 0.0), way + further, np.inf)

    def present(self, obstacles: LaneObstacles) -> Floats:
        """(K,) 0 .. 1, the weight w of each body by its distance; 0 once it has been passed, or runs away."""
        if self._weighed is None or self._weighed[0] is not obstacles:
            self._weighed = obstacles, self._weight(obstacles)
        return self._weighed[1]

    def _weight(self, obstacles: LaneObstacles) -> Floats:
        config = self._config
        gap = self.bumper(obstacles)
        weight = np.clip((self._visible(obstacles) - gap) / (config.visible_m - config.full_m), 0.0, 1.0)
        faster = obstacles.speed_mps - self._speed_reference_mps
        runs = (faster > -config.slower_mps) & (gap > config.beside_m)
        catches_up = np.maximum(faster, 0.0) * CATCH_UP_S
        passed = obstacles.along_m + self._length(obstacles) + catches_up < -self._half_length_m
        return np.where(passed | runs, 0.0, weight)

    def _visible(self, obstacles: LaneObstacles) -> Floats:
        """(K,) m from bumper to face, from which each body begins to count: one that moves only when it is met soon."""
        closing = np.maximum(self._speed_reference_mps - obstacles.speed_mps, 0.0)
        soon = np.minimum(SOON_M + SOON_S * closing, self._config.visible_m)
        return np.where(obstacles.speed_mps > 0.0, soon, self._config.visible_m)

    def _length(self, obstacles: LaneObstacles) -> Floats:
        """(K,) m from each face to where the body ends, at least."""
        long = (obstacles.speed_mps > 0.0) | (obstacles.width_m > self._config.truck_width_m)
        least = np.where(long, self._config.long_m, self._config.body_length_m)
        length: Floats = np.maximum(least, obstacles.length_m)
        return length

    def _road(self, lane: Lane) -> Floats:
        config = self._config
        right, left = self._edge_gaps(lane)
        reach = config.wall_reach_m
        wall: Floats = np.maximum(1.0 - right / reach, 0.0) ** 2 + np.maximum(1.0 - left / reach, 0.0) ** 2
        return config.wall_height * wall

    def _beyond(self, lane: Lane) -> Floats:
        """(G,) what keeps the minimum on the road: the worst body is one to stop before, not to leave the road for."""
        right, left = self._edge_gaps(lane)
        return np.where(np.minimum(right, left) < self._config.edge_gap_m, NO_CHOICE, 0.0)

    def _edge_gaps(self, lane: Lane) -> tuple[Floats, Floats]:
        """(G,) m between our body at y and the right and the left edge."""
        right: Floats = lane.right_m - self._y_m - self._half_width_m
        left: Floats = self._y_m - lane.left_m - self._half_width_m
        return right, left

    def _obstacle(self, obstacles: LaneObstacles, unstopped: Floats | float = 0.0) -> Floats:
        config = self._config
        if not len(obstacles):
            return np.zeros_like(self._y_m)
        lacking = config.clearance_m - self._gap(obstacles, self._y_m)
        narrow = 1.0 - np.clip((config.clearance_m - lacking) / config.narrow_m, 0.0, 1.0)
        inside = config.obstacle_height + config.obstacle_slope_per_m * lacking + config.narrow_height * narrow
        inside = inside * (1.0 + config.unstopped_share * np.reshape(unstopped, (-1, 1)))
        outside = config.tail_height * np.exp(np.minimum(lacking, 0.0) / config.tail_decay_m)
        each = self.present(obstacles)[:, None] * np.where(lacking > 0.0, inside, outside)
        worst: Floats = each.max(axis=0)
        return worst

    def _rows(self, obstacles: LaneObstacles) -> Floats:
        """(G,) what a gap between two bodies of a row costs that is wide enough, but narrow."""
        weight = np.where((obstacles.speed_mps == 0.0) & (self.bumper(obstacles) > 0.0), self.present(obstacles), 0.0)
        widths_m = 2.0 * (self._half_width_m + self._config.clearance_m), self._config.row_gap_m
        return self._config.row_height * narrowness(obstacles, weight, self._y_m, widths_m)

    def _unstopped(self, obstacles: LaneObstacles, speed_mps: float) -> Floats:
        """(K,) 0 .. 1, which bodies are too near for a stop."""
        way = self.bumper(obstacles)
        closing = np.maximum(speed_mps - obstacles.speed_mps, 0.0)
        stop = stopping_way(closing, STOP_MPS2, STOP_REACTION_S)
        return np.where(way > 0.0, np.clip(stop - way, 0.0, 1.0), 0.0)

    def _gap(self, obstacles: LaneObstacles, y_m: Floats) -> Floats:
        """(K, G) m between our body at y and each body, across the road."""
        right = y_m - self._half_width_m - obstacles.right_m[:, None]
        left = obstacles.left_m[:, None] - y_m - self._half_width_m
        gap: Floats = np.maximum(right, left)
        return gap

    def _memory(self, obstacles: LaneObstacles, lane: Lane, rows: Floats) -> Floats:
        """(G,) what keeps the decision: leaving the last minimum costs, changing the side of a near body costs more.

        As much if the car has turned to that side already; less if it has not and the gap there proves narrow.
        """
        config = self._config
        last = self._last_m if self._last_m is not None else 0.0
        away = np.abs(self._y_m - last) / config.memory_m
        memory: Floats = config.memory_height * np.minimum(np.maximum(away - 1.0, 0.0), 1.0)
        if not len(obstacles):
            return memory
        gap, middle = self.bumper(obstacles), obstacles.middle_m
        turned = (abs(lane.heading_rad) > TURNED_RAD) & (-lane.heading_rad * (last - middle) > 0.0)
        turned &= obstacles.speed_mps == 0.0
        near = (self.present(obstacles) > 0.0) & ((gap < config.latch_m) | turned)
        if not np.any(near):
            return memory
        middle = middle[near]
        # Behind a body that moves there is room to change sides only if it is not reached meanwhile.
        speed = obstacles.speed_mps[near]
        room = CROSSING_M + CROSSING_S * np.maximum(self._speed_reference_mps - speed, 0.0)
        aside = (np.abs(lane.y_m - middle) > BEHIND_M) | (gap[near] < CROSSING_M)
        beside = (gap[near] < np.where(speed > 0.0, room, 0.0)) & aside
        chosen = np.where(beside, lane.y_m, last) - middle
        other = (self._y_m[None] - middle[:, None]) * np.sign(chosen)[:, None] < 0.0
        goes, wide = turned[near] | (abs(lane.y_m - last) < config.memory_m), np.interp(last, self._y_m, rows) == 0.0
        kept = np.where(goes | wide, config.latch_height, config.plan_height)
        height = np.where(beside, config.beside_height, kept)
        latched: Floats = memory + (other * height[:, None]).max(axis=0)
        return latched

    def _unreached(self, obstacles: LaneObstacles, lane: Lane) -> Floats:
        """(G,) what keeps the minimum this side of bodies that stand too near to get to their other side before them.

        Beside a body, its other side and its own place are out of reach whatever else there is.
        """
        if not len(obstacles):
            return np.zeros_like(self._y_m)
        config, way = self._config, self.bumper(obstacles)[:, None]
        y, here = self._y_m[None], lane.y_m
        least = obstacles.left_m[:, None] - self._half_width_m  # of the places that it takes
        most = obstacles.right_m[:, None] + self._half_width_m
        apart = (here <= least) | (here >= most)
        meets = (np.minimum(y, here) < most) & (np.maximum(y, here) > least)
        behind = meets & ((y <= least) | (y >= most))
        slope = np.where(y > here, -tan(lane.heading_rad), tan(lane.heading_rad))
        shift = np.where(y > here, most - here, here - least) - self._reach.brought(way, slope)
        slow = self._edge_way(least, most, y, lane) > way
        far = behind & (way > 0.0) & ((shift > self._reach.aside(way)) | slow)
        stands = (self.present(obstacles) > 0.0) & (obstacles.speed_mps == 0.0)
        cost = np.where(meets & apart & (way <= 0.0), config.beside_height, config.unreached_height * far)
        unreached: Floats = (cost * stands[:, None]).max(axis=0)
        return unreached

    def _edge_way(self, least_m: Floats, most_m: Floats, y_m: Floats, lane: Lane) -> Floats:
        """(K, G) m of way that it takes to y, free of a body's places between `least_m` and `most_m` (K, 1), because
        the edge on that side lets the car come near but slowly.

        It counts for who has not chosen that side yet: halfway there, no other may be left.
        """
        right, left = lane.right_m - self._half_width_m, lane.left_m + self._half_width_m
        slope = -tan(lane.heading_rad)
        to_right = self._reach.edge_way(right - lane.y_m, right - most_m, slope)
        to_left = self._reach.edge_way(lane.y_m - left, least_m - left, -slope)
        last = lane.y_m if self._last_m is None else self._last_m
        to_right, to_left = np.where(last < most_m, to_right, -np.inf), np.where(last > least_m, to_left, -np.inf)
        return np.where(y_m > lane.y_m, to_right, to_left)

    def _minimum(self, total: Floats, lane: Lane) -> float:
        """y of the global minimum, between the grid's points by a parabola."""
        lowest = np.flatnonzero(total <= total.min() + TIE)
        index = int(lowest[0]) if len(lowest) == 1 else self._break_tie(lowest, lane)
        if not 0 < index < len(total) - 1:
            return float(self._y_m[index])
        before, here, after = total[index - 1 : index + 2]
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
