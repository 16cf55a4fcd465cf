"""The grain of the road and the verge, at every distance.

A row of pixels sees the road at one distance D, and each pixel covers D / f across and D^2 / (f h) along it. So the
grain comes in levels of growing texel size. Each level covers a range of rows and fades into the next over an overlap
(a hard switch would draw a line that stands still in the picture, and its crossings with markings look like obstacles).
Within a level the rows are sampled several times as finely as the picture and averaged, which takes out what a row of
pixels cannot show along the road and keeps what it can show across it.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, log, log2

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from vpf_sim.envs.camera.texture import TILE, grain_tile
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image


@dataclass(frozen=True, slots=True)
class Level:
    """One texel size, and how far from the camera it reaches."""

    texel_m: float
    reach_m: float


LEVELS = (Level(0.007, 3.6), Level(0.02, 8.0), Level(0.06, 22.0), Level(0.18, 90.0))
SPECTRA = ((2.6, 0.3), (3.0, 0.2), (3.2, 0.25), (4.0, 0.5))  # shortest wavelength in texels, slope
OVERLAP = 0.75  # a level begins to give way to the next at this part of its reach
GRADIENT = 3.0  # rms difference between neighbouring pixels of a row, in steps of the palette
LARGEST_GAIN = 0.5
CALIBRATION_VIEWS = 6
WARP = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


@dataclass(frozen=True, slots=True)
class Band:
    """Rows of one level with one supersampling; rows are counted from the top of the ground."""

    level: int
    first: int
    last: int  # exclusive
    supersampling: int  # rows sampled per row of the picture
    sampling: Floats  # (3, 3) from pixels of the supersampled, half as wide band to pixels of the picture


def ground_top(camera: Camera) -> int:
    """The first row of the picture that shows the road."""
    horizon = camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad)
    return int(np.clip(np.floor(horizon) + 1, 0, camera.height_px))


def row_distance(camera: Camera) -> Floats:
    """(rows,) m, how far ahead of the camera each row of the ground sees the road."""
    y = (np.arange(ground_top(camera), camera.height_px) - camera.cy_px) / camera.fy_px
    c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    return np.asarray(camera.height_m * (c - s * y) / (c * y + s))


class Grain:
    """The grain of the ground in the picture, laid on the world by a seed."""

    def __init__(self, camera: Camera, seed: int, even: bool = True) -> None:
        self._camera = camera
        self._top = ground_top(camera)
        distance = row_distance(camera)
        self._weights = _weights(distance)
        bands = [band for level in range(len(LEVELS)) for band in self._level_bands(level, distance)]
        self._bands = sorted(bands, key=lambda band: -band.supersampling)
        self._levels = [band.level for band in self._bands]
        self._samplings = np.array([band.sampling for band in self._bands])
        self._tiles = [grain_tile(f"level {i}", *SPECTRA[i]) for i in range(len(LEVELS))]
        self._offsets = stream(seed, "grain").uniform(0.0, TILE, (len(LEVELS), 2))
        self._size = (camera.width_px, len(distance))
        self._half = camera.width_px // 2  # the grain is drawn half as wide as the picture
        self._fine = np.empty((sum(b.supersampling * (b.last - b.first) for b in bands), self._half), np.uint8)
        self._canvas = np.zeros((len(distance), self._half), np.uint8)
        self._picture = np.empty((len(distance), camera.width_px), np.uint8)
        self._set_gains(_even_gains(camera) if even else np.full(len(distance), LARGEST_GAIN))

    def _set_gains(self, gains: Floats) -> None:
        """Give each row of pixels its contrast."""
        levels = [np.repeat(np.rint(w * gains * 256).astype(np.uint8)[:, None], self._half, 1) for w in self._weights]
        self._scaled = np.concatenate([levels[band.level][band.first : band.last] for band in self._bands])
        middle = np.full((len(gains), self._half), 128, np.uint8)
        average = np.sum([cv2.multiply(middle, scaled, scale=1 / 256) for scaled in levels], axis=0, dtype=np.uint8)
        self.mean: Image = np.repeat(average, 2, axis=1)  # (rows, W) what the grain adds on average

    def draw(self, view: View) -> Image:
        """(rows, W) the grain from the top of the ground down, about `mean`; valid until the next call."""
        rows = cv2.multiply(self._sampled(view), self._scaled, scale=1 / 256)
        canvas, first = self._canvas, 0
        canvas[:] = 0
        for band in self._bands:
            part = canvas[band.first : band.last]
            cv2.add(part, rows[first : first + len(part)], part)
            first += len(part)
        return np.asarray(cv2.resize(canvas, self._size, dst=self._picture, interpolation=cv2.INTER_LINEAR), np.uint8)

    def _sampled(self, view: View) -> Image:
        """The rows of all bands, the finest first; as they are halved, those that are sampled less finely join them."""
        texels = np.array([_to_texels(view, *of) for of in zip(LEVELS, self._offsets, strict=True)])
        matrices = (texels @ view.ground_homography())[self._levels] @ self._samplings
        fine, count, supersampling = self._fine, 0, self._bands[0].supersampling
        for band, matrix in zip(self._bands, matrices, strict=True):
            while supersampling > band.supersampling:
                halved = cv2.addWeighted(fine[0:count:2], 0.5, fine[1:count:2], 0.5, 0.0)
                count, supersampling = count // 2, supersampling // 2
                fine[:count] = halved
            rows = fine[count : count + (band.last - band.first) * band.supersampling]
            cv2.warpPerspective(self._tiles[band.level], matrix, rows.shape[::-1], rows, WARP, cv2.BORDER_WRAP)
            count += len(rows)
        return fine[:count]

    def _level_bands(self, index: int, distance: Floats) -> list[Band]:
        shown = np.flatnonzero(self._weights[index] > 1e-3)
        along = np.abs(np.gradient(distance))  # m of road a row covers
        wanted = [2 ** max(0, ceil(log2(along[row] / (2.0 * LEVELS[index].texel_m)))) for row in shown]
        capped = [min(supersampling, 16) for supersampling in wanted]
        edges = [0, *(i for i in range(1, len(shown)) if capped[i] != capped[i - 1]), len(shown)]
        return [
            self._band(index, int(shown[first]), int(shown[last - 1]) + 1, capped[first])
            for first, last in pairwise(edges)
            if last > first
        ]

    def _band(self, level: int, first: int, last: int, fineness: int) -> Band:
        start = self._top + first - 0.5 + 0.5 / fineness
        sampling = np.array([[2.0, 0.0, 0.5], [0.0, 1.0 / fineness, start], [0.0, 0.0, 1.0]])
        return Band(level, first, last, fineness, sampling)


def _weights(distance: Floats) -> Floats:
    """(levels, rows) how much of each level a row shows; squares sum to 1, so that the contrast does not dip."""
    position = np.zeros((len(LEVELS), len(distance)))
    fading_in = np.ones(len(distance))
    for i, level in enumerate(LEVELS):
        phase = np.clip(np.log(distance / level.reach_m) / log(OVERLAP), 0.0, 1.0)  # 1 within, 0 beyond
        fading_out = np.sin(0.5 * np.pi * phase)
        position[i] = fading_in * fading_out
        fading_in = np.cos(0.5 * np.pi * phase)
    return position


@lru_cache(maxsize=4)
def _even_gains(camera: Camera) -> Floats:
    """(rows,) the gains that give every row the same gradient across.

    Where the gradient grows from row to row, Lucas-Kanade follows the rows at the sharper end of its window, which move
    at another speed. Measured on a few views of the grain itself, and smoothed over the rows.
    """
    grain = Grain(camera, 0, even=False)
    rng = stream(0, "grain gains")
    energy = np.zeros(len(grain.mean))
    for _ in range(CALIBRATION_VIEWS):
        view = View.at(camera, rng.uniform(-500.0, 500.0, 2), float(rng.uniform(-np.pi, np.pi)))
        energy += np.mean(np.diff(grain.draw(view).astype(np.float32), axis=1) ** 2, axis=1)
    gradient = np.sqrt(energy / CALIBRATION_VIEWS) / LARGEST_GAIN
    return np.minimum(GRADIENT / np.maximum(gaussian_filter1d(gradient, 1.0), 1e-6), LARGEST_GAIN)


def _to_texels(view: View, level: Level, offset: Floats) -> Floats:
    """(3, 3) from homogeneous world points to texels; a whole number of tiles is taken off, so that all that is in view
    lies within the doubled tile."""
    centre = view.centre[:2] + 0.6 * level.reach_m * np.array([np.cos(view.yaw_rad), np.sin(view.yaw_rad)])
    whole = np.floor((centre / level.texel_m + offset) / TILE - 0.5) * TILE
    shift = offset - whole
    scale = 1.0 / level.texel_m
    return np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]], [0.0, 0.0, 1.0]])
