"""The pitching of the body on its springs, seen in the flow, and taken out of it.

A camera that comes to look down by delta moves all that it sees by -f (x y, 1 + y^2) delta (Longuet-Higgins and Prazdny
1980). Of a point's flow the part across its line to the focus of expansion does not depend on how far it is, so delta
is what the points beside that focus agree on; those above and below it tell nothing. Over a window of 0.1 s that is
exact to a hundredth of a degree. A road's unevenness turns a car by tenths of one, and a tenth that is not known lifts
the road 15 m ahead by 3 cm.

The changes add up to the pitch but for a constant. Their sum serves to compare a point with its first sighting; what it
has of slow changes is left out where the pitch itself is wanted, so that its error does not grow. A car that does not
pitch is left alone: its flow and frames pass as they are. How the camera is mounted comes from elsewhere
(`perception.egomotion.mount_pitch`), is `mounted_rad` here, and taken out by the same way.
"""

from collections import deque
from dataclasses import replace
from math import exp

import cv2
import numpy as np

from vpf_sim.perception.egomotion.config import DynamicPitchConfig, PitchConfig
from vpf_sim.perception.egomotion.focus_of_expansion import Derotated, derotated
from vpf_sim.perception.egomotion.mount_pitch import MountPitch
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image, Integers


class PitchEstimator:
    """Adds up the pitch from frame to frame."""

    def __init__(self, camera: Camera, config: PitchConfig, rate_hz: float) -> None:
        self._camera = camera
        self._dynamic = config.dynamic
        self._rate_hz = rate_hz
        self._sums: deque[float] = deque(maxlen=round(config.dynamic.remembered_s * rate_hz) if config.dynamic else 0)
        self._slow_rad = 0.0
        self._square_rad2 = 0.0
        self._pitches = False
        self._mounting = MountPitch(config.mounting) if config.mounting else None
        self.pitch_rad = 0.0  # how far the camera looks below its mounting, but for slow changes

    def level(self, pitch_rad: float, sigma_rad: float, time_s: float) -> None:
        """Take in what the road tells of the pitch in the frame of `update`: what does not pass is the mounting's."""
        if self._mounting is not None:
            self._mounting.update(pitch_rad - self.passing_rad, sigma_rad, time_s)

    @property
    def mounted_rad(self) -> float:
        """How far the camera's mounting looks below where it should."""
        return self._mounting.pitch_rad if self._mounting else 0.0

    @property
    def is_needed(self) -> bool:
        """Whether flow and frames change."""
        return self._pitches or self.mounted_rad != 0.0

    @property
    def turned_rad(self) -> float:
        """How far the camera looks down, as far as it is known: flow and frames are turned back by it."""
        return self.mounted_rad + self.passing_rad

    @property
    def passing_rad(self) -> float:
        """The part of it that changes from frame to frame."""
        return self.pitch_rad if self._pitches else 0.0

    def update(self, flow: Flow, foe: Expansion, turned: Derotated | None = None) -> Flow:
        """The flow of the same points for a camera that does not pitch; `turned` is the flow as it is, `derotated`,
        where it is at hand."""
        if self._dynamic is not None:
            self._add(flow, foe, turned or derotated(flow, self._camera), self._dynamic)
        if not self.is_needed:
            return flow
        now = self._steady(flow.points_px, np.full(len(flow), self.turned_rad))
        past = self._steady(flow.points_px - flow.displacement_px, self._then(np.rint(flow.gap_s * self._rate_hz)))
        first = self._steady(flow.first_px, self._then(flow.age_frames))
        return replace(flow, points_px=now, displacement_px=now - past, first_px=first)

    def frame(self, image: Image) -> Image:
        """(H, W) or (H, W, 3) the frame of `update` as such a camera would have taken it, its rim repeated."""
        if not self.is_needed:
            return image
        camera, (c, s) = self._camera, (np.cos(self.turned_rad), np.sin(self.turned_rad))
        matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        size = (image.shape[1], image.shape[0])
        steady: Image = cv2.warpPerspective(
            image, matrix @ turn @ np.linalg.inv(matrix), size, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8, copy=False)
        return steady

    def _add(self, flow: Flow, foe: Expansion, turned: Derotated, config: DynamicPitchConfig) -> None:
        frames = round(float(flow.gap_s.max(initial=0.0)) * self._rate_hz)
        if not self._sums:
            self._sums.append(0.0)
            return
        found = self._sums[-1]
        if 0 < frames <= len(self._sums):
            change = self._change(flow, foe, turned, frames / self._rate_hz, config)
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
        """(N,) rad, `turned_rad` so many frames ago, from the sum, as far as it is remembered."""
        if not self._pitches:
            return np.full(len(frames), self.mounted_rad)
        sums, index = np.array(self._sums), np.asarray(frames, np.int64)
        return np.asarray(self.turned_rad - sums[-1] + sums[np.maximum(len(sums) - 1 - index, 0)])

    def _change(self, flow: Flow, foe: Expansion, turned: Derotated, gap_s: float, config: DynamicPitchConfig) -> float:
        """rad, over the windows that are `gap_s` long."""
        chosen = np.flatnonzero((np.abs(flow.gap_s - gap_s) < 0.5 / self._rate_hz) & ~flow.stuck)
        if foe.confidence == 0.0 or len(chosen) < config.least_points:
            return 0.0
        points, displacement = flow.points_px.take(chosen, axis=0), turned.flow_px.take(chosen, axis=0)
        x = points[:, 0] + turned.shift_px[chosen] - foe.x_px
        y = points[:, 1] - foe.y_px
        nearness = 1.0 / (np.hypot(x, y) + config.near_px)
        turn = self._motion(points)
        across = (displacement[:, 0] * y - displacement[:, 1] * x) * nearness
        slope = (turn[:, 0] * y - turn[:, 1] * x) * nearness
        found, left = _agreed(across, slope, config), x < 0.0
        few = min(np.count_nonzero(left), np.count_nonzero(~left)) < config.least_points
        if few or config.sides is None or abs(found) < config.sides.apart_rad:
            return found
        # All that is seen pitches with the camera, a car that overtakes is on one side.
        sides = [_agreed(across[side], slope[side], config) for side in (left, ~left)]
        apart = abs(sides[1] - sides[0]) > config.sides.apart_rad + config.sides.apart_share * abs(found)
        return min(*sides, key=abs) if apart else found

    def _motion(self, points_px: Floats) -> Floats:
        """(N, 2) px per rad of looking down."""
        camera = self._camera
        x = (points_px[:, 0] - camera.cx_px) / camera.fx_px
        y = (points_px[:, 1] - camera.cy_px) / camera.fy_px
        motion = np.empty(points_px.shape)
        np.multiply(-camera.fx_px * x, y, out=motion[:, 0])
        np.multiply(-camera.fy_px, 1.0 + y * y, out=motion[:, 1])
        return motion

    def _steady(self, points_px: Floats, pitch_rad: Floats) -> Floats:
        """(N, 2) px, where the points would be without that pitch."""
        steady: Floats = points_px - pitch_rad[:, None] * self._motion(points_px)
        return steady


def _agreed(across_px: Floats, slope_px: Floats, config: DynamicPitchConfig) -> float:
    """delta of across = slope delta, by reweighted least squares."""
    delta, square, product = 0.0, slope_px * slope_px, slope_px * across_px
    for _ in range(config.passes):
        error = across_px - slope_px * delta
        cut = max(config.cut * median(np.abs(error)) / 0.6745, config.least_cut_px)
        weight = np.maximum(1.0 - (error / cut) ** 2, 0.0) ** 2
        normal = float(weight @ square)
        if normal < 1e-9:
            return 0.0
        delta = float(weight @ product) / normal
    return delta
