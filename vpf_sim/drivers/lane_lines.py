"""Lane lines, Stanley steering and a brake by time to contact: the classical pipeline of driver assistance.

Lines are bright ridges of a bird's-eye view (M. Bertozzi and A. Broggi, GOLD, IEEE Trans. Image Processing 7(1), 1998),
collected by sliding windows from a pair one lane apart, and fitted by two parallel parabolas. Steering is Stanley's law
(Thrun et al. 2006, eq. 10) with the curvature fed forward. The brake uses the divergence of the flow ahead,
time to contact = 2 / divergence (T. Camus, Real-Time Quantized Optical Flow, 1995). It keeps its lane,
brakes for good before cars, often too late for a moving one, and does not see low obstacles.
"""

from collections import deque
from dataclasses import astuple, dataclass, replace
from itertools import pairwise
from math import atan, atan2, inf, tan

import cv2
import numpy as np

from vpf_sim.controllers.pid import SpeedPid
from vpf_sim.controllers.pid import load_gains as pid_gains
from vpf_sim.controllers.stanley import load_gains
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
from vpf_sim.geometry import distance_m, project, wrap_angle
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.types import Bools, Camera, Floats, Image, VehicleModel

FRAME_HZ = 20.0
NEAR_M, FAR_M, ASIDE_M = 4.0, 24.0, 6.0  # of the bird's-eye view
AHEAD_PX_PER_M, ASIDE_PX_PER_M = 5.0, 12.0
LINE_M = 0.3  # a ridge is brighter than the road this far left and right of it
LEAST_CONTRAST = 14.0  # grey levels
LANES_M = np.arange(2.8, 4.01, 0.1)
WINDOWS, WINDOW_M = 8, 0.35  # count and half width
LEAST_POINTS = 25
SMOOTHING = 0.35  # weight of the newest lane
BOX_AHEAD_M = 9.0  # where the watched box is as wide as the car
BASELINE = 4  # frames over which growth is measured
BRAKE_TTC_S, CONFIRMING = 1.8, 2  # s, frames
MOST_POINTS, FEWEST_POINTS = 60, 8
SMALLEST_PX = 16  # of a box with points


@dataclass(frozen=True, slots=True)
class LaneFit:
    """The lane's centre, vehicle axes: right of the car, direction and curvature, + to the right."""

    right_m: float
    heading_rad: float
    curvature_per_m: float
    width_m: float

    def at_m(self, forward_m: Floats | float) -> Floats | float:
        """Right of the car, at a distance ahead."""
        return self.right_m + tan(self.heading_rad) * forward_m + 0.5 * self.curvature_per_m * forward_m**2

    def lines_m(self, forward_m: float) -> tuple[float, float]:
        """Left and right line at a distance ahead."""
        centre_m = float(self.at_m(forward_m))
        return centre_m - 0.5 * self.width_m, centre_m + 0.5 * self.width_m

    def predict(self, driven_m: float, turned_rad: float) -> "LaneFit":
        """The lane seen from a car that has driven on and turned to the right."""
        heading_rad = self.heading_rad + self.curvature_per_m * driven_m - turned_rad
        right_m = self.right_m + 0.5 * (self.heading_rad + heading_rad) * driven_m
        return replace(self, right_m=right_m, heading_rad=heading_rad)

    def blend(self, other: "LaneFit", weight: float) -> "LaneFit":
        """This lane with a share of another's values."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return LaneFit(*(mine + weight * (theirs - mine) for mine, theirs in pairs))


class BirdsEye:
    """A view of the road from above: rows from far to near, columns from left to right."""

    def __init__(self, camera: Camera) -> None:
        self.size = round(2.0 * ASIDE_M * ASIDE_PX_PER_M), round((FAR_M - NEAR_M) * AHEAD_PX_PER_M)
        width, height = self.size
        ahead_m, aside_m = np.array([FAR_M, FAR_M, NEAR_M, NEAR_M]), ASIDE_M * np.array([-1.0, 1.0, 1.0, -1.0])
        frame_px = project(camera, np.stack([ahead_m, aside_m, np.zeros(4)], axis=-1))
        above_px = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32) - 0.5
        self._to_above = cv2.getPerspectiveTransform(frame_px.astype(np.float32), above_px)

    def of(self, image: Image) -> Floats:
        """(rows, columns) grey levels of a frame."""
        above: Floats = cv2.warpPerspective(grey(image), self._to_above, self.size).astype(np.float32)
        return above

    @staticmethod
    def metres(rows: Floats, columns: Floats) -> tuple[Floats, Floats]:
        """Forward and right of pixels' centres."""
        return FAR_M - (rows + 0.5) / AHEAD_PX_PER_M, (columns + 0.5) / ASIDE_PX_PER_M - ASIDE_M


def ridges(above: Floats) -> Bools:
    """Where a pixel is brighter than the road on both sides of it."""
    shift = round(LINE_M * ASIDE_PX_PER_M)
    smooth = cv2.blur(above, (3, 3))
    beside = np.maximum(np.roll(smooth, shift, axis=1), np.roll(smooth, -shift, axis=1))
    found: Bools = smooth - beside > LEAST_CONTRAST
    found[:, :shift] = found[:, -shift:] = False
    return found


def fit_lane(found: Bools, expected: LaneFit | None) -> LaneFit | None:
    """The lane around the car, or around where it is expected; None without points on a line.

    A lane that is expected needs one of its lines, since its width is known.
    """
    forward_m, right_m = BirdsEye.metres(*(index.astype(float) for index in np.nonzero(found)))
    pair = _pair(right_m[forward_m < 0.5 * (NEAR_M + FAR_M)]) if expected is None else expected.lines_m(NEAR_M)
    if pair is None:
        return None
    lines = [_follow(forward_m, right_m, start, expected) for start in pair]
    strong = [line.sum() >= LEAST_POINTS for line in lines]
    if not (any(strong) if expected else all(strong)):
        return None
    width_m = pair[1] - pair[0] if expected is None else expected.width_m
    left, right = (line if is_strong else np.zeros_like(line) for line, is_strong in zip(lines, strong, strict=True))
    either = left | right
    s, side = forward_m[either], np.where(left[either], -0.5, 0.5)
    free = [side] if all(strong) else []  # the width
    columns = np.stack([np.ones_like(s), s, 0.5 * s**2, *free], axis=1)
    known = 0.0 if free else side * width_m
    values = np.linalg.lstsq(columns, right_m[either] - known, rcond=None)[0].tolist()
    return LaneFit(values[0], atan(values[1]), values[2], values[3] if free else width_m)


def _pair(right_m: Floats) -> tuple[float, float] | None:
    """Where the two lines of the lane begin, by the best pair of columns one lane apart."""
    edges = np.arange(-ASIDE_M, ASIDE_M + 0.05, 0.1)
    counts = np.convolve(np.histogram(right_m, edges)[0], np.ones(3), mode="same")
    best, pair = 0.0, None
    for centre in np.arange(-1.0, 1.01, 0.1).tolist():
        for width in LANES_M.tolist():
            ends = centre - 0.5 * width, centre + 0.5 * width
            both = [counts[min(max(int((end + ASIDE_M) / 0.1), 0), len(counts) - 1)] for end in ends]
            score = float(min(both) + 0.1 * sum(both))
            if min(both) > 0 and score > best:
                best, pair = score, ends
    return pair


def _follow(forward_m: Floats, right_m: Floats, start_m: float, expected: LaneFit | None) -> Bools:
    """The points of the line that begins at `start_m`, by windows that move with it, or along the expected lane."""
    if expected is not None:
        off_m = right_m - (expected.at_m(forward_m) - expected.at_m(NEAR_M) + start_m)
        return np.abs(off_m) < WINDOW_M
    member, at_m = np.zeros(len(forward_m), np.bool_), start_m
    for low, high in pairwise(np.linspace(NEAR_M, FAR_M, WINDOWS + 1)):
        inside = (forward_m >= low) & (forward_m < high) & (np.abs(right_m - at_m) < WINDOW_M)
        member |= inside
        at_m = float(np.median(right_m[inside])) if inside.sum() >= 3 else at_m
    return member


class ContactBrake:
    """Times to contact with what is ahead, by the growth of its image over a few frames.

    The box that is watched lies at the width of the car; its parts overlap, since a background that does not grow
    outweighs an obstacle that covers a small part.
    """

    def __init__(self, camera: Camera) -> None:
        corners = project(camera, np.array([(BOX_AHEAD_M, -1.3, 1.6), (BOX_AHEAD_M, 1.3, 0.4)]))
        size = [camera.width_px, camera.height_px]
        self._box = np.clip(np.round(corners).astype(int), 0, size).ravel().tolist()
        self._seen: deque[tuple[float, Image]] = deque(maxlen=BASELINE + 1)  # time s, grey box
        self._alarms = 0

    def alarm(self, image: Image, time_s: float) -> bool:
        """Whether several frames in a row show a contact within `BRAKE_TTC_S`."""
        left, top, right, bottom = self._box
        if right - left < SMALLEST_PX or bottom - top < SMALLEST_PX:
            return False  # the camera does not show what is ahead
        self._seen.append((time_s, grey(image[top:bottom, left:right])))
        (then_s, then), (now_s, now) = self._seen[0], self._seen[-1]
        width = then.shape[1]
        parts = [slice(k * width // 4, (k + 2) * width // 4) for k in range(3)]
        is_near = len(self._seen) > BASELINE and any(
            _ttc_s(then, now, part, now_s - then_s) < BRAKE_TTC_S for part in parts
        )
        self._alarms = self._alarms + 1 if is_near else 0
        return self._alarms >= CONFIRMING


def _ttc_s(then: Image, now: Image, columns: slice, elapsed_s: float) -> float:
    """Time to contact by a similarity between some columns of two images; inf where too few points agree."""
    mask = np.zeros_like(then)
    mask[:, columns] = 255
    points = cv2.goodFeaturesToTrack(then, MOST_POINTS, 0.02, 4, mask=mask)
    if points is None or len(points) < FEWEST_POINTS:
        return inf
    moved, status, _ = cv2.calcOpticalFlowPyrLK(then, now, points, None)  # type: ignore[call-overload]
    good = status.ravel() == 1
    if good.sum() < FEWEST_POINTS:
        return inf
    similarity, inliers = cv2.estimateAffinePartial2D(points[good], moved[good], ransacReprojThreshold=1.0)
    if similarity is None or inliers.sum() < max(FEWEST_POINTS, 0.4 * len(points)):
        return inf
    growth = float(np.hypot(similarity[0, 0], similarity[1, 0])) - 1.0  # half the divergence, times the time
    return elapsed_s / growth if growth > 1e-4 else inf


class LaneLinesDriver(Driver):
    """Keeps its lane by the painted lines, and brakes for what it comes near."""

    def reset(self, setup: DriverSetup) -> None:
        self._vehicle: VehicleModel = setup.vehicle
        self._gains = load_gains()
        self._speed = SpeedPid(pid_gains(), setup.speed_reference_mps, setup.rate_hz)
        self._above, self._brake = BirdsEye(setup.camera), ContactBrake(setup.camera)
        self._camera = setup.camera
        self._lane: LaneFit | None = None
        self._pose = np.zeros(3)  # x m, y m, yaw rad at the last frame
        self._frame_s, self._stopping = -inf, False

    def act(self, observation: Observation) -> Command:
        if observation.frame_time_s - self._frame_s > 0.9 / FRAME_HZ:
            self._frame_s = observation.frame_time_s
            self._observe(observation)
        throttle = -1.0 if self._stopping else self._speed.throttle(observation.speed_mps)
        return Command(throttle, self._steer(observation.speed_mps))

    def _observe(self, observation: Observation) -> None:
        pose = observation.pose
        if self._lane is not None:
            turned_rad = wrap_angle(float(pose[2] - self._pose[2]))
            self._lane = self._lane.predict(distance_m(pose, self._pose), turned_rad)
        self._pose = pose
        found = fit_lane(ridges(self._above.of(observation.image)), self._lane)
        if found is not None:
            self._lane = found if self._lane is None else self._lane.blend(found, SMOOTHING)
        self._stopping |= self._brake.alarm(observation.image, observation.frame_time_s)

    def _steer(self, speed_mps: float) -> float:
        """Stanley's law at the front axle, with the bend's steering angle in advance."""
        if self._lane is None:
            return 0.0
        axle_m, lane = self._vehicle.l_f_m, self._lane
        right_m = lane.right_m + axle_m * lane.heading_rad
        angle = lane.heading_rad + atan2(self._gains.k_per_s * right_m, self._gains.softening_mps + speed_mps)
        angle += atan(self._vehicle.wheelbase_m * lane.curvature_per_m)
        return min(max(angle / self._vehicle.steering_limit_rad, -1.0), 1.0)
