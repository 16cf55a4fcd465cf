"""Lane lines, Stanley steering and a brake by time to contact: the classical pipeline of driver assistance.

Lines are bright ridges of a bird's-eye view (M. Bertozzi and A. Broggi, GOLD, IEEE Trans. Image Processing 7(1), 1998),
collected by sliding windows from a pair one lane apart, and fitted by two parallel parabolas. Steering is Stanley's law
(Thrun et al. 2006, eq. 10) with the curvature fed forward. The brake uses the divergence of the flow ahead,
time to contact = 2 / divergence (T. Camus, Real-Time Quantized Optical Flow, 1995). It keeps its lane and stops; it does
not pass obstacles.
"""

from dataclasses import dataclass
from math import atan, atan2, inf

import cv2
import numpy as np

from vpf_sim.controllers.pid import SpeedPid
from vpf_sim.controllers.pid import load_gains as pid_gains
from vpf_sim.controllers.stanley import load_gains
from vpf_sim.geometry import project
from vpf_sim.types import Bools, Camera, Command, Driver, DriverSetup, Floats, Image, Observation, VehicleModel

FRAME_HZ = 20.0
NEAR_M, FAR_M, ASIDE_M = 4.0, 24.0, 6.0  # of the bird's-eye view
AHEAD_PX_PER_M, ASIDE_PX_PER_M = 5.0, 12.0
LINE_M = 0.3  # a ridge is brighter than the road this far left and right of it
LEAST_CONTRAST = 14.0  # grey levels
LANES_M = np.arange(2.8, 4.01, 0.1)
WINDOWS, WINDOW_M = 8, 0.35  # count and half width
LEAST_POINTS = 25
SMOOTHING = 0.35  # weight of the newest lane
BRAKE_TTC_S, CONFIRMING = 2.0, 3  # frames


@dataclass(frozen=True, slots=True)
class LaneFit:
    """The lane's centre, vehicle axes: right of the car, direction and curvature, + to the right."""

    right_m: float
    heading_rad: float
    curvature_per_m: float
    width_m: float


class BirdsEye:
    """A view of the road from above: rows from far to near, columns from left to right."""

    def __init__(self, camera: Camera) -> None:
        self.size = round(2.0 * ASIDE_M * ASIDE_PX_PER_M), round((FAR_M - NEAR_M) * AHEAD_PX_PER_M)
        width, height = self.size
        ahead_m, aside_m = np.array([FAR_M, FAR_M, NEAR_M, NEAR_M]), ASIDE_M * np.array([-1.0, 1.0, 1.0, -1.0])
        frame_px = project(camera, np.stack([ahead_m, aside_m, np.zeros(4)], axis=-1))
        above_px = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32)
        self._to_above = cv2.getPerspectiveTransform(frame_px.astype(np.float32), above_px)

    def of(self, image: Image) -> Floats:
        """(rows, columns) grey levels of a frame."""
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        above: Floats = cv2.warpPerspective(grey, self._to_above, self.size).astype(np.float32)
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
    """The lane around the car, or around where it is expected; None without points on both lines."""
    forward_m, right_m = BirdsEye.metres(*(index.astype(float) for index in np.nonzero(found)))
    pair = _pair(right_m[forward_m < 0.5 * (NEAR_M + FAR_M)], expected)
    if pair is None:
        return None
    left, right = (_follow(forward_m, right_m, start) for start in pair)
    if min(left.sum(), right.sum()) < LEAST_POINTS:
        return None
    either = left | right
    s, y = forward_m[either], right_m[either]
    columns = np.stack([left[either], right[either], s, 0.5 * s**2], axis=1).astype(float)
    left_m, right_side_m, heading, curvature = np.linalg.lstsq(columns, y, rcond=None)[0].tolist()
    return LaneFit(0.5 * (left_m + right_side_m), atan(heading), curvature, right_side_m - left_m)


def _pair(right_m: Floats, expected: LaneFit | None) -> tuple[float, float] | None:
    """Where the two lines of the lane begin, by the best pair of columns one lane apart."""
    edges = np.arange(-ASIDE_M, ASIDE_M + 0.05, 0.1)
    counts = np.convolve(np.histogram(right_m, edges)[0], np.ones(3), mode="same")
    centres = np.arange(-1.0, 1.01, 0.1) if expected is None else expected.right_m + np.arange(-0.4, 0.41, 0.1)
    best, pair = 0.0, None
    for centre in centres.tolist():
        for width in LANES_M.tolist():
            ends = centre - 0.5 * width, centre + 0.5 * width
            both = [counts[min(max(int((end + ASIDE_M) / 0.1), 0), len(counts) - 1)] for end in ends]
            score = float(min(both) + 0.1 * sum(both))
            if min(both) > 0 and score > best:
                best, pair = score, ends
    return pair


def _follow(forward_m: Floats, right_m: Floats, start_m: float) -> Bools:
    """The points of the line that begins at `start_m`, by windows that move with it."""
    member, at_m, drift_m = np.zeros(len(forward_m), np.bool_), start_m, 0.0
    ends = np.linspace(NEAR_M, FAR_M, WINDOWS + 1)
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        inside = (forward_m >= low) & (forward_m < high) & (np.abs(right_m - at_m) < WINDOW_M)
        member |= inside
        if inside.sum() >= 3:
            found_m = float(np.median(right_m[inside]))
            drift_m = found_m - at_m + drift_m if low > NEAR_M else 0.0
            at_m = found_m
        at_m += drift_m
    return member


class ContactBrake:
    """Time to contact with what is ahead, by the divergence of the flow around the heading."""

    def __init__(self, camera: Camera) -> None:
        corners = project(camera, np.array([(18.0, -1.4, 1.5), (18.0, 1.4, 0.3)]))
        self._box = tuple(np.round(corners).astype(int).ravel().tolist())
        self._last: Image | None = None
        self._alarms = 0

    def alarm(self, image: Image, elapsed_s: float) -> bool:
        """Whether several frames in a row show a contact within `BRAKE_TTC_S`."""
        left, top, right, bottom = self._box
        grey = cv2.cvtColor(image[top:bottom, left:right], cv2.COLOR_RGB2GRAY)
        last, self._last = self._last, grey
        if last is not None and elapsed_s > 0.0:
            self._alarms = self._alarms + 1 if self._ttc_s(last, grey, elapsed_s) < BRAKE_TTC_S else 0
        return self._alarms >= CONFIRMING

    @staticmethod
    def _ttc_s(last: Image, now: Image, elapsed_s: float) -> float:
        points = cv2.goodFeaturesToTrack(last, 60, 0.02, 4)
        if points is None or len(points) < 8:
            return inf
        moved, status, _ = cv2.calcOpticalFlowPyrLK(last, now, points, None)  # type: ignore[call-overload]
        good = status.ravel() == 1
        if good.sum() < 8:
            return inf
        affine, inliers = cv2.estimateAffinePartial2D(points[good], moved[good], ransacReprojThreshold=0.5)
        if affine is None or inliers.sum() < 8:
            return inf
        growth = float(np.hypot(affine[0, 0], affine[1, 0])) - 1.0  # half the divergence
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
        self._frame_s, self._stopping = -inf, False

    def act(self, observation: Observation) -> Command:
        elapsed_s = observation.frame_time_s - self._frame_s
        if elapsed_s > 0.9 / FRAME_HZ:
            self._frame_s = observation.frame_time_s
            self._look(observation, elapsed_s)
        throttle = -1.0 if self._stopping else self._speed.throttle(observation.speed_mps)
        return Command(throttle, self._steer(observation.speed_mps))

    def _look(self, observation: Observation, elapsed_s: float) -> None:
        found = fit_lane(ridges(self._above.of(observation.image)), self._lane)
        if found is not None:
            self._lane = found if self._lane is None else _blend(self._lane, found)
        self._stopping |= self._brake.alarm(observation.image, elapsed_s)

    def _steer(self, speed_mps: float) -> float:
        """Stanley's law at the front axle, with the bend's steering angle in advance."""
        if self._lane is None:
            return 0.0
        axle_m, lane = self._vehicle.l_f_m, self._lane
        right_m = lane.right_m + axle_m * lane.heading_rad
        angle = lane.heading_rad + atan2(self._gains.k_per_s * right_m, self._gains.softening_mps + speed_mps)
        angle += atan(self._vehicle.wheelbase_m * lane.curvature_per_m)
        return min(max(angle / self._vehicle.steering_limit_rad, -1.0), 1.0)


def _blend(old: LaneFit, new: LaneFit) -> LaneFit:
    pairs = zip(
        (old.right_m, old.heading_rad, old.curvature_per_m, old.width_m),
        (new.right_m, new.heading_rad, new.curvature_per_m, new.width_m),
        strict=True,
    )
    return LaneFit(*(before + SMOOTHING * (now - before) for before, now in pairs))
