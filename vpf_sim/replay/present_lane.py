"""The lane that the recorded car drives in, and whether the images support it.

A driver keeps to the lane in which it began (`perception.road.edge_tracker`); the human on a recording changes lanes.
So only the lines beside the car are used: the lane nearest to the car is the one to keep. Without a lane the model
car holds course and speed (`open_loop_driver`).

A tracker predicts a lane where it finds none, and fits one to textures, reflections and the light of head lamps. So the
image is read again along both lines: averaged over their rows and over a second, the grain of a road and lights vanish,
and a line is a narrow peak.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import sin

import cv2
import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.types import Camera, Floats, Image, Obstacles, RoadEdges

LEAST_CONFIDENCE = 0.5  # of its lines, below which the lane is rejected
FASTEST_ACROSS_MPS = 1.0  # lateral speed, above which the lines are wrong
MOST_ACROSS_MPS2 = 5.0  # lateral acceleration in the bend ahead
SLOW_MPS = 2.0  # below this the flow shows no obstacle ahead,
SLOW_BEND_PER_M = 0.01  # and its outline may look like lines of a bend this tight
MEMORY_S = 1.0
ASIDE_M, ON_LINE_M = 1.3, 0.3  # of the profile across a line; of the line in it
CLIPPED_LEVELS = 30.0  # so that a single glare does not count as a line
LEAST_SNR = 3.0  # height of the mean peak over the scatter beside the line
PAINT_LEVELS, CLEAR_LEVELS = 1.2, 4.0  # mean peak of paint beside other paint, and beside an edge
EDGE_LEVELS = 6.0  # of the mean step at an edge
NOISE_LEVELS = 0.05
LEAST_ROWS = 10  # that show a line
BENT_M = 0.3  # deviation in the far half, above which a bend needs support there


def is_found(road: RoadEdges, speed_mps: float) -> bool:
    """Whether these lines can be those of the lane that the car drives in."""
    if road.lane_confidence < LEAST_CONFIDENCE or abs(speed_mps * sin(road.heading_rad)) > FASTEST_ACROSS_MPS:
        return False
    bend = abs(road.curvature_per_m)
    return bend <= (SLOW_BEND_PER_M if speed_mps < SLOW_MPS else MOST_ACROSS_MPS2 / speed_mps**2)


def present_lane(road: RoadEdges, found: bool) -> RoadEdges:
    """Road edges whose own lane is the one nearest to the car.

    Their confidence is that of the lane. Without a lane it is 0, and the edges lie straight ahead at their distance
    apart.
    """
    if not found:
        reach = 0.5 * (road.right_m - road.left_m)
        ahead = replace(road, left_m=-reach, right_m=reach, lane_m=0.0, oncoming_m=0.0)
        return replace(ahead, heading_rad=0.0, curvature_per_m=0.0, confidence=0.0)
    half = 0.5 * road.lane_width_m
    middle = (road.lane_m + half) % road.lane_width_m - half
    left, right = min(road.left_m, middle - half), max(road.right_m, middle + half)
    beyond = max(road.oncoming_m + left - road.left_m, 0.0)
    return replace(road, lane_m=middle, left_m=left, right_m=right, oncoming_m=beyond, confidence=road.lane_confidence)


def road_in_vehicle_frame(road: RoadEdges, right_m: float, turn_rad: float) -> RoadEdges:
    """The edges from a vehicle `right_m` right of the pose and rotated by `turn_rad`."""
    return replace(
        road,
        left_m=road.left_m - right_m,
        right_m=road.right_m - right_m,
        lane_m=road.lane_m - right_m,
        heading_rad=road.heading_rad - turn_rad,
    )


def obstacles_in_vehicle_frame(obstacles: Obstacles, right_m: float, turn_rad: float) -> Obstacles:
    """The obstacles from the same vehicle; their faces stay perpendicular to its axis."""

    def turned(forward: Floats, right: Floats) -> tuple[Floats, Floats]:
        cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
        return cosine * forward + sine * right, cosine * right - sine * forward

    middle, half = obstacles.middle_m - right_m, 0.5 * obstacles.width_m
    forward, across = turned(obstacles.forward_m, middle)
    return replace(obstacles, forward_m=forward, left_m=across - half, right_m=across + half)


@dataclass(frozen=True, slots=True)
class _Profiles:
    """Contrasts across the left and the right line in one frame, grey levels; nan outside of the image."""

    time_s: float
    paint: Floats  # (2, R, O) brighter than both sides
    edge: Floats  # (2, R, O) brighter than the left side less than the right side
    is_bent: bool


class LaneSupport:
    """Reads the images along the lines of the lane."""

    def __init__(self, camera: Camera, config: RoadEdgeConfig, fixed: FixedStructure | None = None) -> None:
        self._view = BirdsEye(camera, config.patch)
        self._reach = round(config.ridge_reach_m / config.column_m)
        self._offsets_m = np.arange(-ASIDE_M, ASIDE_M + 1e-9, config.column_m)
        self._fixed = fixed
        self._recent: deque[_Profiles] = deque()
        self._supported: deque[bool] = deque()  # as long

    def forget(self) -> None:
        """Start anew: there is no lane to support."""
        self._recent.clear()
        self._supported.clear()

    def update(self, image_rgb: Image, road: RoadEdges, time_s: float) -> bool:
        """Whether paint or an edge supports both lines of the own lane, in most of the last second up to this image."""
        self._recent.append(self._profiles(image_rgb, road, time_s))
        while self._recent[0].time_s < time_s - MEMORY_S:
            self._recent.popleft()
            self._supported.popleft()
        paint = np.stack([one.paint for one in self._recent])
        edge = np.stack([one.edge for one in self._recent])
        far = self._view.forward_m > np.median(self._view.forward_m)
        parts = [np.ones_like(far), far] if self._recent[-1].is_bent else [np.ones_like(far)]
        self._supported.append(all(self._is_supported(paint[:, :, rows], edge[:, :, rows]) for rows in parts))
        return 2 * sum(self._supported) > len(self._supported)

    def _is_supported(self, paint: Floats, edge: Floats) -> bool:
        """By profiles (N, 2, R, O) of the last second: one line is paint, the other paint or an edge."""
        painted = [self._has_peak(paint[:, side], PAINT_LEVELS) for side in range(2)]
        if all(painted):
            return True
        clear = [self._has_peak(paint[:, side], CLEAR_LEVELS) for side in range(2)]
        step = np.abs(_mean(edge))[:, None, None]
        edged = [self._has_peak(step[side], EDGE_LEVELS) for side in range(2)]
        return (clear[0] and edged[1]) or (clear[1] and edged[0])

    def _has_peak(self, values: Floats, least_levels: float) -> bool:
        """Whether the mean of profiles (N, R, O) has a peak on the line."""
        if np.count_nonzero(np.isfinite(values).any(axis=(0, 2))) < min(LEAST_ROWS, values.shape[1]):
            return False
        mean = _mean(values)
        on_line = np.abs(self._offsets_m) <= ON_LINE_M
        beside = mean[~on_line & np.isfinite(mean)]
        if not len(beside) or not np.isfinite(mean[on_line]).any():
            return False
        height = float(np.nanmax(mean[on_line]))
        usual = float(np.median(beside))
        scatter = 1.48 * float(np.median(np.abs(beside - usual))) + NOISE_LEVELS
        return height > least_levels and height - usual > LEAST_SNR * scatter

    def _profiles(self, image_rgb: Image, road: RoadEdges, time_s: float) -> _Profiles:
        grey = cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY).astype(np.uint8, copy=False)
        patch = self._view.warp(grey if self._fixed is None else self._fixed.filled(grey)).astype(float)
        ahead = self._view.forward_m
        bend_m = 0.5 * road.curvature_per_m * ahead**2
        middle = road.lane_m + ahead * np.tan(road.heading_rad) + bend_m
        lines = middle + np.array([[-0.5], [0.5]]) * road.lane_width_m  # (2, R)
        places = np.rint((lines[..., None] + self._offsets_m - self._view.right_m[0]) / self._view.column_m)
        last = patch.shape[1] - 1 - self._reach
        inside = (places >= self._reach) & (places <= last)
        columns = np.clip(places, self._reach, last).astype(np.intp)
        rows = np.arange(len(ahead))[:, None]
        inside &= self._view.visible[rows, columns]
        centre, left, right = (patch[rows, columns + shift] for shift in (0, -self._reach, self._reach))
        paint, edge = np.minimum(centre - left, centre - right), left - right
        paint, edge = (np.where(inside, np.clip(one, -CLIPPED_LEVELS, CLIPPED_LEVELS), np.nan) for one in (paint, edge))
        return _Profiles(time_s, paint, edge, bool(np.abs(bend_m).max(initial=0.0) > BENT_M))


def _mean(values: Floats) -> Floats:
    """Mean over all axes but those of lines (if there are four) and offsets, of what is known; nan without."""
    axes = (0, 2) if values.ndim == 4 else (0, 1)
    known = np.isfinite(values)
    count = known.sum(axis=axes)
    return np.where(count > 0, np.where(known, values, 0.0).sum(axis=axes) / np.maximum(count, 1), np.nan)
