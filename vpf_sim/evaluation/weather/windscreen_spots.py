"""Spots on the glass before the camera, pixel by pixel: what stays while the scene behind it moves.

Drops, dirt and mirror images in the glass have edges that stay where they are. At each pixel the slope of the picture
along the direction in which the scene moves there is averaged over some tenths of a second: of a scene that moves, the
slopes are as often up as down and the average is small beside the single ones; of a spot they are always the same. What
is long in the direction of motion, such as a lane line, has no slope along it and is not taken for a spot.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import undistort
from vpf_sim.perception.egomotion.windscreen_points import least_motion, scene_motion
from vpf_sim.types import Camera, Floats, Image

CELL_PX = 16  # of the reduced picture, in which the scene is taken to move alike
LARGEST_HOLE_PX2 = 150  # of the reduced picture
SAMPLES = 3  # that a pixel needs since it was last wiped
LEAST_STEP_M, LEAST_TURN_RAD = 0.05, 0.002  # between two samples, below which nothing can be told
CLOSED, ERODED = (cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)) for size in (5, 3))


@dataclass(frozen=True, slots=True)
class SpotConfig:
    """The picture is reduced until its focal length is `focal_px`, so that a drop has the same size in any camera."""

    focal_px: float = 320.0
    sample_s: float = 0.05  # between two samples, or a frame where these are fewer
    memory_s: float = 0.4
    coherence: float = 0.35  # square of the mean slope over the mean square, above which it stays
    noise: float = 4.0  # grey levels / px of the reduced picture: slopes below it say nothing, nor do those below
    aside: float = 0.15  # this share of the steepest slope: the direction of motion is not known exactly
    least_motion_px: float = 3.0  # of the reduced picture, of the scene within the memory

    def __post_init__(self) -> None:
        if min(self.focal_px, self.sample_s, self.memory_s, self.noise, self.least_motion_px) <= 0.0:
            raise ValueError("focal_px, sample_s, memory_s, noise, least_motion_px: expected > 0")
        if not 0.0 < self.coherence < 1.0:
            raise ValueError(f"coherence: expected between 0 and 1, got {self.coherence}")


def reduced(image: Image, shape: tuple[int, int], divisor: int) -> Image:
    """(h, w) mean of each block of `divisor` x `divisor` pixels; what is left over at right and below is not seen."""
    whole = image[: shape[0] * divisor, : shape[1] * divisor]
    return cv2.resize(whole, shape[::-1], interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)


def _filled(mask: Image) -> Image:
    """The mask with its small holes filled: the middle of a large drop has no edges."""
    _, label, boxes, _ = cv2.connectedComponentsWithStats(cv2.bitwise_not(mask), connectivity=4)
    small = boxes[:, cv2.CC_STAT_AREA] < LARGEST_HOLE_PX2
    small[0] = True  # the mask itself
    return np.take(np.where(small, 255, 0).astype(np.uint8), np.asarray(label, np.intp))


class SpotDetector:
    """Is shown every frame, and tells what stays in the picture."""

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
        # Memory taken anew costs as much as what is done with it.
        self._right, self._down, self._share, self._steepness = (np.zeros(self.shape, np.float32) for _ in range(4))
        self._ones = np.ones(self.shape, np.float32)
        self._moved_px = np.zeros(self._cells, np.float32)
        self._pose: Floats | None = None
        self._frame = 0

    def update(self, image: Image, pose: Floats) -> bool:
        """See the grey (H, W) frame taken at `pose` (x, y, yaw); whether it was taken as a sample."""
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

    def wiped(self, mask: Image) -> None:
        """Forget what was where a (h, w) mask of the reduced picture is not 0."""
        gone = mask != 0
        for memory in (self._slope, self._square, self._weight):
            memory[gone] = 0.0

    def spots(self) -> Image:
        """(h, w) 255 where the reduced picture shows something that stays, else 0."""
        config = self._config
        stays, limit = self._right, self._down
        cv2.multiply(self._slope, self._slope, stays)
        cv2.multiply(self._square, self._weight, limit, config.coherence)
        for values in (stays, limit):
            cv2.GaussianBlur(values, (3, 3), 0, values)
        cv2.multiply(self._weight, self._weight, self._share, config.coherence * config.noise**2)
        cv2.add(limit, self._share, limit)
        cv2.resize(self._moved_px, self.shape[::-1], self._share)
        mask = (stays > limit) & (self._share > config.least_motion_px)
        mask &= self._weight > 1.0 - (1.0 - self._gain) ** (SAMPLES - 0.5)
        closed = _filled(
            np.asarray(cv2.morphologyEx(np.where(mask, 255, 0).astype(np.uint8), cv2.MORPH_CLOSE, CLOSED), np.uint8)
        )
        return cv2.erode(closed, ERODED).astype(np.uint8, copy=False)

    def _cell_centres(self) -> Floats:
        """(M, 2) px of the frame, undistorted, row by row."""
        rows, columns = (
            np.minimum((np.arange(count) + 0.5) * CELL_PX, size - 1) * self._divisor
            for count, size in zip(self._cells, self.shape, strict=True)
        )
        x, y = np.meshgrid(columns, rows)
        return undistort(self._camera, np.column_stack([x.ravel(), y.ravel()]))

    def _direction(self, pose: Floats) -> NDArray[np.float32]:
        """(2, rows, columns) unit vectors along which the scene in each cell moved since the last sample.

        How far it moved is added up.
        """
        assert self._pose is not None
        past = np.tile(self._pose, (len(self._centres), 1))
        by_way, by_turn = scene_motion(self._camera, self._centres, past, pose)
        least = least_motion(by_way, by_turn).reshape(self._cells) / self._divisor
        self._moved_px += least - self._gain * self._moved_px
        motion = (by_way + by_turn).T
        motion = motion / (np.hypot(*motion) + 1e-6)
        return np.asarray(motion.reshape(2, *self._cells), np.float32)
