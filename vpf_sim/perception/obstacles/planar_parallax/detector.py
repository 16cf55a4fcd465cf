"""Planar parallax: detects low obstacles where the road looks otherwise than from farther away.

Two frames laid out as road agree wherever they show the road, whatever is painted on it. What stands h above it is laid
out too far away. It moves on by (K - 1) of the camera's way between the frames, K = H / (H - h) with the camera's
height H. This is the same for all points of one height, so one shift of the older layout tests one height for the whole
patch (plane and parallax, Irani and Anandan, PAMI 20(6), 1998). Mirror images move the other way.
"""

from collections import deque
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from vpf_sim.geometry import distance_m, distort, project, rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.config import ParallaxConfig, WindscreenMaskConfig
from vpf_sim.perception.obstacles.planar_parallax.grids import Grid, least_of, share_of
from vpf_sim.perception.obstacles.planar_parallax.sensing_range import FullRange, LookQuality, SensingRange
from vpf_sim.perception.obstacles.planar_parallax.temporal_average import TemporalAverage
from vpf_sim.perception.obstacles.planar_parallax.windscreen_mask import static_texture, texture
from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.occlusion import shadow
from vpf_sim.types import Bools, Camera, Floats, Image, LateralExtent

WARP, NEAREST = (way | cv2.WARP_INVERSE_MAP for way in (cv2.INTER_LINEAR, cv2.INTER_NEAREST))
WHOLE = 64  # columns: OpenCV rounds what is left over at the end of a row otherwise


@dataclass(frozen=True, slots=True)
class LowObservation(LateralExtent[float]):
    """An observation of something on the road that stands above it, in vehicle axes."""

    forward_m: float  # where it begins
    left_m: float
    right_m: float
    gain: float  # of a height above the road, in multiples of the noise
    sure: bool = True  # whether that is enough for a confirmed track
    truncated: bool = False  # whether it reaches to the near end of the patch


@dataclass(slots=True)
class _Layout:
    """A frame laid out as road. Its water is complete once the next frame has been laid out."""

    patch: Image  # (rows, columns)
    pose: Floats  # (3,)
    texture: Grid  # (rows, columns)
    water: Image  # (rows, columns) 0 where the road is visible: in the frame and not masked


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
        self._maps, self._outside = self._layout()
        self.lenses_m: tuple[Floats, ...] = ()  # (2,) each, camera positions of the last comparison, now and before
        self._past: deque[_Layout] = deque()
        self._contrast: Grid = np.empty((0, 0), np.float32)  # of the last observation, in multiples of the noise
        self._seen: Bools = np.empty((0, 0), np.bool_)  # where it showed the road or what stands on it
        self._window, self._even = config.window_cells, config.even_cells
        border = round(config.border_m / config.cell_m)
        self._columns = slice(border, len(self._right_m) - border)
        self._about = slice(max(border - 1, 0), min(self._columns.stop + 1, len(self._right_m)))  # for the blur
        self._warped = min(-(-self._about.stop // WHOLE) * WHOLE, len(self._right_m))
        self._average = TemporalAverage(config.temporal_average.newest) if config.temporal_average else None
        self.sight: SensingRange | FullRange = (
            SensingRange(config.sensing_range, config.near_m, self._period_frames / rate_hz)
            if config.sensing_range
            else FullRange(config.far_m)
        )

    @property
    def looks(self) -> bool:
        """Whether the next frame is due for an observation."""
        return self._since + 1 >= self._period_frames

    def update(
        self, image: Image | None, pose: Floats, footprints: Floats | None = None
    ) -> list[LowObservation] | None:
        """What stands on the road in the frame taken at `pose`; None between observations and without a baseline.

        `image` is None while a wiper hides the road: an observation that is due waits. `footprints` (K, 4, 2) are the
        corners of known obstacles in vehicle axes. What they cover and hide is left out, since what lies beside one
        would merge with it.
        """
        self._since += 1
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

    def _seen_ahead(self, forward_m: Floats, half_width_m: float) -> Floats:
        """(K,) share of the strip of road ahead that was visible, at places `forward_m` (K,)."""
        near = np.abs(self._right_m[self._columns]) < half_width_m
        share = self._seen[:, near].mean(axis=1)
        ahead: Floats = np.interp(forward_m, self._forward_m[: self._rows], share)
        return ahead

    def _laid_out(self, image: Image, pose: Floats) -> _Layout:
        """Lay out a frame and keep it for later comparisons."""
        config = self.config
        patch = cv2.remap(image, *self._maps, cv2.INTER_LINEAR).astype(np.uint8, copy=False)
        now = _Layout(patch, pose, np.empty((0, 0), np.float32), self._outside)
        if config.windscreen_mask is not None:
            now.texture = texture(patch, config.cell_m, config.windscreen_mask)
            self._mask_water(now, config.windscreen_mask)
        if not self._past or distance_m(pose, self._past[-1].pose) >= config.cell_m:
            self._past.append(now)
        return now

    def _mask_water(self, now: _Layout, mask: WindscreenMaskConfig) -> None:
        """Mask the static texture of a layout and of the last one taken far enough away."""
        far = (one for one in reversed(self._past) if distance_m(now.pose, one.pose) >= mask.least_way_m)
        before = next(far, None)
        if before is not None:
            transform = self._transform(before.pose, now.pose, 0.0)
            size = now.patch.shape[::-1]
            moved = np.asarray(cv2.warpAffine(before.texture, transform, size, flags=WARP), np.float32)
            stays = static_texture(now.texture, before.texture, moved, self.config.cell_m, mask)
            now.water = np.asarray(cv2.max(stays, self._outside), np.uint8)
            before.water = np.asarray(cv2.max(before.water, now.water), np.uint8)

    def _layout(self) -> tuple[tuple[Any, Any], Image]:
        """The look-up of the patch in a frame, as OpenCV wants it; (rows, columns) 1 where the frame does not reach."""
        forward, right = np.meshgrid(self._forward_m, self._right_m, indexing="ij")
        pixels = distort(self.camera, project(self.camera, np.stack([forward, right, np.zeros_like(right)], axis=-1)))
        x, y = np.nan_to_num(pixels, nan=-10.0).astype(np.float32).transpose(2, 0, 1)
        inside = (x >= 0.0) & (x <= self.camera.width_px - 1) & (y >= 0.0) & (y <= self.camera.height_px - 1)
        exact, table = cv2.convertMaps(x, y, cv2.CV_16SC2)
        return (exact, table), (~inside).astype(np.uint8)

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
        dry = (layout.water[: self._rows, self._columns] == 0).astype(np.uint8)
        road, free = self._difference(now, dry, older, pose, 0.0)
        noise = self._record_quality(road, free, older.pose, pose)
        if float(road.max()) < config.tentative_gain * noise:
            if self._average is not None:
                self._average.fade()
            return []
        heights = (*config.above_m, *(config.mirror_heights.heights_m if config.mirror_heights else ()))
        others = [self._difference(now, dry, older, pose, height) for height in heights]
        above = least_of([change for change, _ in others[: len(config.above_m)]])
        below = least_of([change for change, _ in others[len(config.above_m) :] or others])
        seen = self._seen & (least_of([share for _, share in others]) > config.least_seen)
        if footprints is not None and len(footprints):
            seen &= ~self._covered(footprints)
        weight = np.asarray(seen / np.float32(noise), np.float32)
        grids = [weight * grid for grid in (road, above, below, self._of_edges(now))]
        if self._average is not None:
            grids = self._average.add(grids, pose, self._between_grids)
        return self._observations(seen, *grids)

    def _record_quality(self, road: Grid, free: Grid, older_pose: Floats, pose: Floats) -> float:
        """Squared grey levels, the noise of an observation, by its differences as `road` and the `free` shares."""
        config = self.config
        some = road[: self._noise_rows : 4, ::4]  # windows overlap: a few suffice
        noise = quantile(some, 0.5) + config.floor_levels2
        self._contrast = road / np.float32(noise)
        self._seen = self._seen_before(older_pose, pose) & (free > config.least_seen)
        if config.sensing_range is not None and isinstance(self.sight, SensingRange):
            grain = quantile(some, config.sensing_range.grain_quantile)
            ahead = self._seen_ahead(self.sight.forward_m, config.sensing_range.half_width_m)
            self.sight.record(LookQuality(config.tentative_gain * noise, grain, ahead))
        return noise

    def _observations(self, seen: Bools, road: Grid, above: Grid, below: Grid, edges: Grid) -> list[LowObservation]:
        """What stands on the road, by the differences as road, above and below it, and at the edges of paint."""
        config = self.config
        gain = road - above
        stands = seen & (gain > config.tentative_gain) & (above < config.most_share * road)
        if config.mirror_heights is not None:
            stands &= below > above
        if config.paint_edges is not None:
            stands &= road > edges
        return self._parts(seen & (road > config.outline_gain), np.where(stands, gain, 0.0))

    def _between_grids(self, older_pose: Floats, pose: Floats) -> Grid:
        """(2, 3) as `_transform`, of the road itself and without the border."""
        transform = self._transform(older_pose, pose, 0.0)
        border = np.array([self._columns.start, 0.0])
        transform[:, 2] += transform[:, :2] @ border - border
        return transform

    def _difference(self, now: Grid, dry: Image, older: _Layout, pose: Floats, height_m: float) -> tuple[Grid, Grid]:
        """Squared grey levels between the patch now and the older one, if all stood `height_m` above the road.

        Means over the cells of a window that water hides in neither. The second grid is the share of these cells,
        `scaled_share` at least.
        """
        transform, size = self._transform(older.pose, pose, height_m), (self._warped, self._rows)
        moved = cv2.warpAffine(older.patch, transform, size, flags=WARP, borderMode=cv2.BORDER_REPLICATE)
        wet = cv2.warpAffine(older.water, transform, size, flags=NEAREST, borderMode=cv2.BORDER_REPLICATE)
        free = np.asarray(cv2.subtract(dry, wet[:, self._columns]), np.uint8)
        seen = free.astype(np.float32)
        blurred = cv2.blur(moved[:, self._about].astype(np.float32), (3, 3))
        begin = self._columns.start - self._about.start
        change = (now - blurred[:, begin : begin + now.shape[1]]) * seen
        least = self.config.scaled_share
        if self._even is not None:
            change -= seen * cv2.blur(change, self._even) / share_of(free, self._even, least)
        share = share_of(free, self._window, least)
        return self._summed(change * change) / share, share

    def _of_edges(self, now: Grid) -> Grid:
        """(rows, columns) squared grey levels of difference that a small misalignment makes at sharp paint."""
        if (edges := self.config.paint_edges) is None:
            return np.zeros_like(now)
        slope = edges.along_m / (2.0 * self.config.cell_m) * cv2.Sobel(now, cv2.CV_32F, 0, 1, ksize=1)
        aside = edges.across_m / (2.0 * self.config.cell_m) * cv2.Sobel(now, cv2.CV_32F, 1, 0, ksize=1)
        return self._summed(slope * slope + aside * aside)

    def _summed(self, change: Grid) -> Grid:
        return np.asarray(cv2.blur(change, self._window), np.float32)

    def _seen_before(self, older_pose: Floats, pose: Floats) -> Bools:
        """(rows, columns) cells whose window lies within the older patch."""
        transform = self._transform(older_pose, pose, 0.0)
        whole = np.full((len(self._forward_m), len(self._right_m)), 255, np.uint8)
        seen = cv2.warpAffine(whole, transform, (len(self._right_m), self._rows), flags=WARP)
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

    def _transform(self, older_pose: Floats, pose: Floats, height_m: float) -> Grid:
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

    def _parts(self, outline: Bools, gain: Grid) -> list[LowObservation]:
        """One for each connected part of the outline in which something stands."""
        if not gain.any():
            return []
        config = self.config
        count, parts, boxes, _ = cv2.connectedComponentsWithStats((outline | (gain > 0.0)).astype(np.uint8))
        best, standing = np.zeros(count), gain > 0.0
        owner = parts[standing].astype(np.intp)
        np.maximum.at(best, owner, gain[standing])
        first = np.full(count, self._rows)
        np.minimum.at(first, owner, standing.nonzero()[0])
        begins = boxes[:, 1]
        if config.dash is not None:
            begins = np.maximum(begins, first - round(config.dash.before_m / config.cell_m))
        least_width_m = config.narrow.least_width_m if config.narrow else 0.0
        half_along, half_across = 0.5 * config.window_m[0], 0.5 * config.window_m[1]
        right_m = self._right_m[self._columns]
        found: list[LowObservation] = []
        for part in np.flatnonzero(best > 0.0).tolist():
            column, _, width = (int(value) for value in boxes[part, :3])
            row = int(begins[part])
            left, right = right_m[column] + half_across, right_m[column + width - 1] - half_across
            if right - left >= least_width_m:
                near = float(self._forward_m[row]) + half_along
                found.append(
                    LowObservation(near, left, right, float(best[part]), bool(best[part] > config.least_gain), row == 0)
                )
        found.sort(key=lambda spot: spot.forward_m)
        if config.far_edge is None:
            return found
        ends_m = config.far_edge.length_m
        return [
            spot for index, spot in enumerate(found) if not any(_is_end(spot, one, ends_m) for one in found[:index])
        ]


def _is_end(spot: LowObservation, nearer: LowObservation, length_m: float) -> bool:
    """Whether an observation is the far edge of an object whose near edge is another one, as sure as it is."""
    overlap = spot.left_m < nearer.right_m and spot.right_m > nearer.left_m and nearer.sure >= spot.sure
    return overlap and spot.forward_m - nearer.forward_m < length_m
