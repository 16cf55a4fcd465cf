"""Removes water on the windscreen from the image: a mask of hidden pixels, and a restored image.

The flow tracker detects no corners on the mask. The restored image is for display, or for stages without a mask.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.evaluation.weather.windscreen_spots import SpotConfig, SpotDetector
from vpf_sim.evaluation.weather.wiper_detector import WiperDetector
from vpf_sim.geometry import distort, undistort
from vpf_sim.perception.egomotion.focus_of_expansion import derotate
from vpf_sim.perception.egomotion.windscreen_points import scene_motion
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image

Singles = NDArray[np.float32]

RIM_RAD = 0.006  # soft rim of a spot beyond its detected edge
SMOOTH_RAD = 0.12  # smoothing radius of measured motion
CELLS_ALONG = 64  # cells across the image's width, each with one motion
ROAD_WEIGHT = 0.01  # weight of the flat road's motion, in points
RADIAL_SHARE = 0.25  # largest share of a motion perpendicular to the direction from the focus of expansion
INPAINT_PX, AROUND_PX = 3.0, 8.0
LARGEST_ERROR = 55.0  # grey levels, where errors saturate
REGULARISATION = 1.0  # grey levels^2


class WindscreenMask:
    """The mask of water and the wiper's blade; receives every frame."""

    def __init__(self, camera: Camera, rate_hz: float, config: SpotConfig | None = None) -> None:
        self._size = (camera.width_px, camera.height_px)
        self._spot_detector = SpotDetector(camera, config or SpotConfig(), rate_hz)
        self._wiper_detector = WiperDetector(camera, rate_hz)
        self._spots: Image = np.zeros(self._spot_detector.shape, np.uint8)
        rim = 2 * max(1, round(RIM_RAD * camera.fx_px)) + 1
        self._rim = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (rim, rim))

    def update(self, image: Image, pose: Floats) -> Image:
        """(H, W) 255 where the grey frame (H, W) at `pose` (x, y, yaw) shows the windscreen, else 0."""
        sampled = self._spot_detector.update(image, pose)
        blade = self._wiper_detector.update(image)
        if blade is not None:
            swept = np.asarray(
                cv2.resize(blade, self._spot_detector.shape[::-1], interpolation=cv2.INTER_NEAREST), np.uint8
            )
            self._spot_detector.reset(swept)
            self._spots[swept != 0] = 0
        if sampled:
            self._spots = self._spot_detector.spots()
        mask = cv2.resize(self._spots, self._size, interpolation=cv2.INTER_NEAREST)
        if blade is not None:
            mask = cv2.max(mask, cv2.resize(blade, self._size, interpolation=cv2.INTER_NEAREST))
        return np.asarray(mask, np.uint8)

    def with_rim(self, mask: Image) -> Image:
        """The mask dilated by the soft rim of spots."""
        return cv2.dilate(mask, self._rim).astype(np.uint8, copy=False)


class Restoration:
    """Fills hidden pixels from the last frame, warped by the scene's motion, and by inpainting.

    Both are blended by how well they match the visible surroundings: inpainting (Telea 2004) where the image is smooth,
    the warped frame where it fits.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._last: Image | None = None
        self._pose = np.zeros(3)
        cell = camera.width_px / CELLS_ALONG
        self._cells = (max(1, round(camera.height_px / cell)), CELLS_ALONG)
        rows = (np.arange(self._cells[0]) + 0.5) * camera.height_px / self._cells[0] - 0.5
        columns = (np.arange(CELLS_ALONG) + 0.5) * cell - 0.5
        x, y = np.meshgrid(columns, rows)
        self._raw = np.column_stack([x.ravel(), y.ravel()])
        self._centres = undistort(camera, self._raw)
        self._spread = max(0.5, SMOOTH_RAD * camera.fx_px / cell)
        self._place = np.stack(np.meshgrid(*(np.arange(n, dtype=np.float32) for n in self._size)), axis=-1)

    @property
    def _size(self) -> tuple[int, int]:
        return self._camera.width_px, self._camera.height_px

    def update(self, frame: Image, hidden: Image, flow: Flow, expansion: Expansion) -> Image:
        """The frame (H, W) or (H, W, 3) with `hidden` (H, W) pixels filled; `flow` and `expansion` of this frame."""
        around = cv2.inpaint(frame, hidden, INPAINT_PX, cv2.INPAINT_TELEA).astype(np.uint8, copy=False)
        result = around
        if self._last is not None and hidden.any():
            source = self._place - self._motion(flow, expansion)
            past = np.asarray(cv2.remap(self._last, source[..., 0], source[..., 1], cv2.INTER_LINEAR), np.uint8)
            inside = np.all((source > 0) & (source < np.array(self._size) - 1), axis=-1)
            share = _share_of_past(frame, past, (hidden == 0).astype(np.float32), inside.astype(np.float32))
            if frame.ndim == 3:
                share = share[..., None]
            mixed = np.rint(around + share * (past.astype(np.float32) - around)).astype(np.uint8)
            result = np.where(hidden.reshape(share.shape) != 0, mixed, frame)
        self._last, self._pose = result, flow.pose
        return result

    def _motion(self, flow: Flow, expansion: Expansion) -> Floats:
        """(H, W, 2) px, scene motion from the last frame: away from the focus at the rate of nearby points.

        Without nearby points, the rate is that of the flat road, mirrored above the horizon.
        """
        camera, focus = self._camera, np.array([expansion.x_px, expansion.y_px])
        past = np.tile(self._pose, (len(self._centres), 1))
        by_way, by_turn = scene_motion(camera, self._centres, past, flow.pose)
        away = self._centres - focus
        rate = np.maximum(np.sum(by_way * away, axis=1) / (np.sum(away**2, axis=1) + 1.0), 0.0).reshape(self._cells)
        total, count = self._measured(flow, focus)
        rate = (total + ROAD_WEIGHT * rate) / (count + ROAD_WEIGHT)
        before = distort(camera, self._centres - rate.reshape(-1, 1) * away - by_turn)
        motion = (self._raw - before).reshape(*self._cells, 2).astype(np.float32)
        return np.asarray(cv2.resize(motion, self._size))

    def _measured(self, flow: Flow, focus_px: Floats) -> tuple[Floats, Floats]:
        """(rows, columns) each: smoothed sum of the points' rates a frame by cell, and smoothed count."""
        moved, away = derotate(flow, self._camera), flow.points_px - focus_px
        square, frames = np.sum(away**2, axis=1) + 1.0, np.maximum(np.minimum(flow.age_frames, _window(flow)), 1)
        rate = np.sum(moved * away, axis=1) / square / frames
        across = np.abs(moved[:, 0] * away[:, 1] - moved[:, 1] * away[:, 0]) / np.sqrt(square)
        good = (flow.gap_s > 0.0) & ~flow.stuck & (rate > 0.0)
        good &= across < RADIAL_SHARE * np.hypot(moved[:, 0], moved[:, 1]) + 1.0
        cell = flow.points_px[good] / self._size * self._cells[::-1]
        column, row = np.clip(cell.astype(np.intp), 0, np.array(self._cells[::-1]) - 1).T
        total, count = np.zeros(self._cells), np.zeros(self._cells)
        np.add.at(total, (row, column), rate[good])
        np.add.at(count, (row, column), 1.0)
        blurred = [np.asarray(cv2.GaussianBlur(values, (0, 0), self._spread), np.float64) for values in (total, count)]
        return blurred[0], blurred[1]


def _window(flow: Flow) -> int:
    """Length of the longest flow window, frames."""
    longest = flow.gap_s >= flow.gap_s.max(initial=0.0) - 1e-9
    return int(flow.age_frames[longest].min(initial=1))


def _share_of_past(frame: Image, past: Image, visible: Singles, inside: Singles) -> Singles:
    """(H, W) 0..1, blending weight of the warped frame: local variance / (variance + local error)."""
    now, then = (values.astype(np.float32).reshape(*frame.shape[:2], -1).mean(axis=2) for values in (frame, past))
    error = np.minimum((then - now) ** 2, LARGEST_ERROR**2)
    count, compared = _blur(visible), _blur(visible * inside)
    mean = _blur(now * visible) / count
    variance = _blur((now - mean) ** 2 * visible) / count
    share = variance / (variance + _blur(error * visible * inside) / compared + REGULARISATION)
    return np.asarray(share * inside, np.float32)


def _blur(values: Singles) -> Singles:
    return np.asarray(cv2.GaussianBlur(values, (0, 0), AROUND_PX), np.float32) + np.float32(1e-4)
