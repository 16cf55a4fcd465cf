"""Pitch of the camera, estimated from the flow and the road's lines, and compensated in flow and frames.

A camera that pitches down by delta moves all points by -f (x y, 1 + y^2) delta (Longuet-Higgins and Prazdny 1980). The
part of a point's flow across its line to the focus of expansion does not depend on its distance, so the points beside
the focus fix delta: over 0.1 s to a hundredth of a degree. An uneven road pitches a car by tenths of a degree, and a
tenth lifts the road 15 m ahead by 3 cm.

The sum of the changes is the pitch up to a constant. A high-pass removes the slow drift of the sum; the constant part
is the mount pitch (`egomotion.mount_pitch`). Without pitch, flow and frames stay as they are.
"""

from collections import deque
from dataclasses import replace
from math import exp

import cv2
import numpy as np

from vpf_sim.geometry import normalised
from vpf_sim.perception.egomotion.egomotion_settings import PitchConfig
from vpf_sim.perception.egomotion.focus_fit import NEAR_PX
from vpf_sim.perception.egomotion.focus_of_expansion import Derotated, derotated
from vpf_sim.perception.egomotion.mount_pitch import MountPitch
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image, Integers

MEMORY_S = 3.0  # longer ago than any first observation


class PitchEstimator:
    """Estimates the camera's pitch from frame to frame and compensates it."""

    def __init__(self, camera: Camera, config: PitchConfig, rate_hz: float) -> None:
        self._camera = camera
        self._config = config.dynamic
        self._rate_hz = rate_hz
        self._sums: deque[float] = deque(maxlen=round(MEMORY_S * rate_hz))
        self._slow_rad = 0.0
        self._square_rad2 = 0.0
        self._pitches = False
        self._mounting = MountPitch(config.mounting)
        self.pitch_rad = 0.0  # dynamic pitch, + looks down

    def update_mount_pitch(self, pitch_rad: float, sigma_rad: float, time_s: float) -> None:
        """Add the pitch that the road's lines show in the frame of `update`."""
        self._mounting.update(pitch_rad - self.dynamic_rad, sigma_rad, time_s)

    @property
    def mounted_rad(self) -> float:
        """Mount pitch to compensate."""
        return self._mounting.pitch_rad

    @property
    def is_needed(self) -> bool:
        """Whether flow and frames are compensated."""
        return self._pitches or self.mounted_rad != 0.0

    @property
    def total_rad(self) -> float:
        """Pitch to compensate."""
        return self.mounted_rad + self.dynamic_rad

    @property
    def dynamic_rad(self) -> float:
        """Dynamic pitch to compensate."""
        return self.pitch_rad if self._pitches else 0.0

    def update(self, flow: Flow, foe: Expansion, turned: Derotated | None = None) -> Flow:
        """The flow of a camera without pitch; `turned` is the flow `derotated`, if it is at hand."""
        self._add(flow, foe, turned or derotated(flow, self._camera))
        if not self.is_needed:
            return flow
        now = self._steady(flow.points_px, np.full(len(flow), self.total_rad))
        past = self._steady(flow.points_px - flow.displacement_px, self._then(np.rint(flow.gap_s * self._rate_hz)))
        first = self._steady(flow.first_px, self._then(flow.age_frames))
        return replace(flow, points_px=now, displacement_px=now - past, first_px=first)

    def frame(self, image: Image) -> Image:
        """(H, W) or (H, W, 3) the frame of `update` as seen without pitch, its rim repeated."""
        if not self.is_needed:
            return image
        camera, (c, s) = self._camera, (np.cos(self.total_rad), np.sin(self.total_rad))
        matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        size = (image.shape[1], image.shape[0])
        steady: Image = cv2.warpPerspective(
            image, matrix @ turn @ np.linalg.inv(matrix), size, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8, copy=False)
        return steady

    def _add(self, flow: Flow, foe: Expansion, turned: Derotated) -> None:
        config = self._config
        frames = round(float(flow.gap_s.max(initial=0.0)) * self._rate_hz)
        if not self._sums:
            self._sums.append(0.0)
            return
        found = self._sums[-1]
        if 0 < frames <= len(self._sums):
            change = self._change(flow, foe, turned, frames / self._rate_hz)
            # The last frame and the mean rate tie the sums of interleaved windows together.
            share = config.smoothness
            found = (1.0 - share) * (self._sums[-frames] + change) + share * (self._sums[-1] + change / frames)
        self._sums.append(found)
        share = 1.0 - exp(-1.0 / (config.settle_s * self._rate_hz))
        self._slow_rad += share * (found - self._slow_rad)
        self.pitch_rad = found - self._slow_rad
        self._square_rad2 += share * (self.pitch_rad**2 - self._square_rad2)
        least = config.least_rad * (0.5 if self._pitches else 1.0)
        self._pitches = self._square_rad2 > least**2

    def _then(self, frames: Floats | Integers) -> Floats:
        """(N,) rad, `total_rad` as it was `frames` ago."""
        if not self._pitches:
            return np.full(len(frames), self.mounted_rad)
        sums, index = np.array(self._sums), np.asarray(frames, np.int64)
        return np.asarray(self.total_rad - sums[-1] + sums[np.maximum(len(sums) - 1 - index, 0)])

    def _change(self, flow: Flow, foe: Expansion, turned: Derotated, gap_s: float) -> float:
        """Change of the pitch in rad over the windows of `gap_s`."""
        config = self._config
        chosen = np.flatnonzero((np.abs(flow.gap_s - gap_s) < 0.5 / self._rate_hz) & ~flow.on_glass)
        if foe.confidence == 0.0 or len(chosen) < config.least_points:
            return 0.0
        points, displacement = flow.points_px.take(chosen, axis=0), turned.flow_px.take(chosen, axis=0)
        x = points[:, 0] + turned.shift_px[chosen] - foe.x_px
        y = points[:, 1] - foe.y_px
        nearness = 1.0 / (np.hypot(x, y) + NEAR_PX)
        turn = self._motion(points)
        across = (displacement[:, 0] * y - displacement[:, 1] * x) * nearness
        slope = (turn[:, 0] * y - turn[:, 1] * x) * nearness
        found, left = _fit(across, slope), x < 0.0
        few = min(np.count_nonzero(left), np.count_nonzero(~left)) < config.least_points
        if few or abs(found) < config.sides.apart_rad:
            return found
        # The whole image pitches, but a car that overtakes fills one side.
        sides = [_fit(across[side], slope[side]) for side in (left, ~left)]
        apart = abs(sides[1] - sides[0]) > config.sides.apart_rad + config.sides.apart_share * abs(found)
        return min(*sides, key=abs) if apart else found

    def _motion(self, points_px: Floats) -> Floats:
        """(N, 2) px per rad of pitch."""
        camera = self._camera
        x, y = normalised(camera, points_px)
        motion = np.empty(points_px.shape)
        np.multiply(-camera.fx_px * x, y, out=motion[:, 0])
        np.multiply(-camera.fy_px, 1.0 + y * y, out=motion[:, 1])
        return motion

    def _steady(self, points_px: Floats, pitch_rad: Floats) -> Floats:
        """(N, 2) px, where the points would be without the pitch."""
        steady: Floats = points_px - pitch_rad[:, None] * self._motion(points_px)
        return steady


def _fit(across_px: Floats, slope_px: Floats) -> float:
    """delta of across = slope delta, by reweighted least squares with Tukey's biweight."""
    delta, square, product = 0.0, slope_px * slope_px, slope_px * across_px
    for _ in range(4):
        error = across_px - slope_px * delta
        cut = max(3.7 * median(np.abs(error)) / 0.6745, 0.3)
        weight = np.maximum(1.0 - (error / cut) ** 2, 0.0) ** 2
        normal = float(weight @ square)
        if normal < 1e-9:
            return 0.0
        delta = float(weight @ product) / normal
    return delta
