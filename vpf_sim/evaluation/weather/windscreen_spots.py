"""Static-texture mask: pixels of the windscreen whose texture stays while the scene moves.

Drops, dirt and reflections in the windscreen have edges with a fixed image position. At each pixel, the image gradient
along the scene's local direction of motion is averaged over some tenths of a second. The gradients of a moving scene
cancel, those of a spot do not. Structures along the direction of motion, such as lane lines, have no gradient along it
and are not detected.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import undistort
from vpf_sim.perception.egomotion.windscreen_points import least_motion, scene_motion
from vpf_sim.types import Camera, Floats, Image

CELL_PX = 16  # of the reduced image: size of cells with one scene motion
LARGEST_HOLE_PX2 = 150  # of the reduced image
SAMPLES = 3  # least number since a pixel was last wiped
LEAST_STEP_M, LEAST_TURN_RAD = 0.05, 0.002  # least motion between two samples
CLOSED, ERODED = (cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)) for size in (5, 3))


@dataclass(frozen=True, slots=True)
class SpotConfig:
    """Settings; the image is reduced to the focal length `focal_px`, so that drops have the same size in any camera."""

    focal_px: float = 320.0
    sample_s: float = 0.05  # between two samples, at least one frame
    memory_s: float = 0.4
    coherence: float = 0.35  # (mean gradient)^2 / mean square, above which the texture is static
    noise: float = 4.0  # grey levels / px of the reduced image: smaller gradients are ignored
    aside: float = 0.15  # ignored share of the steepest gradient, for errors of the motion direction
    least_motion_px: float = 3.0  # of the reduced image: least scene motion within the memory

    def __post_init__(self) -> None:
        if min(self.focal_px, self.sample_s, self.memory_s, self.noise, self.least_motion_px) <= 0.0:
            raise ValueError("focal_px, sample_s, memory_s, noise, least_motion_px: expected > 0")
        if not 0.0 < self.coherence < 1.0:
            raise ValueError(f"coherence: expected between 0 and 1, got {self.coherence}")


def reduced(image: Image, shape: tuple[int, int], divisor: int) -> Image:
    """(h, w) mean of each block of `divisor` x `divisor` pixels; the remainder at right and bottom is dropped."""
    whole = image[: shape[0] * divisor, : shape[1] * divisor]
    return cv2.resize(whole, shape[::-1], interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)


def _filled(mask: Image) -> Image:
    """The mask with small holes filled: the middle of a large drop has no edges."""
    _, label, boxes, _ = cv2.connectedComponentsWithStats(cv2.bitwise_not(mask), connectivity=4)
    small = boxes[:, cv2.CC_STAT_AREA] < LARGEST_HOLE_PX2
    small[0] = True  # the background label is the mask itself
    return np.take(np.where(small, 255, 0).astype(np.uint8), np.asarray(label, np.intp))


class SpotDetector:
    """Finds static texture; receives every frame."""

    def __init__(self, camera: Camera, config: SpotConfig, rate_hz: float) -> None:
        self._config = config
        self._camera = camera
        self._divisor = max(1, round(camera.fx_px / config.focal_px))
        self.shape = (camera.height_px // self._divisor, camera.width_px // self._divisor)
        self._every = max(1, round(config.sample_s * rate_hz))
        self._gain = min(1.0, self._every / (config.memory_s * rate_hz))
        self._cells = tuple(-(-size // CELL_PX) for size in self.shape)
        self._centres = self._cell_centres()
        self._slope, self._square, self._weight = (np.zeros(self.shape, np.float32) for _ in range(3))
        # Reused buffers: allocation would cost as much as the arithmetic.
        self._right, self._down, self._share, self._steepness = (np.zeros(self.shape, np.float32) for _ in range(4))
        self._ones = np.ones(self.shape, np.float32)
        self._moved_px = np.zeros(self._cells, np.float32)
        self._pose: Floats | None = None
        self._frame = 0

    def update(self, image: Image, pose: Floats) -> bool:
        """Add the grey (H, W) frame at `pose` (x, y, yaw); returns whether it was sampled."""
        due = self._frame % self._every == 0
        self._frame += 1
        if self._pose is None:
            self._pose = pose
            return False
        step = pose - self._pose
        if not due or (np.hypot(step[0], step[1]) < LEAST_STEP_M and abs(step[2]) < LEAST_TURN_RAD):
            return False
        direction = self._direction(pose)
        self._pose = pose
        small = reduced(image, self.shape, self._divisor)
        right, down = self._right, self._down
        cv2.Sobel(small, cv2.CV_32F, 1, 0, right, scale=0.125)
        cv2.Sobel(small, cv2.CV_32F, 0, 1, down, scale=0.125)
        share, steepness = self._share, self._steepness
        steepness[:] = 0.0
        for slope, axis in ((right, 0), (down, 1)):
            cv2.accumulateSquare(slope, steepness)
            cv2.resize(direction[axis], self.shape[::-1], share)
            cv2.multiply(slope, share, slope)
        cv2.add(right, down, right)
        np.multiply(steepness, np.float32(self._config.aside**2), out=down)
        cv2.accumulateSquare(right, down)
        cv2.accumulateWeighted(right, self._slope, self._gain)
        cv2.accumulateWeighted(down, self._square, self._gain)
        cv2.accumulateWeighted(self._ones, self._weight, self._gain)
        return True

    def reset(self, mask: Image) -> None:
        """Clear the memory where a (h, w) mask of the reduced image is not 0."""
        wiped = mask != 0
        for memory in (self._slope, self._square, self._weight):
            memory[wiped] = 0.0

    def spots(self) -> Image:
        """(h, w) 255 on static texture of the reduced image, else 0."""
        config = self._config
        static, limit = self._right, self._down
        cv2.multiply(self._slope, self._slope, static)
        cv2.multiply(self._square, self._weight, limit, config.coherence)
        for values in (static, limit):
            cv2.GaussianBlur(values, (3, 3), 0, values)
        cv2.multiply(self._weight, self._weight, self._share, config.coherence * config.noise**2)
        cv2.add(limit, self._share, limit)
        cv2.resize(self._moved_px, self.shape[::-1], self._share)
        mask = (static > limit) & (self._share > config.least_motion_px)
        mask &= self._weight > 1.0 - (1.0 - self._gain) ** (SAMPLES - 0.5)
        closed = _filled(
            np.asarray(cv2.morphologyEx(np.where(mask, 255, 0).astype(np.uint8), cv2.MORPH_CLOSE, CLOSED), np.uint8)
        )
        return cv2.erode(closed, ERODED).astype(np.uint8, copy=False)

    def _cell_centres(self) -> Floats:
        """(M, 2) undistorted px of the cells' centres, row by row."""
        rows, columns = (
            np.minimum((np.arange(count) + 0.5) * CELL_PX, size - 1) * self._divisor
            for count, size in zip(self._cells, self.shape, strict=True)
        )
        x, y = np.meshgrid(columns, rows)
        return undistort(self._camera, np.column_stack([x.ravel(), y.ravel()]))

    def _direction(self, pose: Floats) -> NDArray[np.float32]:
        """(2, rows, columns) unit vectors of each cell's scene motion since the last sample; adds up its length."""
        assert self._pose is not None
        past = np.tile(self._pose, (len(self._centres), 1))
        by_way, by_turn = scene_motion(self._camera, self._centres, past, pose)
        least = least_motion(by_way, by_turn).reshape(self._cells) / self._divisor
        self._moved_px += least - self._gain * self._moved_px
        motion = (by_way + by_turn).T
        motion = motion / (np.hypot(*motion) + 1e-6)
        return np.asarray(motion.reshape(2, *self._cells), np.float32)
