"""Sparse optical flow: Shi-Tomasi corners, pyramidal Lucas-Kanade, and tracks chained from frame to frame."""

from math import ceil, log2

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.geometry import undistort
from vpf_sim.perception.egomotion.corners import inverse, is_corner, structure_tensor
from vpf_sim.perception.egomotion.egomotion_settings import Band, FlowConfig, SettledPointConfig, WiperConfig
from vpf_sim.perception.egomotion.ground_plane import ground_flow
from vpf_sim.perception.egomotion.tracks import Tracks
from vpf_sim.perception.egomotion.windscreen_points import on_glass
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow, Image

Singles = NDArray[np.float32]

FAINT = 1e-2 * np.eye(2)  # keeps the tensor of an empty window invertible
ITERATIONS = 30  # of Lucas-Kanade, at most


def grey(image_rgb: Image) -> Image:
    """(H, W) uint8 luma of an (H, W, 3) RGB image, 0.299 R + 0.587 G + 0.114 B."""
    return cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY).astype(np.uint8, copy=False)


def squares(vectors: Floats) -> Floats:
    """(N,) squared lengths of (N, 2)."""
    x, y = vectors.T
    length: Floats = x * x + y * y
    return length


class FlowTracker:
    """Tracks corners frame by frame and reports each one's motion over the window.

    Corners are topped up, not recomputed: each band is searched once a period, away from the points already tracked.
    Points on the windscreen are tracked and marked, but do not count against the band's share.
    """

    def __init__(self, camera: Camera, config: FlowConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.rate_hz = rate_hz
        self._window_frames = max(1, round(config.window_s * rate_hz))
        self._period_frames = max(1, round(config.detect_period_s * rate_hz))
        self._keyframe_frames = None if config.keyframe_s is None else max(2, round(config.keyframe_s * rate_hz))
        self._jump_px = 0.5 * config.reach_px_per_s / rate_hz
        whole = [(slice(0, camera.height_px), config.points)]
        self._bands = [(self._rows(band), round(band.share * config.points)) for band in config.bands or ()] or whole
        self._top = max(0, min(rows.start for rows, _ in self._bands) - config.window_px)
        self._bottom = min(camera.height_px, max(rows.stop for rows, _ in self._bands) + config.window_px)
        self._corner_px = np.array([0.0, self._top])  # of the tracked part of the image
        self._next_identity = 0
        self._frame = 0
        self._held_until = 0  # the last frame that uses `_held`
        self.restart()

    def restart(self) -> None:
        """Drop all points: too much may have changed since the last frame to find them again."""
        self._previous: Image | None = None
        self._held: Image | None = None  # the last frame before a wiper began its sweep
        self._poses: Floats = np.empty((0, 3))  # newest first
        self._late: Floats = np.empty(0)  # shares of a period, newest first
        self._tracks = Tracks.none(self._window_frames)

    def update(self, image: Image, pose: Floats, hidden: Image | None = None, late: float = 0.0) -> Flow:
        """Flow at the grey (H, W) frame taken at `pose` (x, y, yaw), in undistorted pixels.

        No corners are detected where `hidden` (H, W) is not 0. `late` is the share of a period by which the frame was
        taken after its turn.
        """
        self._poses = np.concatenate([pose[None], self._poses[: self._window_frames]])
        self._late = np.concatenate([[late], self._late[: self._window_frames]])
        if self._previous is not None and len(self._tracks):
            self._follow(self._previous, image)
        if self._keyframe_frames is not None:
            self._tracks.renew_first(self._keyframe_frames, pose)
        if self._frame % self._period_frames == 0:
            self._mark_windscreen_points(pose)
        flow = self._report(pose)
        self._update_structure(image)
        if not self.is_swept:  # a blade has corners too
            self._top_up(image, pose, hidden)
        self._previous = image
        self._frame += 1
        return flow

    @property
    def is_swept(self) -> bool:
        """Whether a wiper sweeps across the last frame."""
        return self._held is not None

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
        self, before: Image, after: Image, points_px: Floats, guess_px: Floats
    ) -> tuple[Floats, Bools, Singles]:
        """(N, 2) where points are in `after`, (N,) whether they were found, (N,) grey difference of the windows."""
        config = self.config
        rows, offset = slice(self._top, self._bottom), self._corner_px
        points = (points_px - offset).astype(np.float32)
        moved, status, error = cv2.calcOpticalFlowPyrLK(
            before[rows],
            after[rows],
            points,
            (guess_px - offset).astype(np.float32),
            winSize=(config.window_px, config.window_px),
            maxLevel=self.levels,
            criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, ITERATIONS, config.epsilon_px),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return moved + offset, status.ravel() == 1, error.ravel().astype(np.float32, copy=False)

    def _follow(self, before: Image, after: Image) -> None:
        tracks = self._tracks
        now, found, good, error = self._tracked(before, after)
        if self.config.wiper is not None:
            now, good = self._hold((before, after), now, found, good, error, self.config.wiper)
        good &= (now[:, 0] >= 0) & (now[:, 0] <= self.camera.width_px - 1)
        good &= (now[:, 1] >= self._top) & (now[:, 1] <= self._bottom - 1)
        tracks.trail = np.concatenate([now[None], tracks.trail[:-1]])
        tracks.age, tracks.next_age = tracks.age + 1, tracks.next_age + 1
        tracks.keep(good)
        if not tracks.occluded.any():
            self._held = None

    def _tracked(self, before: Image, after: Image) -> tuple[Floats, Bools, Bools, Singles]:
        """As `_lucas_kanade`, and before the last (N,) whether points also return, which is checked once a period.

        With `from_road` the search begins where a point of the road would be now: of stripes, which look alike, the
        nearest is found.
        Covered points are not tracked: `_hold` searches for them.
        """
        points, seen = self._tracks.trail[0], np.flatnonzero(self._tracks.occluded == 0)
        shift = np.where(self._tracks.on_glass[seen, None], 0.0, self._expected(points[seen]))
        now, (found, good) = points.copy(), np.zeros((2, len(points)), np.bool_)
        error = np.zeros(len(points), np.float32)
        if len(seen):
            now[seen], found[seen], error[seen] = self._lucas_kanade(before, after, points[seen], points[seen] + shift)
        good[:] = found
        limit_px = self.config.forward_backward_px
        if len(seen) and limit_px is not None and self._frame % self._period_frames == 1 % self._period_frames:
            back, returned, _ = self._lucas_kanade(after, before, now[seen], now[seen] - shift)
            good[seen] &= returned & (np.hypot(*(back - points[seen]).T) < limit_px)
        return now, found, good, error

    def _expected(self, points_px: Floats) -> Floats:
        """(N, 2) px that points (N, 2) of the last frame have moved since if they are on the road, or far away."""
        if not self.config.from_road:
            return np.zeros_like(points_px)
        now, last = self._poses[:1], self._poses[1]
        most = self.config.reach_px_per_s / self.rate_hz
        return np.clip(-ground_flow(self.camera, undistort(self.camera, points_px), now, last), -most, most)

    def _hold(
        self, frames: tuple[Image, Image], now_px: Floats, found: Bools, good: Bools, error: Singles, wiper: WiperConfig
    ) -> tuple[Floats, Bools]:
        """(N, 2) where points are now, and (N,) which are kept, if a wiper's blade sweeps across them.

        A point that jumps or changes its appearance is occluded: it is predicted, not reported, and searched for in
        every frame by its window before the sweep. Without a sweep, a point that jumps is lost.
        """
        tracks = self._tracks
        jumps, turn = self._jumps(now_px, found)
        if self._held is None:
            if np.count_nonzero(jumps) <= max(wiper.swept_least, wiper.swept_share * len(tracks)):
                return now_px, good & ~jumps
            hold_frames = max(1, round(wiper.hold_s * self.rate_hz))
            self._held, self._held_until = frames[0], self._frame + hold_frames
            tracks.held_px = tracks.trail[0].copy()
        seen = found & ~jumps
        usual = median(error[seen]) if seen.any() else 0.0
        limit = max(wiper.covered_levels, wiper.covered_ratio * usual)
        occluded = ~seen | (error > limit)
        now = self._search(frames[1], now_px, occluded, turn, limit)
        kept = occluded | good
        if self._frame >= self._held_until:  # a point that has not come back by now was a drop
            kept &= tracks.occluded == 0
        return now, kept

    def _jumps(self, now_px: Floats, found: Bools) -> tuple[Bools, Floats]:
        """(N,) points whose motion changes more than any tracked point's does, and (2,) the median change: a turn."""
        tracks = self._tracks
        known = found & (tracks.age > 0)
        jump = now_px - 2.0 * tracks.trail[0] + tracks.trail[1]
        far = known & (squares(jump) > self._jump_px**2)
        if not far.any():
            return far, np.zeros(2)
        turn = np.array([median(part) for part in jump[known].T])
        return known & (squares(jump - turn) > self._jump_px**2), turn

    def _search(self, after: Image, now_px: Floats, occluded: Bools, turn_px: Floats, limit: float) -> Floats:
        """(N, 2) where points are now; occluded ones where they are found again, or predicted."""
        tracks = self._tracks
        tracks.occluded = np.where(occluded, tracks.occluded + 1, 0)
        expected = 2.0 * tracks.trail[0] - tracks.trail[1] + turn_px
        now = np.where(occluded[:, None], expected, now_px)
        sought = np.flatnonzero(occluded)
        if len(sought) and self._held is not None:
            place, found, differs = self._lucas_kanade(self._held, after, tracks.held_px[sought], expected[sought])
            aside = place - expected[sought]
            found &= (differs < limit) & (np.hypot(*aside.T) < self._jump_px)
            now[sought[found]] = place[found]
            tracks.uncover(sought[found], aside[found])
        return now

    def _report(self, pose: Floats) -> Flow:
        occluded = self._tracks.occluded > 0
        tracks = self._tracks.select(~occluded) if self.is_swept else self._tracks
        frames = np.minimum(tracks.age, self._window_frames)
        now, past, first = (
            undistort(self.camera, points)
            for points in (tracks.trail[0], tracks.trail[frames, np.arange(len(tracks))], tracks.first_px)
        )
        displacement = now - past
        windscreen = self.config.windscreen_points
        still = np.abs(displacement) < (windscreen.loose_px if windscreen else 0.0)
        return Flow(
            points_px=now,
            displacement_px=displacement,
            gap_s=(frames + (self._late[0] - self._late.take(frames))) / self.rate_hz,
            past_pose=self._poses.take(frames, axis=0),
            pose=pose,
            identity=tracks.identity,
            first_px=first,
            first_pose=tracks.first_pose,
            age_frames=tracks.age,
            structure=tracks.structure,
            on_glass=tracks.on_glass & still[:, 0] & still[:, 1],
            occluded=self._tracks.identity[occluded],
        )

    def _mark_windscreen_points(self, pose: Floats) -> None:
        tracks, config = self._tracks, self.config.windscreen_points
        if len(tracks):
            tracks.on_glass = on_glass(self.camera, tracks.trail[0], tracks.first_px, tracks.first_pose, pose, config)

    def _update_structure(self, image: Image) -> None:
        """Update a part of the structure tensors in every frame: a corner far away may be an edge from near.

        The noise of a step follows the inverse of the tensor, and steps are chained, so the inverses are averaged.
        """
        tracks = self._tracks
        if self.config.corner_test is None:
            return
        due = np.flatnonzero(((tracks.identity + self._frame) % self._period_frames == 0) & (tracks.occluded == 0))
        if not len(due):
            return
        tensor = structure_tensor(image, tracks.trail[0, due], self.config.window_px)
        count = 1 + tracks.age[due, None, None] // self._period_frames
        mean = inverse(tracks.structure[due] + FAINT)
        mean = mean + (inverse(tensor + FAINT) - mean) / (count + 1)
        tracks.structure[due] = inverse(mean) - FAINT
        corner = is_corner(tensor, self.config.corner_test.texture_floor, self.config.corner_test.corner_ratio)
        if not corner.all():
            keep = np.ones(len(tracks), np.bool_)
            keep[due] = corner
            tracks.keep(keep)

    def _top_up(self, image: Image, pose: Floats, hidden: Image | None) -> None:
        """Search the bands whose turn it is; at the start all of them."""
        for index, (rows, quota) in enumerate(self._bands):
            turn = (self._frame - index * self._period_frames // len(self._bands)) % self._period_frames == 0
            if self._frame and not turn:
                continue
            self._drop_settled(rows, quota, self.config.settled_points)
            points = self._tracks.trail[0]
            inside = _in_band(points, rows)
            wanted = quota - np.count_nonzero(inside & ~self._tracks.on_glass)
            if wanted >= max(1, quota // 20):
                self._add(self._corners(image, rows, points[inside], int(wanted), hidden), image, pose)

    def _drop_settled(self, rows: slice, quota: int, config: SettledPointConfig) -> None:
        """Drop the oldest points of the road beyond their share of a band."""
        tracks, most = self._tracks, int(config.kept_share * quota)
        points = tracks.trail[0]
        old = _in_band(points, rows) & (tracks.age > config.age_windows * self._window_frames)
        if np.count_nonzero(old) <= most:
            return
        chosen = np.flatnonzero(old)
        now, first = (undistort(self.camera, of[chosen]) for of in (points, tracks.first_px))
        road = ground_flow(self.camera, now, tracks.first_pose[chosen], self._poses[0])
        residual = np.hypot(*(now - first - road).T)
        settled = chosen[residual < config.residual_share * np.hypot(*road.T) + config.residual_px]
        excess = len(chosen) - most
        keep = np.ones(len(tracks), np.bool_)
        keep[settled[:excess]] = False  # the oldest first
        tracks.keep(keep)

    def _corners(self, image: Image, rows: slice, taken_px: Floats, count: int, hidden: Image | None) -> Floats:
        config = self.config
        strip = image[rows]
        mask = np.full(strip.shape, 255, np.uint8)
        columns, lines = np.rint(taken_px).astype(np.intp).T
        mask[np.minimum(lines - rows.start, len(strip) - 1), columns] = 0
        size = 2 * round(config.min_distance_px) + 1
        mask = cv2.erode(mask, np.ones((size, size), np.uint8)).astype(np.uint8, copy=False)
        if hidden is not None:
            mask[hidden[rows] != 0] = 0
        found = cv2.goodFeaturesToTrack(strip, count, config.quality, config.min_distance_px, mask=mask)
        if found is None:
            return np.empty((0, 2))
        corners: Floats = found.reshape(-1, 2).astype(np.float64) + np.array([0.0, rows.start])
        return corners

    def _add(self, points_px: Floats, image: Image, pose: Floats) -> None:
        tensor = structure_tensor(image, points_px, self.config.window_px)
        test = self.config.corner_test
        if test is not None:
            corner = is_corner(tensor, test.texture_floor, test.corner_ratio)
            points_px, tensor = points_px[corner], tensor[corner]
        self._tracks.append(points_px, tensor, pose, self._next_identity)
        self._next_identity += len(points_px)


def _in_band(points_px: Floats, rows: slice) -> Bools:
    """(N,) points in these rows of the image."""
    inside: Bools = (points_px[:, 1] >= rows.start) & (points_px[:, 1] < rows.stop)
    return inside
