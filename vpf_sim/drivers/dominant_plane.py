"""Dominant plane and visual potential: navigation by optical flow alone, as published for indoor robots.

N. Ohnishi and A. Imiya, Dominant plane detection from optical flow for robot navigation, Pattern Recognition Letters
27(9), 2006; Corridor navigation and obstacle avoidance using visual potential for mobile robot, CRV 2007. The flow of a
grid is compared with that of the plane most points agree with (RANSAC); what agrees is ground, the rest obstacles. The
gradient of the smoothed binary plane repels from obstacles, and the direction to the goal attracts.

Three things differ, since a car is faster than the robot and its camera sees farther: the plane's motion is a
homography, not affine; deviations from it are summed over about a metre; the gradient is averaged over the corridor
that the car sweeps, not over the image, where trees beside the road outweigh a car on it.

Where it fails: it knows no road. Verges lie in the plane, so that the goal draws it off the road in the first bend. An
obstacle dead ahead has no gradient, so it passes late, or stops and stays. docs/decisions.md has the figures.
"""

from dataclasses import dataclass
from math import atan2

import cv2
import numpy as np

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
from vpf_sim.geometry import ground_from_pixels, horizon_px, vehicle_from_world
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Bools, Camera, Floats, Image, VehicleModel

FRAME_HZ = 20.0
SPACING_PX = (20, 10)  # of the grid, across and down
BELOW_HORIZON_PX = 14  # where the grid begins: 32 m ahead
WINDOW_PX, LEVELS = (15, 15), 3  # of Lucas-Kanade
RETURN_PX = 0.5  # a point is followed to the frame before and back to within this
AGREEMENT_PX = 1.0  # with the plane's motion, from frame to frame
LEAST_POINTS, LEAST_SHARE = 40, 0.5  # of the plane: it is dominant
STEP_PX, BASELINE_PX, MOST_FRAMES = 4.0, 60.0, 20  # flow of the near ground, from frame to frame and in all: 1 m
DEVIATION_PX, DEVIATION_SHARE = 0.6, 0.03  # from the plane's motion over the baseline: an obstacle
SIGMA = 2.0  # cells, of the Gaussian
AHEAD_M, BESIDE_M = (2.5, 20.0), 2.0  # the corridor
REPULSION, ATTRACTION = 6.0, 1.0
STEERING = 0.8  # of the front wheels, per rad of the direction
MOST_GOAL_RAD = 0.3
SMOOTHING = 0.25  # weight of the newest direction
FULL_SPEED_SHARE, STOP_SHARE = 0.9, 0.6  # of the corridor that is plane
SPEED_GAIN = 1.0  # throttle per m/s


@dataclass(frozen=True, slots=True)
class Potential:
    """The smoothed plane on the grid, and its gradient to the right in units of 1 / sigma; both (rows, columns)."""

    level: Floats  # 0 obstacle to 1 plane
    right: Floats


def plane_motion(points_px: Floats, moved_px: Floats) -> tuple[Floats, Bools] | None:
    """The homography of the plane that most points lie on, and (N,) which ones; None if no plane is dominant."""
    if len(points_px) < LEAST_POINTS:
        return None
    motion, found = cv2.findHomography(
        points_px.astype(np.float32), moved_px.astype(np.float32), cv2.RANSAC, AGREEMENT_PX
    )
    if motion is None or found.sum() < LEAST_SHARE * len(points_px):
        return None
    return np.asarray(motion, float), found.ravel() == 1


def potential(plane: Floats) -> Potential:
    """The visual potential of (rows, columns) cells: 1 plane, 0 obstacle, nan unknown, which their neighbours fill."""
    known = np.isfinite(plane)
    weight = cv2.GaussianBlur(known.astype(float), (0, 0), SIGMA, borderType=cv2.BORDER_REPLICATE)
    total = cv2.GaussianBlur(np.where(known, plane, 0.0), (0, 0), SIGMA, borderType=cv2.BORDER_REPLICATE)
    level = np.where(weight > 1e-3, total / np.maximum(weight, 1e-3), 1.0)
    return Potential(level, SIGMA * np.gradient(level, axis=1))


class PlaneDetector:
    """Finds which points of a grid below the horizon lie on the dominant plane, frame by frame."""

    def __init__(self, camera: Camera) -> None:
        across, down = SPACING_PX
        columns = np.arange(across // 2, camera.width_px, across, dtype=float)
        rows = np.arange(horizon_px(camera) + BELOW_HORIZON_PX, camera.height_px - down // 2, down)
        self.shape = len(rows), len(columns)
        self.points_px: Floats = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        self._near: Bools = np.arange(len(self.points_px)) >= len(self.points_px) // 2  # the lower half
        self._past: list[tuple[Image, Floats]] = []  # frames, and the plane's motion from now to then
        self.plane: Floats = np.ones(self.shape)  # 1 plane, 0 obstacle, nan unknown

    def update(self, image: Image) -> None:
        """Use a new frame, (H, W) grey; without a dominant plane, and without motion, `plane` stays."""
        if not self._past:
            self._past.append((image, np.eye(3)))
            return
        found = self._motion(image, self._past[-1][0])
        if found is None:
            self._past.clear()
        elif self._flow_px(found) >= STEP_PX:
            moved = [(frame, motion @ found) for frame, motion in self._past[-MOST_FRAMES:]]
            long = [k for k, (_, motion) in enumerate(moved) if self._flow_px(motion) >= BASELINE_PX]
            if long:
                moved = moved[long[-1] :]
                self._compare(image, *moved[0])
            self._past = [*moved, (image, np.eye(3))]

    def _flow_px(self, motion: Floats) -> float:
        """Median flow of the near ground."""
        near = self.points_px[self._near]
        return float(np.median(np.linalg.norm(_carried(near, motion) - near, axis=1)))

    def _motion(self, now: Image, before: Image) -> Floats | None:
        """The plane's motion from this frame back to the one before."""
        back, is_followed = _followed(now, before, self.points_px)
        again, is_back = _followed(before, now, back)
        good = is_followed & is_back & (np.abs(again - self.points_px).max(axis=1) < RETURN_PX)
        found = plane_motion(self.points_px[good], back[good])
        return None if found is None else found[0]

    def _compare(self, now: Image, then: Image, motion: Floats) -> None:
        """Warp an earlier frame as if all of it were the plane: what still moves is not on it."""
        flow_px = np.linalg.norm(_carried(self.points_px, motion) - self.points_px, axis=1)
        warped = cv2.warpPerspective(then, motion, now.shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        moved, is_followed = _followed(now, np.asarray(warped, np.uint8), self.points_px)
        is_plane = np.linalg.norm(moved - self.points_px, axis=1) < DEVIATION_PX + DEVIATION_SHARE * flow_px
        self.plane = np.where(is_followed, is_plane, np.nan).reshape(self.shape)


def _carried(points_px: Floats, motion: Floats) -> Floats:
    """Points moved by a homography."""
    return np.asarray(cv2.perspectiveTransform(points_px.reshape(-1, 1, 2), motion).reshape(-1, 2), float)


def _followed(image: Image, other: Image, points_px: Floats) -> tuple[Floats, Bools]:
    """Where points of an image are in another one, and which were found."""
    start = points_px.reshape(-1, 1, 2).astype(np.float32)
    moved, status, _ = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload]
        image, other, start, None, winSize=WINDOW_PX, maxLevel=LEVELS
    )
    return moved.reshape(-1, 2).astype(float), status.ravel() == 1


class DominantPlaneDriver(Driver):
    """Goes where the ground is free, by optical flow, towards the goal."""

    def reset(self, setup: DriverSetup) -> None:
        self._vehicle: VehicleModel = setup.vehicle
        self._speed_reference_mps = setup.speed_reference_mps
        self._detector = PlaneDetector(setup.camera)
        ground_m = ground_from_pixels(setup.camera, self._detector.points_px)
        near_m, far_m = AHEAD_M
        ahead = (ground_m[:, 0] > near_m) & (ground_m[:, 0] < far_m) & (np.abs(ground_m[:, 1]) < BESIDE_M)
        corridor = ahead.reshape(self._detector.shape).astype(float)
        count = corridor.sum(axis=1, keepdims=True)
        rows = max(1, int((count > 0.0).sum()))
        self._corridor: Floats = corridor / np.maximum(count, 1.0) / rows  # each row counts the same
        self._side, self._share = 0.0, 1.0
        self._schedule = Schedule(1.0 / FRAME_HZ, setup.rate_hz)

    @property
    def needs_next_frame(self) -> bool:
        """Whether it observes at the next step."""
        return self._schedule.is_due

    def act(self, observation: Observation) -> Command:
        if self._schedule.step():
            self._observe(observation.image)
        return Command(self._throttle(observation.speed_mps), self._steering(observation))

    def _observe(self, image: Image) -> None:
        if not self._corridor.any() or self._detector.shape[1] < 2:
            return  # the camera does not show what is ahead
        self._detector.update(grey(image))
        field = potential(self._detector.plane)
        self._side += SMOOTHING * (float((field.right * self._corridor).sum()) - self._side)
        self._share = float((field.level * self._corridor).sum())

    def _steering(self, observation: Observation) -> float:
        """Towards the sum of the attraction of the goal and the repulsion of obstacles."""
        forward_m, right_m = vehicle_from_world(np.array(observation.goal_m), observation.pose).tolist()
        goal_rad = min(max(atan2(right_m, forward_m), -MOST_GOAL_RAD), MOST_GOAL_RAD)
        direction_rad = atan2(ATTRACTION * np.sin(goal_rad) + REPULSION * self._side, ATTRACTION * np.cos(goal_rad))
        return min(max(STEERING * direction_rad / self._vehicle.steering_limit_rad, -1.0), 1.0)

    def _throttle(self, speed_mps: float) -> float:
        """Slower, the less of the corridor is plane."""
        free = (self._share - STOP_SHARE) / (FULL_SPEED_SHARE - STOP_SHARE)
        wanted_mps = self._speed_reference_mps * min(max(free, 0.0), 1.0)
        return min(max(SPEED_GAIN * (wanted_mps - speed_mps), -1.0), 1.0)
