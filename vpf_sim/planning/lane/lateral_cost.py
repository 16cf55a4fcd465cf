"""The lateral cost: of target, road and obstacles, across the lane, and its minimum.

All three are functions of y, the position across the road (`vpf_sim.planning.lane.frame`), in the same units:

    U(y) = k y^2                                                            target: the middle of the own lane
         + h_w ((1 - g_r(y) / d_w)^2 + (1 - g_l(y) / d_w)^2), each for g < d_w    road: g is the gap to the edge
         + max over obstacles of w(t) {h_o + s_o (c - d) + h_n (1 - d / d_n)} for d < c,
           the last term for d below the least clearance d_n, and h_n at most

d is the lateral gap between the car and an obstacle, negative where they overlap, c the clearance wanted, and w(t)
fades in with the distance t to the obstacle. Obstacles take the maximum, not the sum, so that many points of one
obstacle weigh as one.

The paper follows the local gradient. Here the car goes to the global minimum, since dead ahead of an obstacle the
gradient vanishes and the side would be left to chance. The latch keeps a decision: the other side of a near obstacle
costs more. Places beyond an edge are excluded: the car stops rather than go there. A tie goes to the minimum that is
nearer to the last one, then to the side with more road, then to the left.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.planning.lane.config import LanePlannerConfig
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.types import DriverSetup, Floats

TIE = 1e-9
EXCLUDED = 1e3  # more than any obstacle or side costs


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

    def __init__(self, planner: LanePlannerConfig, setup: DriverSetup) -> None:
        config = self._config = planner.lateral_cost
        self._clearance, self._half_width_m = planner.clearance, 0.5 * setup.vehicle.width_m
        half = np.arange(1, round(config.reach_m / config.spacing_m) + 1) * config.spacing_m
        self._y_m: Floats = np.concatenate([-half[::-1], [0.0], half])  # symmetric to the last bit
        self._target: Floats = config.target_per_m2 * self._y_m**2
        self._nothing: Floats = np.zeros(len(self._y_m))
        self._nothing.flags.writeable = False  # shared by all steps without an obstacle
        self._last_m: float | None = None

    def update(self, lane: Lane, geometry: ObstacleGeometry) -> CostProfile:
        """The cost about the vehicle now."""
        gaps = self._edge_gaps(lane)
        road, obstacle = self._road(*gaps), self._obstacle(geometry)
        total = self._target + road + obstacle + self._beyond(*gaps) + self._other_side(geometry, lane)
        self._last_m = self._minimum(total, lane)
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

    def _obstacle(self, geometry: ObstacleGeometry) -> Floats:
        config = self._config
        if not geometry.weight.any():
            return self._nothing
        gap = geometry.gap(self._y_m)
        lacking = self._clearance.wanted_m - gap
        narrow = 1.0 - np.minimum(np.maximum(gap / self._clearance.least_m, 0.0), 1.0)
        inside = config.obstacle_height + config.obstacle_slope_per_m * lacking + config.narrow_height * narrow
        worst: Floats = (geometry.weight[:, None] * np.where(lacking > 0.0, inside, 0.0)).max(axis=0)
        return worst

    def _other_side(self, geometry: ObstacleGeometry, lane: Lane) -> Floats:
        """(G,) the cost of the other side of obstacles that are near, or beside the car."""
        latch = self._config.latch
        if latch is None or self._last_m is None:
            return self._nothing
        near = geometry.present & (geometry.way_m < latch.ahead_m)
        if not near.any():
            return self._nothing
        abreast, middle = geometry.way_m < 0.0, geometry.obstacles.middle_m
        side = np.sign(np.where(abreast, lane.y_m, self._last_m) - middle)
        height = near * np.where(abreast, latch.beside_height, latch.height)
        other = (self._y_m[None] - middle[:, None]) * side[:, None] < 0.0
        latched: Floats = (other * height[:, None]).max(axis=0)
        return latched

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
