"""Dubins candidates on the tightest curve from standstill, and their separation from obstacles.

From the road's direction a car at its full lock, of radius R of the rear axle, gets with the corner of its front, a
ahead of that axle and b beside it,

    (R + b) sin(theta) - a (1 - cos(theta)) ahead,    (R + b) (1 - cos(theta)) + a sin(theta) aside

while it turns by theta: never more than sqrt((R + b)^2 + a^2) - a ahead, and then as far aside as it likes. So a
candidate is a turn to an angle, a straight, and a turn back to the road's direction (L. E. Dubins, Am. J. Math. 79,
1957), at the rate of the steering.

Poses are of the rear axle, along and across the road, without the road's bend.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.recovery_config import CandidatesConfig
from vpf_sim.types import Bools, Floats, LateralExtents, VehicleModel

STEP_M = 0.1


@dataclass(frozen=True, slots=True)
class Candidates:
    """N candidates of T steps of `STEP_M`; `end` is the first step back in the road's direction, T where none is."""

    along_m: Floats  # (N, T) of the rear axle, from where the pose is now
    y_m: Floats  # (N, T)
    turned_rad: Floats  # (N, T) yaw from the road's direction, + right
    steering_rad: Floats  # (N, T)
    end: "np.typing.NDArray[np.intp]"  # (N,)

    def __len__(self) -> int:
        return len(self.end)

    def select(self, rows: "Bools | slice") -> "Candidates":
        """Some of them."""
        return Candidates(
            self.along_m[rows], self.y_m[rows], self.turned_rad[rows], self.steering_rad[rows], self.end[rows]
        )

    def one(self, index: int) -> "Candidates":
        """A single one of them, N = 1."""
        return self.select(slice(index, index + 1))

    def rest(self, step: int) -> "Candidates":
        """What is left of them after some steps."""
        row = slice(step, None)
        end = np.maximum(self.end - step, 0)
        return Candidates(
            self.along_m[:, row], self.y_m[:, row], self.turned_rad[:, row], self.steering_rad[:, row], end
        )


def candidates(
    lane: Lane, steering_rad: float, vehicle: VehicleModel, per_m: float, lock: float, config: CandidatesConfig
) -> Candidates:
    """All candidates from here with a share of the full lock; the steering turns `per_m` rad/m at most."""
    turn, wheels_straight = _turns(lane, steering_rad, vehicle, per_m, lock, config)
    steps = turn.along_m.shape[1]
    every = np.arange(len(turn))
    angle = turn.turned_rad[every, np.minimum(wheels_straight, steps - 1)]
    aside = np.maximum(np.abs(np.sin(angle)), config.aside_m / config.straight_m)
    count = np.where(wheels_straight < steps, (config.straight_m * aside / config.aside_m).astype(np.intp), 0) + 1
    row = np.repeat(every, count)
    nth = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    straight = np.round(nth * config.aside_m / aside[row] / STEP_M).astype(np.intp)[:, None]
    step, begin = np.arange(steps)[None], wheels_straight[row][:, None]
    source = row[:, None] * steps + np.where(step <= begin, step, np.maximum(step - straight, begin))
    gone = np.clip(step - begin, 0, straight) * STEP_M
    along, y, turned, steering = (
        part.ravel()[source] for part in (turn.along_m, turn.y_m, turn.turned_rad, turn.steering_rad)
    )
    along, y = along + gone * np.cos(angle[row])[:, None], y + gone * np.sin(angle[row])[:, None]
    return Candidates(along, y, turned, steering, np.minimum(turn.end[row] + straight[:, 0], steps))


def _turns(
    lane: Lane, steering_rad: float, vehicle: VehicleModel, per_m: float, lock: float, config: CandidatesConfig
) -> tuple[Candidates, "np.typing.NDArray[np.intp]"]:
    """The candidates without a straight, and the step of each at which one could begin: T where none can."""
    side, angle = (
        one.ravel() for one in np.meshgrid(np.array([-1.0, 1.0]), np.radians(config.angles_deg), indexing="ij")
    )
    count, steps = len(side), round(config.way_m / STEP_M)
    turned, steering = np.full(count, -lane.heading_rad), np.full(count, steering_rad)
    along, y = -vehicle.l_r_m * np.cos(turned), lane.y_m - vehicle.l_r_m * np.sin(turned)
    stage, straight = np.zeros(count, np.intp), np.full(count, steps)
    rows: list[tuple[Floats, Floats, Floats, Floats]] = []
    end, most = np.full(count, steps), per_m * STEP_M
    full = lock * vehicle.steering_limit_rad * side
    wishes = np.stack([full, -full, 0.0 * full])
    while len(rows) < steps and end.max() + 1 >= len(rows):
        rows.append((along, y, turned, steering))
        straightened = -np.log(np.cos(steering)) / vehicle.wheelbase_m / per_m  # rad, while the wheels are turned back
        turns_on = side * steering
        stage = stage + ((stage == 0) & (angle - side * turned <= straightened * (turns_on > 0.0)))
        straight = np.where((stage > 0) & (turns_on <= 0.0), np.minimum(straight, len(rows) - 1), straight)
        stage = stage + ((stage == 1) & (side * turned <= straightened * (turns_on < 0.0)))
        is_back = (stage == 2) & (np.abs(steering) < most)
        end = np.where(is_back, np.minimum(end, len(rows) - 1), end)
        before, steering = steering, steering + np.clip(wishes[stage, np.arange(count)] - steering, -most, most)
        bend = np.tan(0.5 * (before + steering)) / vehicle.wheelbase_m - lane.curvature_per_m
        bend = np.where(is_back, 0.0, bend)
        middle = turned + 0.5 * STEP_M * bend
        along, y = along + STEP_M * np.cos(middle), y + STEP_M * np.sin(middle)
        turned = turned + STEP_M * bend
    along, y, turned, steering = (np.stack(part, axis=1) for part in zip(*rows, strict=True))
    return Candidates(*_straight_on(along, y, turned, steering, steps - len(rows)), end), straight


def _straight_on(
    along_m: Floats, y_m: Floats, turned_rad: Floats, steering_rad: Floats, steps: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """Candidates that end straight, longer by some steps."""
    gone = STEP_M * np.arange(1, steps + 1)
    last, none = turned_rad[:, -1:], np.zeros((len(turned_rad), steps))
    return (
        np.concatenate([along_m, along_m[:, -1:] + gone * np.cos(last)], axis=1),
        np.concatenate([y_m, y_m[:, -1:] + gone * np.sin(last)], axis=1),
        np.concatenate([turned_rad, last + none], axis=1),
        np.concatenate([steering_rad, none], axis=1),
    )


@dataclass(frozen=True, slots=True)
class Blockers(LateralExtents):
    """K obstacles of which a candidate keeps clear, in lane coordinates."""

    along_m: Floats  # (K,) nearest face, from the pose
    left_m: Floats  # (K,) y of the left side
    right_m: Floats  # (K,) y of the right side
    length_m: Floats  # (K,) that they are taken to be long
    beyond_m: Floats  # (K,) how far past its end a candidate keeps clear of each

    @classmethod
    def of(cls, obstacles: LaneObstacles, length_m: float, beyond_m: float) -> "Blockers":
        """Obstacles with a least length, and how far past its end a candidate keeps clear of them."""
        length = np.maximum(obstacles.length_m, length_m)
        return cls(obstacles.along_m, obstacles.left_m, obstacles.right_m, length, np.full(len(obstacles), beyond_m))


def separation(
    candidates: Candidates, lane: Lane, blockers: Blockers, vehicle: VehicleModel, beyond_m: float, every: int = 1
) -> tuple[Floats, Floats]:
    """(N, T) m between the car and the nearest obstacle, and (N,) between the car and the edges.

    Rectangles are apart by the largest gap along any of their sides' directions. A candidate is checked until
    `beyond_m` past its end, at each of `every` steps.
    """
    look = slice(None, None, every)
    cosine, sine = np.cos(candidates.turned_rad[:, look]), np.sin(candidates.turned_rad[:, look])
    half_length, half_width = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    along, y = candidates.along_m[:, look] + vehicle.l_r_m * cosine, candidates.y_m[:, look] + vehicle.l_r_m * sine
    ahead, aside = half_length * cosine + half_width * np.abs(sine), half_length * np.abs(sine) + half_width * cosine
    past = np.arange(candidates.along_m.shape[1])[None, look] - candidates.end[:, None]
    edges = np.minimum(y - aside - lane.left_m, lane.right_m - y - aside)
    apart = np.full(along.shape, np.inf)
    sizes = (blockers.along_m, blockers.left_m, blockers.right_m, blockers.length_m, blockers.beyond_m)
    for face, left, right, length, beyond in zip(*sizes, strict=True):
        long, wide = 0.5 * length, 0.5 * (right - left)
        forward, across = face + long - along, left + wide - y
        own_forward, own_across = cosine * forward + sine * across, cosine * across - sine * forward
        own_long, own_wide = long * cosine + wide * np.abs(sine), long * np.abs(sine) + wide * cosine
        gap = np.maximum(np.abs(forward) - long - ahead, np.abs(across) - wide - aside)
        gap = np.maximum(gap, np.abs(own_forward) - own_long - half_length)
        gap = np.maximum(gap, np.abs(own_across) - own_wide - half_width)
        apart = np.where(past <= round(beyond / STEP_M), np.minimum(apart, gap), apart)
    return apart, edges.min(axis=1, where=past <= round(beyond_m / STEP_M), initial=np.inf)
