"""The windshield wiper: where its blade is, what it sweeps, and its shadow on the picture.

One blade turns about a pivot below the picture on the left, from lying along the lower edge of the glass to standing by
its left edge and back, sinusoidally; then it rests until the next period.
"""

from dataclasses import dataclass
from math import cos, pi, radians

import cv2
import numpy as np

from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.planes import ROWS
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Floats, Image

PIVOT_M = (-0.45, 0.62)  # right of the optical axis, down along the glass
SWEEP_RAD = radians(90.0)  # from lying to the right of the pivot to standing above it
RADII_M = (0.25, 0.84)  # what the blade wipes
CYCLE_S = 1.33  # there and back, 45 a minute; faster where the period is shorter
END_M = 0.01  # the largest drop's reach
WIDTH_M = 0.016  # of blade and arm
GREY, COVER = 22.0, 0.94  # the light that comes from the blade itself; how much it takes of what is behind
MARGIN_RAD = 0.04  # half the blade, nearest to its pivot, and its blur
EXPOSURE_S = 0.004
EXPOSURES = 5  # positions within one exposure
MOMENTS_S = (EXPOSURE_S * np.linspace(-0.5, 0.5, EXPOSURES)).tolist()
DIVISOR = 4  # the mask of the blade is drawn this much smaller than the frame


class Wiper:
    """One blade; without a period it rests for ever, out of sight."""

    def __init__(self, pane: Pane, period_s: float, seed: int) -> None:
        self.period_s = period_s
        self._pane = pane
        self._cycle_s = min(CYCLE_S, period_s)
        self._offset_s = float(stream(seed, "wiper").uniform(0.0, period_s))
        camera = pane.camera
        y = ROWS * np.arange(-(-camera.height_px // ROWS)) + (ROWS - 1) / 2
        pixels = np.meshgrid(np.arange(camera.width_px), y)
        self.radii_m = _polar(pane, *pixels)[0]  # (h, w) of the planes: distance from the pivot
        self._angles = _angle_at(pane, *pixels).astype(np.float32)
        reached = self._angles[self._angles >= 0.0]
        self._seen = (float(reached.min()), float(reached.max())) if reached.size else (1.0, -1.0)

    def angle(self, time_s: float) -> float:
        """Angle of the blade (rad), 0 lying, `SWEEP_RAD` standing."""
        phase = ((time_s + self._offset_s) % self.period_s) / self._cycle_s
        return SWEEP_RAD * (1.0 - cos(2.0 * pi * min(phase, 1.0))) / 2.0

    def swath(self, from_s: float, until_s: float) -> "Swath | None":
        """What the blade passes over in a span of time; None outside the picture."""
        angles = [self.angle(from_s), self.angle(until_s)]
        for turn_s, angle in ((0.0, 0.0), (self._cycle_s / 2.0, SWEEP_RAD)):
            if (turn_s - from_s - self._offset_s) % self.period_s <= until_s - from_s:
                angles.append(angle)
        if max(angles) < self._seen[0] or min(angles) > self._seen[1]:
            return None
        mask = np.asarray(cv2.inRange(self._angles, np.array([min(angles)]), np.array([max(angles)])), np.uint8)
        return Swath(self._pane, min(angles), max(angles), mask)

    def blade(self, time_s: float) -> Image | None:
        """(H / 4, W / 4) 0..255 how much of the light the blade takes; None when it is out of the picture."""
        if not self._seen[0] - MARGIN_RAD <= self.angle(time_s) <= self._seen[1] + MARGIN_RAD:
            return None
        camera = self._pane.camera
        mask: Image = np.zeros((-(-camera.height_px // DIVISOR), -(-camera.width_px // DIVISOR)), np.uint8)
        for quad in self._corners(np.array([self.angle(time_s + moment_s) for moment_s in MOMENTS_S])):
            once = np.zeros_like(mask)
            cv2.fillConvexPoly(once, np.rint(quad * 16.0).astype(np.int32), (255 // EXPOSURES,), cv2.LINE_AA, 4)
            cv2.add(mask, once, mask)
        return np.asarray(cv2.blur(mask, (5, 5)), np.uint8) if mask.any() else None

    def _corners(self, angles: Floats) -> Floats:
        """(n, 4, 2) corners of the blade on the mask, at n angles."""
        cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
        along = np.array([RADII_M[0], RADII_M[0], RADII_M[1], RADII_M[1]])
        across = WIDTH_M * np.array([-0.5, 0.5, 0.5, -0.5])
        u, s = PIVOT_M[0] + along * cosine + across * sine, PIVOT_M[1] - along * sine + across * cosine
        return (np.stack(self._pane.pixels(u, s), axis=-1) + 0.5) / DIVISOR - 0.5


@dataclass(frozen=True, slots=True)
class Swath:
    """The glass between two angles of the blade, as far out as the blade reaches."""

    pane: Pane
    low: float  # rad
    high: float
    mask: Image  # (h, w) of the planes: 255 in it, 0 outside

    def holds(self, x_px: Floats, y_px: Floats) -> Bools:
        """Which points of the picture lie in the swath."""
        angle = _angle_at(self.pane, x_px, y_px)
        return (angle >= self.low) & (angle <= self.high)

    def at_end(self, x_px: Floats, y_px: Floats) -> Bools:
        """Which points of the picture lie so near the ends of the blade that it may cut a drop there in two."""
        radius = _polar(self.pane, x_px, y_px)[0]
        return (np.abs(radius - RADII_M[0]) < END_M) | (np.abs(radius - RADII_M[1]) < END_M)


def paint_blade(frame: Image, blade: Image) -> None:
    """Put the blade before the frame, in place."""
    x, y, width, height = cv2.boundingRect(blade)
    if width == 0:  # at the turning points it may be beside the picture
        return
    part = blade[y : y + height, x : x + width]
    here = frame[DIVISOR * y : DIVISOR * (y + height), DIVISOR * x : DIVISOR * (x + width)]
    cover = cv2.resize(part, (DIVISOR * width, DIVISOR * height))[: here.shape[0], : here.shape[1]]
    cover = cv2.cvtColor(cv2.convertScaleAbs(cover, None, COVER), cv2.COLOR_GRAY2RGB)
    cv2.multiply(here, cv2.bitwise_not(cover), here, 1.0 / 255.0)
    cv2.add(here, cv2.convertScaleAbs(cover, None, GREY / 255.0), here)


def _polar(pane: Pane, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
    """Distance from the pivot (m) and angle (rad) of points of the picture."""
    u, s = pane.on_glass(x_px, y_px)
    u, up = u - PIVOT_M[0], PIVOT_M[1] - s
    return np.hypot(u, up), np.arctan2(up, u)


def _angle_at(pane: Pane, x_px: Floats, y_px: Floats) -> Floats:
    """The blade's angle when it is over a point of the picture; -1 where it never is."""
    radius, angle = _polar(pane, x_px, y_px)
    return np.where((radius >= RADII_M[0]) & (radius <= RADII_M[1]), angle, -1.0)
