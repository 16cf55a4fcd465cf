"""Puddles at fixed places of the road, most of them in the wheel tracks.

They are the low parts of a height map fixed to the world: more water covers more of it. The map near the car is cached.
"""

from dataclasses import dataclass
from math import cos, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.ground.paint import PAVED_SHOULDER_M
from vpf_sim.envs.camera.layout import LaneShape, outer_edges
from vpf_sim.envs.camera.texture import TILE, grain_tile
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

CELL_M = 0.2
CELLS = 768  # of the map, each way
AHEAD_M = 58.0  # distance from the camera to the map's middle
STEP_M = 24.0  # between possible middles, along both of the world's axes
MAPS = 4  # that are kept: a camera that sways between places computes none anew
ROAD, RUT = 90, 106  # depths, 0..255: flat road, wheel track; 0 is beside the road
CONTOURS = ((1.0, 128), (0.8, 160), (0.6, 195), (0.35, 230))  # shares of a puddle's size, and their depths
SHARP = 24  # depth levels over which a puddle's edge fades
ROUGH = 61  # weight of the grain, of 256
TRACK_M = 0.78  # wheel tracks' distance from the lane's middle
SPACING_M = 3.2  # mean spacing of puddles in the wheel tracks
EDGE_SPACING_M = 9.0  # mean spacing of puddles along the edges
SHIFT = 4
VERTICES = 20

Depths = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class HeightMap:
    """The height map around one place."""

    depths: Depths  # (CELLS, CELLS), rows along world y
    corner_m: Floats  # (2,) world, middle of the first cell

    def from_world(self) -> Floats:
        """(3, 3) from ground points (x, y, 1) m to columns and rows."""
        return np.array(
            [
                [1.0 / CELL_M, 0.0, -self.corner_m[0] / CELL_M],
                [0.0, 1.0 / CELL_M, -self.corner_m[1] / CELL_M],
                [0, 0, 1.0],
            ]
        )


class Puddles:
    """The height map of one road."""

    def __init__(self, shapes: list[LaneShape], seed: int) -> None:
        rng = stream(seed, "puddles")
        self._surfaces = [(shape.left_m, shape.right_m) for shape in shapes]
        self._surfaces += [(edge.at(-0.3), edge.at(PAVED_SHOULDER_M)) for edge in outer_edges(shapes)]
        self._tracks = [shape.at(side * TRACK_M) for shape in shapes for side in (-1.0, 1.0)]
        self._outlines = np.concatenate([_outlines(shape, rng) for shape in shapes])
        self._middles = self._outlines.mean(axis=1)
        self._grain_from = rng.integers(0, TILE, 2)
        self._maps: dict[tuple[int, int], HeightMap] = {}

    def height_map(self, x_m: float, y_m: float, yaw_rad: float) -> HeightMap:
        """The height map of the area ahead of a camera; it depends on this place alone."""
        steps = round((x_m + AHEAD_M * cos(yaw_rad)) / STEP_M), round((y_m + AHEAD_M * sin(yaw_rad)) / STEP_M)
        if steps not in self._maps:
            while len(self._maps) >= MAPS:
                del self._maps[next(iter(self._maps))]
            self._maps[steps] = self._computed(STEP_M * np.array(steps))
        return self._maps[steps]

    def _computed(self, middle: Floats) -> HeightMap:
        first = np.rint(middle / CELL_M).astype(int) - CELLS // 2
        corner = first * CELL_M
        depths = np.zeros((CELLS, CELLS), np.uint8)
        for left, right in self._surfaces:
            for polygon in _fixed(_stretches(left, right, middle), corner):
                cv2.fillPoly(depths, [polygon], ROAD, cv2.LINE_8, SHIFT)
        tracks = [_fixed(track, corner) for track in self._tracks]
        cv2.polylines(depths, tracks, False, RUT, 3, cv2.LINE_8, SHIFT)
        near = np.abs(self._middles - middle).max(axis=1) < 0.5 * CELLS * CELL_M + 10.0
        outlines, middles = self._outlines[near], self._middles[near, None]
        for part, depth in CONTOURS:
            for outline in _fixed(middles + part * (outlines - middles), corner):
                cv2.fillPoly(depths, [outline], depth, cv2.LINE_8, SHIFT)
        y, x = (first[::-1] + self._grain_from[::-1]) % TILE
        grain = grain_tile("water", shortest=4.0, slope=1.1)[y : y + CELLS, x : x + CELLS]
        rough = np.clip(depths + ((grain.astype(np.int16) - 128) * ROUGH >> 8), ROAD - 20, 255)
        depths = np.where(depths > 0, rough, 0).astype(np.uint8)
        return HeightMap(np.asarray(cv2.GaussianBlur(depths, (5, 5), 0.0), np.uint8), corner)


def water_level(puddles: float) -> float:
    """The depth from which water covers the road, for deposits of 0 to 1."""
    return 250.0 - 150.0 * puddles if puddles > 0.0 else 300.0


def covered_table(puddles: float) -> Depths:
    """(256,) cover of water, 0..255, by depth."""
    return _ramp(water_level(puddles), SHARP)


def road_table() -> Depths:
    """(256,) membership to the road, 0..255, by depth."""
    return _ramp(0.5 * ROAD, 30.0)


def _ramp(middle: float, wide: float) -> Depths:
    ramp = np.clip(255.0 * (0.5 + (np.arange(256) - middle) / wide), 0, 255)
    return np.asarray(ramp, np.uint8)


def _outlines(shape: LaneShape, rng: np.random.Generator) -> Floats:
    """(n, VERTICES, 2) world outlines of a lane's puddles at their largest."""
    first, last = float(shape.s_m[0]), float(shape.s_m[-1])
    tracks, edges = (int((last - first) / spacing) + 1 for spacing in (SPACING_M, EDGE_SPACING_M))
    count = tracks + edges
    in_track = np.arange(count) < tracks
    side = rng.choice([-1.0, 1.0], count)
    middle = rng.uniform(first, last, count)
    lateral = side * np.where(in_track, TRACK_M + rng.normal(0.0, 0.08, count), 0.5 * shape.width_m - 0.2)
    long = np.exp(rng.normal(np.log(2.2), 0.6, count))
    wide = np.where(in_track, rng.uniform(0.2, 0.42, count), rng.uniform(0.25, 0.8, count))
    angle = np.linspace(0.0, 2.0 * np.pi, VERTICES, endpoint=False)
    waver = 1.0 + 0.22 * (rng.standard_normal((count, 3, 2)) @ np.stack([np.cos(angle), np.sin(angle)])).mean(axis=1)
    waver *= 1.0 + 0.12 * np.clip(rng.standard_normal((count, VERTICES)), -2.0, 2.0)
    s = np.clip(middle[:, None] + long[:, None] * waver * np.cos(angle), first, last)
    across = lateral[:, None] + wide[:, None] * waver * np.sin(angle)
    return shape.points(s, across)


def _stretches(left: Floats, right: Floats, middle: Floats) -> Floats:
    """(n, 4, 2) quadrilaterals of the strip between two edges near a place."""
    centres = 0.25 * (left[:-1] + left[1:] + right[:-1] + right[1:])
    near = np.flatnonzero(np.abs(centres - middle).max(axis=1) < 0.5 * CELLS * CELL_M + 10.0)
    return np.stack([left[near], left[near + 1], right[near + 1], right[near]], axis=1)


def _fixed(points: Floats, corner: Floats) -> NDArray[np.int32]:
    """World points in OpenCV's fixed-point coordinates of the map."""
    return np.asarray(np.rint((points - corner) / CELL_M * 2**SHIFT), np.int32)
