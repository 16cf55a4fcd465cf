"""Where the road ahead does not look as it did from farther away: what stands on it, however flat.

Two frames laid out as road agree wherever they show the road, whatever is painted on it. What stands h above it is laid
out too far away, and seems to move on by (K - 1) of the camera's own way between the frames, K = H / (H - h) with the
camera's height H: the same for all points of one height, so one shift of the older layout tests one height for the
whole patch (plane and parallax, Irani and Anandan, PAMI 20(6), 1998). Mirror images move the other way.
"""

from collections import deque
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import cv2
import numpy as np

from vpf_sim.geometry import distance_m, distort, project, rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.planar_parallax.sensing_range import LookQuality, SensingRange, SensingRangeConfig
from vpf_sim.perception.obstacles.planar_parallax.temporal_average import Evidence, Grid
from vpf_sim.perception.obstacles.planar_parallax.windscreen_mask import (
    WindscreenMaskConfig,
    odd_cells,
    static_texture,
    texture,
)
from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.occlusion import shadow
from vpf_sim.types import Bools, Camera, Floats, Image, LateralExtent, Obstacles

WARP, NEAREST = (way | cv2.WARP_INVERSE_MAP for way in (cv2.INTER_LINEAR, cv2.INTER_NEAREST))
WHOLE = 64  # columns: OpenCV rounds what is left over at the end of a row otherwise
GRAIN_SHARE = 0.1  # of the patch, that no mirror image disturbs
FAINT = 0.05  # share of a window, below which what is seen there is not scaled up


@dataclass(frozen=True, slots=True)
class ParallaxConfig:
    """The patch of road that is looked at, the heights that are tried, and what counts as one."""

    period_s: float = 0.1  # between looks
    baseline_m: float = 4.5  # the own way between the two frames, at least
    near_m: float = 6.5  # of the patch, from the pose
    far_m: float = 16.0
    noise_far_m: float = 13.5  # up to which the noise is measured: beyond, two pictures of a road hardly differ
    half_width_m: float = 3.4
    border_m: float = 2.6  # by which the older patch is wider, for turns
    cell_m: float = 0.05
    above_m: tuple[float, ...] = (0.1, 0.15, 0.2)
    below_m: tuple[float, ...] = (-0.1, -0.2)
    window_m: tuple[float, float] = (0.45, 0.65)  # along and across, over which differences are summed
    even_m: tuple[float, float] = (1.25, 0.25)  # slower changes do not count: mirror images are long along the way
    floor_levels2: float = 1.5  # of the noise, grey levels^2
    newest: float = 0.3  # share of a look in the averages over looks, of which is asked:
    least_gain: float = 6.0  # by which a height above the road fits better, in multiples of the noise,
    doubt_gain: float = 3.0  # and from which on it is suspected to
    most_share: float = 0.3  # of the difference left with it
    apart_m: tuple[float, float] = (0.11, 0.03)  # along and across, what two pictures of the road may be apart
    outline_gain: float = 3.0  # what counts as outline of a spot
    begins_m: float = 0.8  # before the first cell that stands a spot may begin: a dash before it differs as well
    length_m: float = 2.5  # what begins so near behind a spot, and overlaps it, is its far edge
    least_width_m: float = 0.2  # narrower ones are the rim of something else
    foot_m: tuple[float, float] = (0.6, 0.15)  # along from where a body begins, and beside it, its foot is looked at;
    foot_width_m: float = 0.5  # so much of it at least,
    foot_share: float = 0.6  # and this share of that must be seen
    least_seen: float = 0.5  # share of a window that water must leave free
    water: WindscreenMaskConfig = field(default_factory=WindscreenMaskConfig)
    sight: SensingRangeConfig = field(default_factory=SensingRangeConfig)

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not self.near_m < self.noise_far_m <= self.far_m:
            raise ValueError(f"noise_far_m: expected {self.near_m} to {self.far_m}, got {self.noise_far_m}")
        if not self.begins_m >= 0.0:
            raise ValueError(f"begins_m: expected >= 0, got {self.begins_m}")
        if not 0.0 < self.newest <= 1.0:
            raise ValueError(f"newest: expected 0 < newest <= 1, got {self.newest}")
        for key, (across, along) in (("window_m", self.window_cells), ("even_m", self.even_cells)):
            if across * along > 255:
                raise ValueError(f"{key}: expected 255 cells at most, got {across} x {along}")
        if not self.least_seen >= FAINT:
            raise ValueError(f"least_seen: expected >= {FAINT}, got {self.least_seen}")
        if not 0.0 < self.doubt_gain <= self.least_gain:
            raise ValueError(f"doubt_gain: expected > 0 and <= least_gain = {self.least_gain}, got {self.doubt_gain}")

    @property
    def window_cells(self) -> tuple[int, int]:
        """Across and along, of the window whose mean is compared."""
        return round(self.window_m[1] / self.cell_m), round(self.window_m[0] / self.cell_m)

    @property
    def even_cells(self) -> tuple[int, int]:
        """Across and along, of the window whose mean is taken off."""
        return odd_cells(self.even_m[1], self.cell_m), odd_cells(self.even_m[0], self.cell_m)


@dataclass(frozen=True, slots=True)
class LowObservation(LateralExtent[float]):
    """A place on the road that stands above it, in vehicle axes."""

    forward_m: float  # where it begins
    left_m: float
    right_m: float
    gain: float  # of a height above the road, in multiples of the noise
    sure: bool = True  # whether that is enough; otherwise it is suspected
    cut: bool = False  # whether it may begin nearer, where nothing is looked at


@dataclass(slots=True)
class _Layout:
    """A frame laid out as road. The cells with water are known fully once the next frame has been laid out."""

    patch: Image  # (rows, columns)
    pose: Floats  # (3,)
    texture: Grid  # (rows, columns)
    water: Image  # (rows, columns) 0 where the road is seen, neither hidden nor beyond the frame


class PlanarParallax:
    """Compares the road ahead with how it looked `baseline_m` before."""

    def __init__(self, camera: Camera, config: ParallaxConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self._period_frames = max(1, round(config.period_s * rate_hz))
        self._since = self._period_frames - 1  # frames since the last look
        reach = config.far_m + 1.5 * config.baseline_m
        half = config.half_width_m + config.border_m
        self._forward_m: Floats = np.arange(config.near_m, reach, config.cell_m)
        self._right_m: Floats = np.arange(-half, half + 1e-9, config.cell_m)
        self._rows = int(np.count_nonzero(self._forward_m < config.far_m))
        self._noise_rows = int(np.count_nonzero(self._forward_m < config.noise_far_m))
        self._maps, self._outside = self._layout()
        self.lenses_m: tuple[Floats, ...] = ()  # (2,) each, the camera's places of the last comparison, now and before
        self._past: deque[_Layout] = deque()
        self._contrast: Grid = np.empty((0, 0), np.float32)  # of the last look, in multiples of the noise
        self._seen: Bools = np.empty((0, 0), np.bool_)  # where it saw the road or what stands on it
        self._window, self._even = config.window_cells, config.even_cells
        border = round(config.border_m / config.cell_m)
        self._columns = slice(border, len(self._right_m) - border)
        # And what they blur with.
        self._about = slice(max(border - 1, 0), min(self._columns.stop + 1, len(self._right_m)))
        self._warped = min(-(-self._about.stop // WHOLE) * WHOLE, len(self._right_m))
        self._evidence = Evidence(config.newest)
        self.sight = SensingRange(config.sight, config.near_m, self._period_frames / rate_hz)

    @property
    def looks(self) -> bool:
        """Whether the next frame is one that is looked at."""
        return self._since + 1 >= self._period_frames

    def update(
        self, image: Image | None, pose: Floats, footprints: Floats | None = None
    ) -> list[LowObservation] | None:
        """What stands on the road in the frame taken at `pose`; None between looks and before there is a baseline.

        None for a frame that shows something else, as a wiper: a look that is due waits for the next that does not.
        What known bodies cover and hide is left out: what lies beside one would run together with it. `footprints`
        (K, 4, 2) are their corners in vehicle axes.
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

    def difference_at(self, bodies: Obstacles) -> Floats:
        """(N,) largest difference in the last look where each body should begin, in multiples of the noise.

        The bodies are in its vehicle axes; nan for one whose foot it did not see.
        """
        forward, right = self._forward_m[: self._rows], self._right_m[self._columns]
        along_m, across_m = self.config.foot_m
        found = np.full(len(bodies), np.nan)
        for index, (face, left, side, sigma) in enumerate(
            zip(bodies.forward_m, bodies.left_m, bodies.right_m, bodies.sigma_m, strict=True)
        ):
            rows = np.searchsorted(forward, (face - 0.5 * along_m - sigma, face + along_m + 2.0 * sigma))
            columns = np.searchsorted(right, (left - across_m, side + across_m))
            foot = slice(*rows), slice(*columns)
            seen = self._seen[foot]
            inside = face > forward[0] and face + along_m < self.config.noise_far_m  # beyond, faint ones look like road
            wide = seen.shape[1] * self.config.cell_m >= self.config.foot_width_m
            if inside and wide and seen.mean() >= self.config.foot_share:
                found[index] = self._contrast[foot][seen].max()
        return found

    def _seen_ahead(self) -> Floats:
        """(K,) share of the road ahead that the last look saw, at each place of `sight`."""
        near = np.abs(self._right_m[self._columns]) < self.config.sight.half_width_m
        share = self._seen[:, near].mean(axis=1)
        ahead: Floats = np.interp(self.sight.forward_m, self._forward_m[: self._rows], share)
        return ahead

    def _laid_out(self, image: Image, pose: Floats) -> _Layout:
        """The frame as the newest of those remembered."""
        config = self.config
        patch = cv2.remap(image, *self._maps, cv2.INTER_LINEAR).astype(np.uint8, copy=False)
        now = _Layout(patch, pose, texture(patch, config.cell_m, config.water), self._outside)
        least_m = config.water.least_way_m
        before = next((one for one in reversed(self._past) if distance_m(pose, one.pose) >= least_m), None)
        if before is not None:
            transform = self._transform(before.pose, pose, 0.0)
            moved = np.asarray(cv2.warpAffine(before.texture, transform, patch.shape[::-1], flags=WARP), np.float32)
            stays = static_texture(now.texture, before.texture, moved, config.cell_m, config.water)
            now.water = np.asarray(cv2.max(stays, self._outside), np.uint8)
            before.water = np.asarray(cv2.max(before.water, now.water), np.uint8)
        if not self._past or distance_m(pose, self._past[-1].pose) >= config.cell_m:
            self._past.append(now)
        return now

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
            if distance_m(pose, found.pose) > 1.4 * self.config.baseline_m:
                return None
        return found

    def _compare(self, layout: _Layout, older: _Layout, footprints: Floats | None) -> list[LowObservation]:
        config, pose = self.config, layout.pose
        sharp = layout.patch[: self._rows].astype(np.float32)
        now = np.asarray(cv2.GaussianBlur(sharp, (3, 15), 0), np.float32)[:, self._columns]
        dry = (layout.water[: self._rows, self._columns] == 0).astype(np.uint8)

        def difference(height_m: float) -> tuple[Grid, Grid]:
            return self._difference(now, dry, older, pose, height_m)

        road, free = difference(0.0)
        some = road[: self._noise_rows : 4, ::4]  # windows overlap: a few tell
        grain, usual = quantile(some, GRAIN_SHARE), quantile(some, 0.5)
        noise = usual + config.floor_levels2
        self._contrast = road / np.float32(noise)
        self._seen = self._seen_before(older.pose, pose) & (free > config.least_seen)
        self.sight.record(LookQuality(config.doubt_gain * noise, grain, self._seen_ahead()))
        if float(road.max()) < config.doubt_gain * noise:
            self._evidence.fade()
            return []
        others = [difference(height) for height in (*config.above_m, *config.below_m)]
        above = _least([change for change, _ in others[: len(config.above_m)]])
        below = _least([change for change, _ in others[len(config.above_m) :]])
        seen = self._seen & (_least([share for _, share in others]) > config.least_seen)
        if footprints is not None and len(footprints):
            seen &= ~self._covered(footprints)
        weight = np.asarray(seen / np.float32(noise), np.float32)
        grids = [weight * grid for grid in (road, above, below, self._of_edges(now))]
        road, above, below, edges = self._evidence.add(grids, pose, self._between_grids)
        gain = road - above
        stands = seen & (gain > config.doubt_gain) & (above < config.most_share * road) & (below > above)
        stands &= road > edges
        return self._low_tracks(seen & (road > config.outline_gain), np.where(stands, gain, 0.0))

    def _between_grids(self, older_pose: Floats, pose: Floats) -> Grid:
        """(2, 3) as `_transform`, of the road itself and without the border."""
        transform = self._transform(older_pose, pose, 0.0)
        border = np.array([self._columns.start, 0.0])
        transform[:, 2] += transform[:, :2] @ border - border
        return transform

    def _difference(self, now: Grid, dry: Image, older: _Layout, pose: Floats, height_m: float) -> tuple[Grid, Grid]:
        """Squared grey levels between the patch now and the older one, if all stood `height_m` above the road.

        They are means over the cells of the window that water hides in neither; the second tells the share of these,
        FAINT at least.
        """
        transform, size = self._transform(older.pose, pose, height_m), (self._warped, self._rows)
        moved = cv2.warpAffine(older.patch, transform, size, flags=WARP, borderMode=cv2.BORDER_REPLICATE)
        wet = cv2.warpAffine(older.water, transform, size, flags=NEAREST, borderMode=cv2.BORDER_REPLICATE)
        free = np.asarray(cv2.subtract(dry, wet[:, self._columns]), np.uint8)
        seen = free.astype(np.float32)
        blurred = cv2.blur(moved[:, self._about].astype(np.float32), (3, 3))
        begin = self._columns.start - self._about.start
        change = (now - blurred[:, begin : begin + now.shape[1]]) * seen
        change -= seen * cv2.blur(change, self._even) / _share(free, self._even)
        share = _share(free, self._window)
        return self._summed(change * change) / share, share

    def _of_edges(self, now: Grid) -> Grid:
        """(rows, columns) squared grey levels that differ when the two pictures of sharp paint are a little apart."""
        along_m, across_m = self.config.apart_m
        slope = along_m / (2.0 * self.config.cell_m) * cv2.Sobel(now, cv2.CV_32F, 0, 1, ksize=1)
        aside = across_m / (2.0 * self.config.cell_m) * cv2.Sobel(now, cv2.CV_32F, 1, 0, ksize=1)
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
        """(rows, columns) cells that bodies cover, or hide from the camera now or in the older frame."""
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
        lens = way + (now - before) @ np.array([self.camera.forward_m, 0.0])  # the camera's way
        stretch = self.camera.height_m / (self.camera.height_m - height_m)
        start = np.array([self._forward_m[0], self._right_m[0]])
        offset = (turn @ start + before.T @ (way + (stretch - 1.0) * lens) - start) / config.cell_m
        return np.array([[turn[1, 1], turn[1, 0], offset[1]], [turn[0, 1], turn[0, 0], offset[0]]], np.float32)

    def _low_tracks(self, outline: Bools, gain: Grid) -> list[LowObservation]:
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
        begins = np.maximum(boxes[:, 1], first - round(config.begins_m / config.cell_m))
        half_along, half_across = 0.5 * config.window_m[0], 0.5 * config.window_m[1]
        right_m = self._right_m[self._columns]
        found: list[LowObservation] = []
        for part in np.flatnonzero(best > 0.0).tolist():
            column, _, width = (int(value) for value in boxes[part, :3])
            row = int(begins[part])
            left, right = right_m[column] + half_across, right_m[column + width - 1] - half_across
            if right - left >= config.least_width_m:
                near = float(self._forward_m[row]) + half_along
                found.append(
                    LowObservation(near, left, right, float(best[part]), bool(best[part] > config.least_gain), row == 0)
                )
        found.sort(key=lambda spot: spot.forward_m)
        return [spot for index, spot in enumerate(found) if not any(self._is_end(spot, one) for one in found[:index])]

    def _is_end(self, spot: LowObservation, nearer: LowObservation) -> bool:
        """Whether a spot is the far edge of what a nearer one, as sure as it is, is the near edge of."""
        overlap = spot.left_m < nearer.right_m and spot.right_m > nearer.left_m and nearer.sure >= spot.sure
        return overlap and spot.forward_m - nearer.forward_m < self.config.length_m


def _least(grids: list[Grid]) -> Grid:
    """(rows, columns) the least of all grids; numpy minds nan, and takes longer."""
    least, *others = grids
    for grid in others:
        least = np.asarray(cv2.min(least, grid), np.float32)
    return least


def _share(free: Image, window: tuple[int, int]) -> Grid:
    """(rows, columns) share of the cells about each, in a window (columns, rows), that are 1 and not 0; FAINT at least.

    It is `cv2.blur` of them as floats, to the bit: they are fewer than 256, so that bytes count them faster.
    """
    count = cv2.boxFilter(free, -1, window, normalize=False)
    return np.asarray(cv2.LUT(count, _shares(window[0] * window[1])), np.float32)


@lru_cache(maxsize=8)
def _shares(cells: int) -> Grid:
    """(256,) share that a number of cells is of so many."""
    shares: Grid = np.maximum(np.arange(256) * (1.0 / cells), FAINT).astype(np.float32)
    return shares
