"""Planar parallax: detects low obstacles where two frames laid out as road differ.

Frames laid out as road agree wherever they show the road. A point at height h moves between them by (K - 1) of the
camera's travel, K = H / (H - h) with the camera's height H. So one shift of the older layout tests one height for the
whole patch (plane and parallax, Irani and Anandan, PAMI 20(6), 1998). Mirror images move the other way.
"""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.geometry import distance_m, rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import ParallaxConfig, odd_cells
from vpf_sim.perception.obstacles.planar_parallax.sensing_range import SensingRange
from vpf_sim.perception.obstacles.planar_parallax.temporal_average import TemporalAverage
from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.birds_eye import lookup
from vpf_sim.perception.road.occlusion import shadow
from vpf_sim.types import Bools, Camera, Floats, Image, LateralExtent, Obstacles, Singles

RELIEF_M = -0.2, 0.6  # from a face, where it is judged


@dataclass(frozen=True, slots=True)
class LowObservation(LateralExtent[float]):
    """An observation of a low obstacle, in vehicle axes."""

    forward_m: float  # where it begins
    left_m: float
    right_m: float
    gain: float  # of a height above the road, in multiples of the noise


@dataclass(slots=True)
class _Layout:
    """A frame laid out as road."""

    patch: Image  # (rows, columns)
    pose: Floats  # (3,)


@dataclass(frozen=True, slots=True)
class _Comparison:
    """The last comparison, and what it was made from."""

    now: Singles  # (rows, columns) the patch
    older: _Layout
    pose: Floats
    road: Singles  # (rows, columns) differences as road
    noise: float


class PlanarParallax:
    """Compares the road ahead with how it looked `baseline_m` before."""

    def __init__(self, camera: Camera, config: ParallaxConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self._period_frames = max(1, round(config.period_s * rate_hz))
        self._since = self._period_frames - 1  # frames since the last observation
        reach = config.far_m + config.reach_ratio * config.baseline_m
        half = config.half_width_m + config.border_m
        self._forward_m: Floats = np.arange(config.near_m, reach, config.cell_m)
        self._right_m: Floats = np.arange(-half, half + 1e-9, config.cell_m)
        self._rows = int(np.count_nonzero(self._forward_m < config.far_m))
        self._noise_rows = int(np.count_nonzero(self._forward_m < config.noise_far_m))
        self._maps, visible = lookup(camera, self._forward_m, self._right_m)
        self._outside = (~visible).astype(np.uint8)  # (rows, columns) 1 where the frame does not reach
        self.lenses_m: tuple[Floats, ...] = ()  # (2,) each, camera positions of the last comparison, now and before
        self._past: deque[_Layout] = deque()
        self._seen: Bools = np.empty((0, 0), np.bool_)  # where it showed the road or what stands on it
        self._last: _Comparison | None = None  # in this frame
        self._window = odd_cells(config.window_m, config.cell_m)
        border = round(config.border_m / config.cell_m)
        self._columns = slice(border, len(self._right_m) - border)
        self._average = TemporalAverage(config.temporal_average.newest)
        self.sight = SensingRange(config.sensing_range, config.near_m, self._period_frames / rate_hz)

    @property
    def looks(self) -> bool:
        """Whether the next frame is due for an observation."""
        return self._since + 1 >= self._period_frames

    def update(
        self, image: Image | None, pose: Floats, footprints: Floats | None = None
    ) -> list[LowObservation] | None:
        """Observations in the frame taken at `pose`; None between observations and without a baseline.

        `image` is None while a wiper hides the road: an observation that is due waits. `footprints` (K, 4, 2) are the
        corners of known obstacles in vehicle axes: what they cover and hide is ignored.
        """
        self._since += 1
        self._last = None
        if image is None or self._since < self._period_frames:
            return None
        self._since = 0
        older = self._older(pose)
        now = self._laid_out(image, pose)
        if older is None:
            return None
        lens = np.array([self.camera.forward_m, 0.0])
        self.lenses_m = lens, vehicle_from_world(world_from_vehicle(lens, older.pose), pose)
        return self._compare(now, older, footprints)

    def relief(self, faces: Obstacles) -> Floats:
        """(K,) how faces in vehicle axes stand out of the road: 1 above it, -1 in its plane, as paint is, 0 untextured.

        The mean over the place of each; nan where this frame does not show it.
        """
        last, found = self._last, np.full(len(faces), np.nan)
        first, end = self._forward_m[0], self._forward_m[self._rows - 1]
        near = (faces.forward_m > first) & (faces.forward_m + RELIEF_M[1] < end)
        if last is None or not near.any():
            return found
        above = [self._difference(last.now, last.older, last.pose, height)[0] for height in self.config.above_m]
        gain = (last.road - np.minimum.reduce(above)) / np.float32(self.config.least_gain * last.noise)
        gain = np.clip(gain, -1.0, 1.0)
        right_m = self._right_m[self._columns]
        for row in np.flatnonzero(near).tolist():
            rows = slice(*np.searchsorted(self._forward_m, faces.forward_m[row] + np.array(RELIEF_M)))
            columns = slice(*np.searchsorted(right_m, [faces.left_m[row], faces.right_m[row]]))
            seen = self._seen[rows, columns]
            if seen.any() and seen.mean() > self.config.least_seen:
                found[row] = float(gain[rows, columns][seen].mean())
        return found

    def _laid_out(self, image: Image, pose: Floats) -> _Layout:
        """Lay out a frame and keep it for later comparisons."""
        now = _Layout(cv2.remap(image, *self._maps, cv2.INTER_LINEAR).astype(np.uint8, copy=False), pose)
        if not self._past or distance_m(pose, self._past[-1].pose) >= self.config.cell_m:
            self._past.append(now)
        return now

    def _older(self, pose: Floats) -> _Layout | None:
        """The latest layout that was taken a baseline away; older ones are dropped."""
        found = None
        while self._past and distance_m(pose, self._past[0].pose) >= self.config.baseline_m:
            found = self._past.popleft()
        if found is not None:
            self._past.appendleft(found)
            if distance_m(pose, found.pose) > self.config.longest_ratio * self.config.baseline_m:
                return None
        return found

    def _compare(self, layout: _Layout, older: _Layout, footprints: Floats | None) -> list[LowObservation]:
        config, pose = self.config, layout.pose
        sharp = layout.patch[: self._rows].astype(np.float32)
        now = np.asarray(cv2.GaussianBlur(sharp, (3, 15), 0), np.float32)[:, self._columns]
        road, free = self._difference(now, older, pose, 0.0)
        noise = self._record_quality(road, free, older.pose, pose)
        self._last = _Comparison(now, older, pose, road, noise)
        if float(road.max()) < config.least_gain * noise:
            self._average.fade()
            return []
        others = [self._difference(now, older, pose, height) for height in config.above_m]
        above = np.minimum.reduce([change for change, _ in others])
        seen = self._seen & (np.minimum.reduce([share for _, share in others]) > config.least_seen)
        if footprints is not None and len(footprints):
            seen &= ~self._covered(footprints)
        weight = np.asarray(seen / np.float32(noise), np.float32)
        grids = [weight * grid for grid in (road, above)]
        return self._observations(seen, *self._average.add(grids, pose, self._between_grids))

    def _record_quality(self, road: Singles, free: Singles, older_pose: Floats, pose: Floats) -> float:
        """Squared grey levels, the noise of an observation, by its differences as `road` and the `free` shares."""
        config = self.config
        some = road[: self._noise_rows : 4, ::4]  # windows overlap: a few suffice
        noise = quantile(some, 0.5) + config.floor_levels2
        self._seen = self._seen_before(older_pose, pose) & (free > config.least_seen)
        strip = np.abs(self._right_m[self._columns]) < config.sensing_range.half_width_m
        share = self._seen[:, strip].mean(axis=1)
        ahead = np.interp(self.sight.forward_m, self._forward_m[: self._rows], share)
        self.sight.record(config.least_gain * noise, quantile(some, 0.1), ahead)
        return noise

    def _observations(self, seen: Bools, road: Singles, above: Singles) -> list[LowObservation]:
        """What stands on the road, by the differences as road and above it."""
        config = self.config
        gain = road - above
        stands = seen & (gain > config.least_gain) & (above < config.most_share * road)
        return self._parts(seen & (road > config.outline_gain), np.where(stands, gain, 0.0))

    def _between_grids(self, older_pose: Floats, pose: Floats) -> Singles:
        """(2, 3) as `_transform`, of the road itself and without the border."""
        transform = self._transform(older_pose, pose, 0.0)
        border = np.array([self._columns.start, 0.0])
        transform[:, 2] += transform[:, :2] @ border - border
        return transform

    def _difference(self, now: Singles, older: _Layout, pose: Floats, height_m: float) -> tuple[Singles, Singles]:
        """Mean squared grey levels between the patch now and the older one, if all stood `height_m` above the road.

        Over the visible cells of a window; the second grid is their share.
        """
        transform, size = self._transform(older.pose, pose, height_m), (len(self._right_m), self._rows)
        flags, border = cv2.WARP_INVERSE_MAP, cv2.BORDER_REPLICATE
        moved = cv2.warpAffine(older.patch, transform, size, flags=flags | cv2.INTER_LINEAR, borderMode=border)
        outside = cv2.warpAffine(self._outside, transform, size, flags=flags | cv2.INTER_NEAREST, borderMode=border)
        hidden = cv2.bitwise_or(outside, self._outside[: self._rows])
        free = np.asarray(hidden[:, self._columns] == 0, np.float32)
        change = (now - cv2.blur(moved.astype(np.float32), (3, 3))[:, self._columns]) * free
        window = odd_cells(self.config.high_pass.window_m, self.config.cell_m)
        change -= free * cv2.blur(change, window) / np.maximum(cv2.blur(free, window), np.float32(0.05))
        share: Singles = np.maximum(self._mean(free), np.float32(0.05))
        summed: Singles = self._mean(change * change) / share
        return summed, share

    def _mean(self, grid: Singles) -> Singles:
        return np.asarray(cv2.blur(grid, self._window), np.float32)

    def _seen_before(self, older_pose: Floats, pose: Floats) -> Bools:
        """(rows, columns) cells whose window lies within the older patch."""
        transform = self._transform(older_pose, pose, 0.0)
        whole = np.full((len(self._forward_m), len(self._right_m)), 255, np.uint8)
        seen = cv2.warpAffine(
            whole, transform, (len(self._right_m), self._rows), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        inside: Bools = cv2.erode(seen, np.ones(self._window[::-1], np.uint8))[:, self._columns] == 255
        return inside

    def _covered(self, footprints: Floats) -> Bools:
        """(rows, columns) cells that known obstacles cover, or hide from the camera now or in the older frame."""
        right = self._right_m[self._columns]
        covered, start = np.zeros((self._rows, right.size), np.uint8), (right[0], self._forward_m[0])
        for corners in footprints:
            for place in self.lenses_m:
                cells = (shadow(corners, place)[:, ::-1] - start) / self.config.cell_m
                cv2.fillConvexPoly(covered, np.rint(cells).astype(np.int32), 1)
        return covered > 0

    def _transform(self, older_pose: Floats, pose: Floats, height_m: float) -> Singles:
        """(2, 3) from cells (column, row) of the patch now to those of the older one."""
        config = self.config
        now, before = rotation(pose[2]), rotation(older_pose[2])
        turn = before.T @ now
        way = pose[:2] - older_pose[:2]
        lens = way + (now - before) @ np.array([self.camera.forward_m, 0.0])  # way of the camera
        stretch = self.camera.height_m / (self.camera.height_m - height_m)
        start = np.array([self._forward_m[0], self._right_m[0]])
        offset = (turn @ start + before.T @ (way + (stretch - 1.0) * lens) - start) / config.cell_m
        return np.array([[turn[1, 1], turn[1, 0], offset[1]], [turn[0, 1], turn[0, 0], offset[0]]], np.float32)

    def _parts(self, outline: Bools, gain: Singles) -> list[LowObservation]:
        """One observation for each connected part of the outline in which something stands."""
        if not gain.any():
            return []
        config = self.config
        count, parts, boxes, _ = cv2.connectedComponentsWithStats((outline | (gain > 0.0)).astype(np.uint8))
        best, standing = np.zeros(count), gain > 0.0
        owner = parts[standing].astype(np.intp)
        np.maximum.at(best, owner, gain[standing])
        half_along, half_across = 0.5 * config.window_m[0], 0.5 * config.window_m[1]
        right_m = self._right_m[self._columns]
        found: list[LowObservation] = []
        for part in np.flatnonzero(best > 0.0).tolist():
            column, row, width = (int(value) for value in boxes[part, :3])
            left, right = right_m[column] + half_across, right_m[column + width - 1] - half_across
            if left <= right:
                near = float(self._forward_m[row]) + half_along
                found.append(LowObservation(near, left, right, float(best[part])))
        return sorted(found, key=lambda one: one.forward_m)
