"""The path of the rear axle across the road: to the minimum of the cost with the least jerk, as the car can follow it.

A car's rear axle goes where the car is headed, and its path has the curvature tan(delta) / L. So a path y_r(s) of the
rear axle, s the way along it, gives heading and steering without a lag, and what the car can do are bounds on it:

    |y_r'| <= sine of the largest angle,    |y_r''| <= 1 / R,    |y_r'''| <= (largest d delta / dt) / (L v),

or less, where comfort asks for less (`vpf_sim.planning.lane.kinematic_limits`). All are of the way, not of time: a car
at walking speed follows the same path more slowly, and one that stands follows none. Within them the path begins at
every step with the third derivative of the least-jerk path (T. Flash, N. Hogan, J. Neurosci. 5, 1985: a polynomial of
fifth order) from place y, slope p, bend c to rest at y_m on the way S, S receding:

    60 (y_m - y) / S^3 - 36 p / S^2 - 9 c / S.

For a constant S that is a filter of third order; after a step D it is done in 1.1 S, with an overshoot of 2 %.
"""

from math import copysign, inf, sqrt

from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import PEAK_SPEED, KinematicLimits, Limits
from vpf_sim.planning.lane.lane_settings import PathConfig

STEEPEST = 0.95  # slope, whatever the bend was before: at a speed that jumps one step may be many metres long


class LateralPath:
    """Lateral position, slope and bend of the rear axle's path at the car."""

    def __init__(self, config: PathConfig, kinematics: KinematicLimits, y_m: float, way_m: float) -> None:
        self._config = config
        self._kinematics = kinematics
        self._way_m = way_m  # S
        self.y_m = y_m
        self.slope = 0.0
        self.bend_per_m = 0.0

    def advance(
        self,
        lane: Lane,
        minimum_m: float,
        time_s: float,
        speed_mps: float,
        step_m: float,
        side_slopes: tuple[float, float] = (inf, inf),
    ) -> None:
        """One step towards the minimum, which must be reached in `time_s`.

        With `side_slopes`, the largest slopes to the left and right, the sides of the car keep off obstacles beside it.
        """
        error, limits = minimum_m - self.y_m, self._kinematics.limits(speed_mps)
        way = self._way(abs(error), limits, time_s, speed_mps, step_m)
        jerk = (60.0 * error / way - 36.0 * self.slope) / way**2 - 9.0 * self.bend_per_m / way
        most = float(limits.steering_per_m2)
        bend = self.bend_per_m + min(max(jerk, -most), most) * step_m
        self.bend_per_m = self._bounded(bend, lane, side_slopes, limits, step_m)
        self.slope = min(max(self.slope + self.bend_per_m * step_m, -STEEPEST), STEEPEST)
        self.y_m += self.slope * step_m

    def hold(self, rear_m: float) -> None:
        """Stay near the rear axle."""
        lead = self._config.lead_m
        self.y_m = min(max(self.y_m, rear_m - lead), rear_m + lead)

    def _way(self, shift_m: float, limits: Limits, time_s: float, speed_mps: float, step_m: float) -> float:
        """S: as the time allows, and at least as the car needs."""
        config, pace = self._config, max(speed_mps, self._kinematics.walking_mps)
        by_speed = PEAK_SPEED * shift_m * pace / config.speed_mps
        least = max(float(limits.way(shift_m)), by_speed, config.shortest_s * pace)
        wanted = pace * min(config.shift_s, config.shift_share * time_s)
        # A hurry ends slowly: a longer way at full slope would carry the path past the minimum.
        self._way_m = max(least, min(wanted, self._way_m + step_m))
        return self._way_m

    def _bounded(
        self, bend_per_m: float, lane: Lane, side_slopes: tuple[float, float], limits: Limits, step_m: float
    ) -> float:
        """The bend, so that the slope comes to rest at its bounds as fast as the steering turns.

        The bounds are the largest angle, the edge and the flank of each side. A slope along an edge falls as the path
        comes nearer, by slope / arm a metre: there the bend rests. It stays large enough to keep the other flank.
        """
        tightest, ratio, steering = float(limits.tightest_per_m), float(limits.ratio), float(limits.steering_per_m2)
        change = steering * step_m
        half = 0.5 * change

        def braked(room: float) -> float:
            """The bend from which a slope comes to rest so much farther on."""
            return copysign(sqrt(half**2 + 2.0 * steering * abs(room)) - half, room)

        def largest_to(edge: float, flank: float, kept: float, slope: float) -> float:
            by_edge = max(braked(edge - slope) - max(slope, 0.0) / self._kinematics.path_arm_m, braked(kept - slope))
            return min(max(min(braked(min(ratio, flank) - slope), by_edge), -tightest), tightest)

        left, right = self._kinematics.path_between(lane, self.y_m)
        to_left, to_right = side_slopes
        largest = max(largest_to(right, to_right, -to_left, self.slope), self.bend_per_m - change)
        least = min(-largest_to(left, to_left, -to_right, -self.slope), self.bend_per_m + change)
        if least > largest:
            return 0.5 * (least + largest)
        return min(max(bend_per_m, least), largest)
