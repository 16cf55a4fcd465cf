"""Ways aside on the tightest curve: where a walking car could go from here, and how near to all that stands.

From the road's direction a car at its full lock, of radius R of the rear axle, gets with the corner of its front, a
ahead of that axle and b beside it,

    (R + b) sin(theta) - a (1 - cos(theta)) ahead,    (R + b) (1 - cos(theta)) + a sin(theta) aside

while it turns by theta: never more than sqrt((R + b)^2 + a^2) - a ahead, 1.9 m for the car here, and then as far aside
as it likes, as long as it may turn so far. So a course is a turn to an angle, a straight, and a turn back to the
road's direction (L. E. Dubins, Am. J. Math. 79, 1957: the shortest paths of a bounded curvature are such), all with the
rate at which the steering turns.

Poses are of the rear axle, along and across the road, the bend of which is taken off the curvature.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.types import Bools, Floats, VehicleModel

STEP_M = 0.1
WAY_M = 28.0  # on which courses are looked at
LOCKS = (0.9, 1.0)  # shares of the full lock: what is left is for following the course
BEYOND_M = 8.0  # a course leads out where it is free so far behind its end
ANGLES_RAD: Floats = np.radians([5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0])
STRAIGHTS_M: Floats = np.arange(0.0, 7.6, 0.5)


@dataclass(frozen=True, slots=True)
class Courses:
    """N courses of T steps of `STEP_M`; an end is the first step back in the road's direction, T where none is."""

    along_m: Floats  # (N, T) of the rear axle, from where the pose is now
    y_m: Floats  # (N, T)
    turned_rad: Floats  # (N, T) yaw from the road's direction, + right
    steering_rad: Floats  # (N, T)
    end: "np.typing.NDArray[np.intp]"  # (N,)

    def __len__(self) -> int:
        return len(self.end)

    def one(self, index: int) -> "Courses":
        """A single one of them, N = 1."""
        row = slice(index, index + 1)
        return Courses(self.along_m[row], self.y_m[row], self.turned_rad[row], self.steering_rad[row], self.end[row])

    def rest(self, step: int) -> "Courses":
        """What is left of them."""
        row = slice(step, None)
        end = np.maximum(self.end - step, 0)
        return Courses(self.along_m[:, row], self.y_m[:, row], self.turned_rad[:, row], self.steering_rad[:, row], end)


def courses(lane: Lane, steering_rad: float, vehicle: VehicleModel, per_m: float, lock: float) -> Courses:
    """All courses from here with a share of the full lock; `per_m` rad the steering turns on a metre of way at most."""
    sides = np.array([-1.0, 1.0])
    side, angle, straight = (one.ravel() for one in np.meshgrid(sides, ANGLES_RAD, STRAIGHTS_M, indexing="ij"))
    count, steps = len(side), round(WAY_M / STEP_M)
    turned, steering = np.full(count, -lane.heading_rad), np.full(count, steering_rad)
    along = np.full(count, -vehicle.l_r_m * np.cos(turned))
    y = lane.y_m - vehicle.l_r_m * np.sin(turned)
    stage, left_m = np.zeros(count, np.intp), straight.copy()
    rows, end, most = [], np.full(count, steps), per_m * STEP_M
    for step in range(steps):
        rows.append((along, y, turned, steering))
        unwound = -np.log(np.cos(steering)) / vehicle.wheelbase_m / per_m  # rad, while the wheels are turned back
        stage = stage + ((stage == 0) & (angle - side * turned <= unwound * (side * steering > 0.0)))
        left_m = left_m - STEP_M * (stage == 1)
        stage = stage + ((stage == 1) & (left_m <= 0.0))
        stage = stage + ((stage == 2) & (side * turned <= unwound * (side * steering < 0.0)))
        is_back = (stage == 3) & (np.abs(steering) < most)
        end = np.where(is_back & (end == steps), step, end)
        wanted = lock * vehicle.steering_limit_rad * side * np.array([1.0, 0.0, -1.0, 0.0])[stage]
        before, steering = steering, steering + np.clip(wanted - steering, -most, most)
        bend = np.tan(0.5 * (before + steering)) / vehicle.wheelbase_m - lane.curvature_per_m
        bend = np.where(is_back, 0.0, bend)
        middle = turned + 0.5 * STEP_M * bend
        along, y = along + STEP_M * np.cos(middle), y + STEP_M * np.sin(middle)
        turned = turned + STEP_M * bend
    along, y, turned, steering = (np.stack(part, axis=1) for part in zip(*rows, strict=True))
    return Courses(along, y, turned, steering, end)


def separation(
    course: Courses, lane: Lane, obstacles: LaneObstacles, length_m: Floats, vehicle: VehicleModel
) -> tuple[Floats, Floats]:
    """(N, T) m by which our body is apart at least from all bodies, and (N,) from both edges, until it is past its end.

    Rectangles are apart by no less than along any of their sides' directions. `length_m` (K,) is how long bodies are
    taken to be.
    """
    cosine, sine = np.cos(course.turned_rad), np.sin(course.turned_rad)
    half_length, half_width = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    along, y = course.along_m + vehicle.l_r_m * cosine, course.y_m + vehicle.l_r_m * sine
    ahead, aside = half_length * cosine + half_width * np.abs(sine), half_length * np.abs(sine) + half_width * cosine
    counts: Bools = np.arange(along.shape[1])[None] <= course.end[:, None] + round(BEYOND_M / STEP_M)
    edges = np.minimum(y - aside - lane.left_m, lane.right_m - y - aside)
    apart = np.full(along.shape, np.inf)
    for face, left, right, length in zip(obstacles.along_m, obstacles.left_m, obstacles.right_m, length_m, strict=True):
        long, wide = 0.5 * length, 0.5 * (right - left)
        forward, across = face + long - along, left + wide - y
        own_forward, own_across = cosine * forward + sine * across, cosine * across - sine * forward
        own_long, own_wide = long * cosine + wide * np.abs(sine), long * np.abs(sine) + wide * cosine
        gap = np.maximum(np.abs(forward) - long - ahead, np.abs(across) - wide - aside)
        gap = np.maximum(gap, np.abs(own_forward) - own_long - half_length)
        gap = np.maximum(gap, np.abs(own_across) - own_wide - half_width)
        apart = np.minimum(apart, gap)
    return np.where(counts, apart, np.inf), np.where(counts, edges, np.inf).min(axis=1)
