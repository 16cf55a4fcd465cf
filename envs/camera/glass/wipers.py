"""The windscreen wiper: blade angle, swept area and image of the blade.

One blade turns about a pivot below the image on the left. It moves sinusoidally from lying along the lower edge to
standing by the left edge and back, then rests until the next period.
"""

from dataclasses import dataclass
from math import cos, pi, radians

import cv2
import numpy as np

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.planes import ROWS
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Floats, Image

PIVOT_M = (-0.45, 0.62)  # right of the optical axis, down along the glass
SWEEP_RAD = radians(90.0)  # from lying to standing
RADII_M = (0.25, 0.84)  # inner and outer radius of the blade
CYCLE_S = 1.33  # up and down, 45 per minute; less for shorter periods
END_M = 0.01  # radius of the largest drop
WIDTH_M = 0.016  # of blade and arm
GREY, COVER = 22.0, 0.94  # grey level of the blade, and its opacity
MARGIN_RAD = 0.04  # half the blade's width at its inner end, with blur
EXPOSURE_S = 0.004
EXPOSURES = 5  # blade positions per exposure
MOMENTS_S = (EXPOSURE_S * np.linspace(-0.5, 0.5, EXPOSURES)).tolist()
DIVISOR = 4  # downscaling of the blade's mask, at full detail


class Wiper:
    """One wiper blade with a period."""

    def __init__(self, pane: Pane, period_s: float, seed: int) -> None:
        self.period_s = period_s
        self._pane = pane
        self._cycle_s = min(CYCLE_S, period_s)
        self._offset_s = float(stream(seed, "wiper").uniform(0.0, period_s))
        camera = pane.camera
        self._divisor = max(1, round(DIVISOR * detail(camera)))
        y = ROWS * np.arange(-(-camera.height_px // ROWS)) + (ROWS - 1) / 2
        pixels = np.meshgrid(np.arange(camera.width_px), y)
        self.radii_m = _polar(pane, *pixels)[0]  # (h, w) distance from the pivot, on the planes
        self._angles = _angle_at(pane, *pixels).astype(np.float32)
        reached = self._angles[self._angles >= 0.0]
        self._seen = (float(reached.min()), float(reached.max())) if reached.size else (1.0, -1.0)

    def angle(self, time_s: float) -> float:
        """Blade angle, rad: 0 lying, `SWEEP_RAD` standing."""
        phase = ((time_s + self._offset_s) % self.period_s) / self._cycle_s
        return SWEEP_RAD * (1.0 - cos(2.0 * pi * min(phase, 1.0))) / 2.0

    def swath(self, from_s: float, until_s: float) -> "Swath | None":
        """The area swept in a span of time; None outside the image."""
        angles = [self.angle(from_s), self.angle(until_s)]
        for turn_s, angle in ((0.0, 0.0), (self._cycle_s / 2.0, SWEEP_RAD)):
            if (turn_s - from_s - self._offset_s) % self.period_s <= until_s - from_s:
                angles.append(angle)
        if max(angles) < self._seen[0] or min(angles) > self._seen[1]:
            return None
        mask = np.asarray(cv2.inRange(self._angles, np.array([min(angles)]), np.array([max(angles)])), np.uint8)
        return Swath(self._pane, min(angles), max(angles), mask)

    def blade(self, time_s: float) -> Image | None:
        """(H / divisor, W / divisor) opacity of the blade, 0..255; None outside the image."""
        if not self._seen[0] - MARGIN_RAD <= self.angle(time_s) <= self._seen[1] + MARGIN_RAD:
            return None
        camera = self._pane.camera
        mask: Image = np.zeros((-(-camera.height_px // self._divisor), -(-camera.width_px // self._divisor)), np.uint8)
        for quad in self._corners(np.array([self.angle(time_s + moment_s) for moment_s in MOMENTS_S])):
            once = np.zeros_like(mask)
            cv2.fillConvexPoly(once, np.rint(quad * 16.0).astype(np.int32), (255 // EXPOSURES,), cv2.LINE_AA, 4)
            cv2.add(mask, once, mask)
        return np.asarray(cv2.blur(mask, (5, 5)), np.uint8) if mask.any() else None

    def _corners(self, angles: Floats) -> Floats:
        """(n, 4, 2) corners of the blade on the mask for n angles."""
        cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
        along = np.array([RADII_M[0], RADII_M[0], RADII_M[1], RADII_M[1]])
        across = WIDTH_M * np.array([-0.5, 0.5, 0.5, -0.5])
        u, s = PIVOT_M[0] + along * cosine + across * sine, PIVOT_M[1] - along * sine + across * cosine
        return (np.stack(self._pane.pixels(u, s), axis=-1) + 0.5) / self._divisor - 0.5


@dataclass(frozen=True, slots=True)
class Swath:
    """The area swept between two blade angles."""

    pane: Pane
    low: float  # rad
    high: float
    mask: Image  # (h, w) on the planes: 255 inside, 0 outside

    def holds(self, x_px: Floats, y_px: Floats) -> Bools:
        """Which image points lie in the swath."""
        angle = _angle_at(self.pane, x_px, y_px)
        return (angle >= self.low) & (angle <= self.high)

    def at_end(self, x_px: Floats, y_px: Floats) -> Bools:
        """Which image points are near the blade's ends, where it may cut a drop."""
        radius = _polar(self.pane, x_px, y_px)[0]
        return (np.abs(radius - RADII_M[0]) < END_M) | (np.abs(radius - RADII_M[1]) < END_M)


def paint_blade(frame: Image, blade: Image) -> None:
    """Draw the blade over the frame, in place."""
    divisor = -(-len(frame) // len(blade))
    x, y, width, height = cv2.boundingRect(blade)
    if width == 0:  # outside the image at the turning points
        return
    part = blade[y : y + height, x : x + width]
    here = frame[divisor * y : divisor * (y + height), divisor * x : divisor * (x + width)]
    cover = cv2.resize(part, (divisor * width, divisor * height))[: here.shape[0], : here.shape[1]]
    cover = cv2.cvtColor(cv2.convertScaleAbs(cover, None, COVER), cv2.COLOR_GRAY2RGB)
    cv2.multiply(here, cv2.bitwise_not(cover), here, 1.0 / 255.0)
    cv2.add(here, cv2.convertScaleAbs(cover, None, GREY / 255.0), here)


def _polar(pane: Pane, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
    """Distance from the pivot, m, and angle, rad, of image points."""
    u, s = pane.on_glass(x_px, y_px)
    u, up = u - PIVOT_M[0], PIVOT_M[1] - s
    return np.hypot(u, up), np.arctan2(up, u)


def _angle_at(pane: Pane, x_px: Floats, y_px: Floats) -> Floats:
    """The blade angle over an image point; -1 out of the blade's reach."""
    radius, angle = _polar(pane, x_px, y_px)
    return np.where((radius >= RADII_M[0]) & (radius <= RADII_M[1]), angle, -1.0)
