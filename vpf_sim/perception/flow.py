"""Sparse optical flow: Shi-Tomasi corners, pyramidal Lucas-Kanade, and tracks chained from frame to frame."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, inf, log2
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import undistort
from vpf_sim.perception.corners import is_corner
from vpf_sim.perception.ground import ground_flow
from vpf_sim.perception.stuck import stuck
from vpf_sim.types import Bools, Camera, Floats, Flow, Image

LOOSE_PX = 1.0  # a point that moved so far within a window is not stuck any more
FAINT = 1e-2 * np.eye(2)  # keeps the tensor of an empty window invertible


@dataclass(frozen=True, slots=True)
class Band:
    """A strip of the image with its own share of the corners, so that one strong edge does not starve the far road."""

    top: float  # tangent of the angle below the horizon
    bottom: float
    share: float  # of FlowConfig.points


BANDS = {
    "whole": (Band(-inf, inf, 1.0),),
    # Scenery, which holds the FOE's height; the road beyond 10 m and what stands on it; the road before it.
    "road": (Band(-0.35, 0.0, 0.2), Band(0.0, 0.14, 0.55), Band(0.14, 0.55, 0.25)),
}


@dataclass(frozen=True, slots=True)
class FlowConfig:
    """What is followed and how. The defaults are the paper's; corners and iterations are METHOD A4's."""

    window_px: int = 25
    max_level: int | None = 2  # three levels; None: as many as `reach_px_per_s` needs
    epsilon_px: float = 0.03
    iterations: int = 30
    window_s: float = 0.1  # frames are chained over this time
    points: int = 300
    quality: float = 0.01
    min_distance_px: float = 7.0
    block_px: int = 3
    bands: Literal["whole", "road"] = "whole"
    detect_period_s: float = 0.1
    forward_backward_px: float | None = None  # largest distance after tracking back, once a period; None: no check
    reach_px_per_s: float = 400.0  # fastest motion to follow
    texture_floor: float = 0.0  # least small eigenvalue of a corner's structure tensor, grey levels^2 / px^2
    corner_ratio: float = 0.0  # and its least share of the large one: edges slide
    anchor_s: float | None = None  # a point's first sighting is replaced by one between so old and twice; None: never

    def __post_init__(self) -> None:
        if self.window_px < 3 or self.window_px % 2 == 0:
            raise ValueError(f"window_px: expected an odd number >= 3, got {self.window_px}")
        if self.window_s <= 0.0 or self.detect_period_s <= 0.0:
            raise ValueError(f"window_s, detect_period_s: expected > 0, got {self.window_s}, {self.detect_period_s}")
        if self.points < 8:
            raise ValueError(f"points: expected >= 8, got {self.points}")
        if self.bands not in BANDS:
            raise ValueError(f"bands: expected one of {sorted(BANDS)}, got '{self.bands}'")


def grey(image_rgb: Image) -> Image:
    """(H, W) uint8 luma of an (H, W, 3) RGB image, 0.299 R + 0.587 G + 0.114 B."""
    return cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY).astype(np.uint8, copy=False)


def structure_tensor(image: Image, points_px: Floats, window_px: int) -> Floats:
    """(N, 2, 2) mean of grad I grad I^T over the window about each point, grey levels^2 / px^2 (Shi-Tomasi).

    At the frame's edge the window is the nearest that lies inside.
    """
    size = window_px + 2
    height, width = image.shape
    corner = np.rint(points_px).astype(np.intp) - size // 2
    corner = np.minimum(np.maximum(corner, 0), (width - size, height - size))
    places = (corner[:, 1] * width + corner[:, 0])[:, None] + _window(size, width)
    patch = np.ascontiguousarray(image).reshape(-1).take(places).astype(np.float32).reshape(-1, size, size)
    across = patch[:, 1:-1, 2:] - patch[:, 1:-1, :-2]
    down = patch[:, 2:, 1:-1] - patch[:, :-2, 1:-1]
    tensor = np.empty((len(patch), 2, 2))
    tensor[:, 0, 0] = np.einsum("nij,nij->n", across, across)  # of whole numbers, so exact in any order
    tensor[:, 1, 1] = np.einsum("nij,nij->n", down, down)
    tensor[:, 0, 1] = tensor[:, 1, 0] = np.einsum("nij,nij->n", across, down)
    tensor /= 4 * window_px**2
    return tensor


@lru_cache(maxsize=8)
def _window(size: int, width: int) -> NDArray[np.intp]:
    """(size^2,) where in a flat image of that width the pixels of a window lie, from its corner."""
    side = np.arange(size)
    return (side[:, None] * width + side).ravel()


def inverse(matrices: Floats) -> Floats:
    """(N, 2, 2) inverses of symmetric matrices (N, 2, 2)."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    result = np.empty_like(matrices)
    result[:, 0, 0], result[:, 1, 1] = d, a
    result[:, 0, 1] = result[:, 1, 0] = -b
    result /= (a * d - b * b)[:, None, None]
    return result


@dataclass(slots=True)
class _Tracks:
    """What persists of the N points that are followed; rows stay in the order of their identity."""

    trail: Floats  # (G + 1, N, 2) px, newest first
    age: NDArray[np.int64]  # (N,) frames
    identity: NDArray[np.int64]  # (N,) ascending
    first_px: Floats  # (N, 2)
    first_pose: Floats  # (N, 3)
    structure: Floats  # (N, 2, 2)
    next_px: Floats  # (N, 2) the sighting that will replace the first
    next_pose: Floats  # (N, 3)
    next_age: NDArray[np.int64]  # (N,) frames since then
    stuck: Bools  # (N,) as of the last look

    def __len__(self) -> int:
        return len(self.age)

    def keep(self, chosen: Bools) -> None:
        if chosen.all():
            return
        rows = np.flatnonzero(chosen)
        self.trail = self.trail.take(rows, axis=1)
        self.age, self.identity, self.stuck = self.age[rows], self.identity[rows], self.stuck[rows]
        self.first_px, self.first_pose = self.first_px[rows], self.first_pose[rows]
        self.structure = self.structure[rows]
        self.next_px, self.next_pose, self.next_age = self.next_px[rows], self.next_pose[rows], self.next_age[rows]

    def renew_anchor(self, frames: int, pose: Floats) -> None:
        """Where the next sighting is `frames` old, it becomes the first, and the present one the next."""
        due = self.next_age >= frames
        if not due.any():
            return
        column = due[:, None]
        self.first_px = np.where(column, self.next_px, self.first_px)
        self.first_pose = np.where(column, self.next_pose, self.first_pose)
        self.age = np.where(due, self.next_age, self.age)
        self.next_px = np.where(column, self.trail[0], self.next_px)
        self.next_pose = np.where(column, pose, self.next_pose)
        self.next_age = np.where(due, 0, self.next_age)

    def append(self, points_px: Floats, structure: Floats, pose: Floats, next_identity: int) -> None:
        count = len(points_px)
        self.trail = np.concatenate([self.trail, np.broadcast_to(points_px, (len(self.trail), count, 2))], axis=1)
        self.age = np.concatenate([self.age, np.zeros(count, np.int64)])
        self.identity = np.concatenate([self.identity, np.arange(next_identity, next_identity + count)])
        self.first_px = np.concatenate([self.first_px, points_px])
        self.first_pose = np.concatenate([self.first_pose, np.broadcast_to(pose, (count, 3))])
        self.structure = np.concatenate([self.structure, structure])
        self.next_px = np.concatenate([self.next_px, points_px])
        self.next_pose = np.concatenate([self.next_pose, np.broadcast_to(pose, (count, 3))])
        self.next_age = np.concatenate([self.next_age, np.zeros(count, np.int64)])
        self.stuck = np.concatenate([self.stuck, np.zeros(count, np.bool_)])


class FlowTracker:
    """Follows corners frame by frame and reports each one's motion over the window (METHOD 0.7, A4).

    Corners are topped up, not recomputed: each band is searched once a period, beside the points already followed.
    Points known to lie on the road do not count against the band's share, so that new ones are looked for elsewhere;
    nor do points that are stuck to the glass. These are followed on and reported as such.
    """

    def __init__(self, camera: Camera, config: FlowConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.rate_hz = rate_hz
        self._window_frames = max(1, round(config.window_s * rate_hz))
        self._period_frames = max(1, round(config.detect_period_s * rate_hz))
        self._anchor_frames = None if config.anchor_s is None else max(2, round(config.anchor_s * rate_hz))
        self._bands = [(self._rows(band), round(band.share * config.points)) for band in BANDS[config.bands]]
        self._top = max(0, min(rows.start for rows, _ in self._bands) - config.window_px)
        self._bottom = min(camera.height_px, max(rows.stop for rows, _ in self._bands) + config.window_px)
        self._previous: Image | None = None
        self._poses: Floats = np.empty((0, 3))  # newest first
        self._next_identity = 0
        self._frame = 0
        none, pixels, poses = np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 3))
        trail = np.empty((self._window_frames + 1, 0, 2))
        no_bools = np.empty(0, np.bool_)
        self._tracks = _Tracks(trail, none, none, pixels, poses, np.empty((0, 2, 2)), pixels, poses, none, no_bools)

    def update(self, image: Image, pose: Floats, hidden: Image | None = None) -> Flow:
        """The flow seen at the grey (H, W) frame taken at `pose` (x, y, yaw), in undistorted pixels.

        No corners are looked for where `hidden` (H, W) is not 0.
        """
        self._poses = np.concatenate([pose[None], self._poses[: self._window_frames]])
        if self._previous is not None and len(self._tracks):
            self._follow(self._previous, image)
        if self._anchor_frames is not None:
            self._tracks.renew_anchor(self._anchor_frames, pose)
        if self._frame % self._period_frames == 0:
            self._look_for_stuck(pose)
        flow = self._report(pose)
        self._weigh_again(image)
        self._top_up(image, pose, hidden)
        self._previous = image
        self._frame += 1
        return flow

    @property
    def levels(self) -> int:
        """maxLevel of Lucas-Kanade: each level doubles the motion that half a window can follow."""
        if self.config.max_level is not None:
            return self.config.max_level
        motion_px = self.config.reach_px_per_s / self.rate_hz
        return max(1, ceil(log2(motion_px / (self.config.window_px / 2))))

    def _rows(self, band: Band) -> slice:
        edges = self.camera.cy_px + self.camera.fy_px * (
            np.array([band.top, band.bottom]) - np.tan(self.camera.pitch_rad)
        )
        top, bottom = np.clip(edges, 0, self.camera.height_px).astype(int)
        return slice(int(top), int(bottom))

    def _lucas_kanade(
        self, before: Image, after: Image, points: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], Bools]:
        config = self.config
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            before,
            after,
            points,
            np.empty_like(points),
            winSize=(config.window_px, config.window_px),
            maxLevel=self.levels,
            criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, config.iterations, config.epsilon_px),
        )
        return np.asarray(moved, np.float32), status.ravel() == 1

    def _follow(self, before: Image, after: Image) -> None:
        rows = slice(self._top, self._bottom)
        offset = np.array([0.0, self._top])
        points = (self._tracks.trail[0] - offset).astype(np.float32)
        moved, good = self._lucas_kanade(before[rows], after[rows], points)
        if self.config.forward_backward_px is not None and self._frame % self._period_frames == 1 % self._period_frames:
            back, returned = self._lucas_kanade(after[rows], before[rows], moved)
            good &= returned & (np.hypot(*(back - points).T) < self.config.forward_backward_px)
        now = moved.astype(np.float64) + offset
        good &= (now[:, 0] >= 0) & (now[:, 0] <= self.camera.width_px - 1)
        good &= (now[:, 1] >= self._top) & (now[:, 1] <= self._bottom - 1)
        tracks = self._tracks
        tracks.trail, tracks.age, tracks.next_age = tracks.trail[:-1], tracks.age + 1, tracks.next_age + 1
        tracks.keep(good)
        tracks.trail = np.concatenate([now[None, good], tracks.trail])

    def _report(self, pose: Floats) -> Flow:
        tracks = self._tracks
        frames = np.minimum(tracks.age, self._window_frames)
        now, past, first = (
            undistort(self.camera, points)
            for points in (tracks.trail[0], tracks.trail[frames, np.arange(len(tracks))], tracks.first_px)
        )
        return Flow(
            points_px=now,
            displacement_px=now - past,
            gap_s=frames / self.rate_hz,
            past_pose=self._poses[frames],
            pose=pose,
            identity=tracks.identity,
            first_px=first,
            first_pose=tracks.first_pose,
            age_frames=tracks.age,
            structure=tracks.structure,
            stuck=tracks.stuck & np.all(np.abs(now - past) < LOOSE_PX, axis=1),
        )

    def _look_for_stuck(self, pose: Floats) -> None:
        """A point's first sighting in the undistorted frame is near enough to that in the frame as it is."""
        tracks = self._tracks
        if len(tracks):
            tracks.stuck = stuck(self.camera, tracks.trail[0], tracks.first_px, tracks.first_pose, pose)

    def _weigh_again(self, image: Image) -> None:
        """Look at a part of the windows in every frame: what was a corner from afar may be an edge from near.

        The noise of the chained steps adds up, and goes with the inverse of the tensor, so the inverses are averaged.
        """
        tracks = self._tracks
        if not self._guarded:
            return
        due = np.flatnonzero((tracks.identity + self._frame) % self._period_frames == 0)
        if not len(due):
            return
        tensor = structure_tensor(image, tracks.trail[0, due], self.config.window_px)
        looks = 1 + tracks.age[due, None, None] // self._period_frames
        mean = inverse(tracks.structure[due] + FAINT)
        mean = mean + (inverse(tensor + FAINT) - mean) / (looks + 1)
        tracks.structure[due] = inverse(mean) - FAINT
        keep = np.ones(len(tracks), np.bool_)
        keep[due] = self._is_corner(tensor)
        tracks.keep(keep)

    @property
    def _guarded(self) -> bool:
        return self.config.texture_floor > 0.0 or self.config.corner_ratio > 0.0

    def _is_corner(self, tensor: Floats) -> Bools:
        return is_corner(tensor, self.config.texture_floor, self.config.corner_ratio)

    def _top_up(self, image: Image, pose: Floats, hidden: Image | None) -> None:
        """Search the bands whose turn it is; at the start all of them."""
        for index, (rows, quota) in enumerate(self._bands):
            turn = (self._frame - index * self._period_frames // len(self._bands)) % self._period_frames == 0
            if self._frame and not turn:
                continue
            self._drop_settled(rows, quota)
            points = self._tracks.trail[0]
            inside = (points[:, 1] >= rows.start) & (points[:, 1] < rows.stop)
            wanted = quota - np.count_nonzero(inside & ~self._tracks.stuck)
            if wanted >= max(1, quota // 20):
                self._add(self._corners(image, rows, points[inside], int(wanted), hidden), image, pose)

    def _drop_settled(self, rows: slice, quota: int) -> None:
        """Long-lived points of the road make room for new ones: half of the band's share at most."""
        tracks = self._tracks
        points = tracks.trail[0]
        old = (points[:, 1] >= rows.start) & (points[:, 1] < rows.stop) & (tracks.age > 2 * self._window_frames)
        if np.count_nonzero(old) <= quota // 2:
            return
        chosen = np.flatnonzero(old)
        now, first = (undistort(self.camera, of[chosen]) for of in (points, tracks.first_px))
        road = ground_flow(self.camera, now, tracks.first_pose[chosen], self._poses[0])
        residual = np.hypot(*(now - first - road).T)
        settled = chosen[residual < 0.02 * np.hypot(*road.T) + 0.1]
        excess = len(chosen) - quota // 2
        keep = np.ones(len(tracks), np.bool_)
        keep[settled[:excess]] = False  # the oldest first
        tracks.keep(keep)

    def _corners(self, image: Image, rows: slice, taken_px: Floats, count: int, hidden: Image | None) -> Floats:
        config = self.config
        strip = image[rows]
        mask = np.full(strip.shape, 255, np.uint8)
        columns = np.clip(np.rint(taken_px[:, 0]).astype(np.intp), 0, strip.shape[1] - 1)
        lines = np.clip(np.rint(taken_px[:, 1]).astype(np.intp) - rows.start, 0, strip.shape[0] - 1)
        mask[lines, columns] = 0
        size = 2 * round(config.min_distance_px) + 1
        mask = cv2.erode(mask, np.ones((size, size), np.uint8)).astype(np.uint8, copy=False)
        if hidden is not None:
            mask[hidden[rows] != 0] = 0
        found = cv2.goodFeaturesToTrack(
            strip, count, config.quality, config.min_distance_px, mask=mask, blockSize=config.block_px
        )
        if found is None:
            return np.empty((0, 2))
        corners: Floats = found.reshape(-1, 2).astype(np.float64) + np.array([0.0, rows.start])
        return corners

    def _add(self, points_px: Floats, image: Image, pose: Floats) -> None:
        tensor = structure_tensor(image, points_px, self.config.window_px)
        if self._guarded:
            corner = self._is_corner(tensor)
            points_px, tensor = points_px[corner], tensor[corner]
        self._tracks.append(points_px, tensor, pose, self._next_identity)
        self._next_identity += len(points_px)
