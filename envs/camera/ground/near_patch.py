"""The raster of a near ground level: an even lattice from above.

The lattice is fixed to the world, with one of a few headings. As the camera drives on, only new rows are painted.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, floor, pi, sin

import numpy as np

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.levels import ACROSS, ALONG, Level
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

TURN_RAD = pi / 26  # between lattice headings
KEPT = 0.6  # a heading is kept within this distance, in turns
STEP, SIDESTEP = 1.2, 0.15  # step of a patch, in the level's nearest depth


@dataclass(frozen=True, slots=True)
class Place:
    """A patch's origin on a lattice, in texels from the world's origin."""

    heading: int  # in turns
    row: int
    column: int


class NearPatch:
    """The raster of a near level, kept from frame to frame."""

    def __init__(self, camera: Camera, level: Level, paint: Callable[[Raster], Image]) -> None:
        across, along = self._texel_m = (ACROSS * level.across_m, ALONG * level.along_m)
        self._paint = paint
        turn = KEPT * TURN_RAD
        turned = np.concatenate([_turned(level.corners_m, angle) for angle in (-turn, 0.0, turn)])
        (self._ahead, self._right), (farthest, rightmost) = turned.min(axis=0), turned.max(axis=0)
        self._step = max(1, round(STEP * level.near_m / detail(camera) / along))  # texels
        self._sidestep = 2 * max(1, round(0.5 * SIDESTEP * level.near_m / across))  # even, as the grain's columns
        rows = int(np.ceil((farthest - self._ahead) / along)) + self._step + 3
        columns = 2 * int(0.5 * (rightmost - self._right) / across + 2.0) + 2 * self._sidestep
        self._place: Place | None = None
        self.pixels: Image = np.empty((rows, columns), np.uint8)
        self.from_world = np.eye(3)

    def update(self, view: View, may_defer: bool) -> bool:  # noqa: ARG002
        """Paint the rows that the view needs; returns whether any were painted. Never deferred."""
        place, before = self._wanted(view), self._place
        if place == before:
            return False
        self._place = place
        rows = len(self.pixels)
        self.from_world = self._raster(place, rows).from_world
        ahead = place.row - before.row if before == replace(place, row=before.row if before else 0) else rows
        fresh = min(abs(ahead), rows)
        kept = rows - fresh
        if ahead > 0:
            self.pixels[:kept] = self.pixels[fresh:]
            self.pixels[kept:] = self._paint(self._raster(replace(place, row=place.row + kept), fresh))
        else:
            self.pixels[fresh:] = self.pixels[:kept]
            self.pixels[:fresh] = self._paint(self._raster(place, fresh))
        return True

    def _wanted(self, view: View) -> Place:
        """The origin from which the patch covers the view; heading and column stay while they fit."""
        before = self._place
        turns = view.yaw_rad / TURN_RAD
        heading = before.heading if before and abs(turns - before.heading) < KEPT else round(turns)
        c, s = cos(heading * TURN_RAD), sin(heading * TURN_RAD)
        x, y = float(view.centre[0]), float(view.centre[1])
        right = (c * y - s * x + self._right) / self._texel_m[0] - 1.0
        ahead = (c * x + s * y + self._ahead) / self._texel_m[1] - 1.0
        row = floor(ahead / self._step) * self._step
        if before and heading == before.heading and 0.0 <= right - before.column <= 2 * self._sidestep:
            return Place(heading, row, before.column)
        return Place(heading, row, (round(right / self._sidestep) - 1) * self._sidestep)

    def _raster(self, place: Place, rows: int) -> Raster:
        c, s = cos(place.heading * TURN_RAD), sin(place.heading * TURN_RAD)
        across, along = self._texel_m
        from_world = np.array(
            [
                [-s / across, c / across, -0.5 - place.column],
                [c / along, s / along, -0.5 - place.row],
                [0.0, 0.0, 1.0],
            ]
        )
        return Raster(rows, self.pixels.shape[1], from_world, across, along)


def _turned(points: Floats, angle: float) -> Floats:
    c, s = cos(angle), sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))
