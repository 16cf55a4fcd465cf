"""The raster of a far ground level: the image of a camera a little ahead or behind.

A distant pixel covers much more ground along its ray than across. Texels of an image have the same shape; on an even
lattice averaged grain would be stretched along the flow.
"""

from collections.abc import Callable
from itertools import product
from math import cos, inf, sin

import numpy as np

from vpf_sim.envs.camera.ground.levels import Level
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.view import NEAR_M, View
from vpf_sim.geometry import horizon_px
from vpf_sim.types import Camera, Floats, Image

STEP, SIDESTEP, TURN_RAD = 0.38, 0.12, 0.06  # between anchors, in the level's nearest depth; between headings
KEPT, LIMIT = 0.55, 0.7  # steps within which an anchor is kept; limit if the update may be deferred
GOLDEN = 0.618  # phase shift between levels' anchor grids, so that few repaint in the same frame
ROWS = 1.25  # texels per row of pixels
HIGHEST = 0.45  # px, the first texels' middles below the horizon: a corner above it would lie behind the camera

Place = tuple[float, float, float]  # heading, ahead, right: in turns and steps


class FarPatch:
    """The raster of a far level, kept while the camera stays near its anchor."""

    def __init__(self, camera: Camera, level: Level, paint: Callable[[Raster], Image]) -> None:
        self._camera = camera
        self._paint = paint
        self._step, self._sidestep = STEP * level.near_m, SIDESTEP * level.near_m
        self._phase = GOLDEN * level.near_m % 1.0
        (left, top), (right, bottom) = self._corners(level)
        first = max(float(np.floor(top)), horizon_px(camera) + HIGHEST)
        self._to_texels = np.array([[1.0, 0.0, -np.floor(left)], [0.0, ROWS, -ROWS * first], [0.0, 0.0, 1.0]])
        rows, columns = int(np.ceil(ROWS * (bottom - first))) + 2, 2 * int(0.5 * (right - np.floor(left)) + 2.0)
        # puts the clipping plane well before the visible range
        self._scale = camera.height_m * NEAR_M / (0.5 * level.near_m)
        self._texel_m = (level.across_m, level.along_m / ROWS)
        self._place: Place = (0.0, inf, inf)
        self.pixels: Image = np.empty((rows, columns), np.uint8)
        self.from_world = np.eye(3)

    def update(self, view: View, may_defer: bool) -> bool:
        """Repaint the raster if the view needs it; returns whether it did. `may_defer` allows more distance."""
        if self._is_near(view, LIMIT if may_defer else KEPT):
            return False
        turns = self._rounded(view.yaw_rad / TURN_RAD)
        steps, sidesteps = self._steps(view, turns)
        self._place = (turns, self._rounded(steps), self._rounded(sidesteps))
        heading, ahead, right = turns * TURN_RAD, self._place[1] * self._step, self._place[2] * self._sidestep
        forward = np.array([cos(heading), sin(heading)])
        eye = ahead * forward + right * np.array([-forward[1], forward[0]])
        anchor = View.at(self._camera, eye - self._camera.forward_m * forward, heading)
        self.from_world = self._to_texels @ np.linalg.inv(anchor.ground_homography()) * self._scale
        rows, columns = self.pixels.shape
        self.pixels[:] = self._paint(Raster(rows, columns, self.from_world, *self._texel_m))
        return True

    def _is_near(self, view: View, limit: float) -> bool:
        turns, ahead, right = self._place
        steps, sidesteps = self._steps(view, turns)
        aside = max(abs(view.yaw_rad / TURN_RAD - turns), abs(sidesteps - right))
        return max(aside, steps - ahead) < limit and ahead - steps < KEPT

    def _steps(self, view: View, turns: float) -> tuple[float, float]:
        """The camera's position ahead and to the right along a heading, in steps."""
        c, s = cos(turns * TURN_RAD), sin(turns * TURN_RAD)
        x, y = float(view.centre[0]), float(view.centre[1])
        return (c * x + s * y) / self._step, (c * y - s * x) / self._sidestep

    def _rounded(self, steps: float) -> float:
        return round(steps - self._phase) + self._phase

    def _corners(self, level: Level) -> tuple[Floats, Floats]:
        """(2,) and (2,) px, bounds of a level over all poses that keep an anchor."""
        camera = self._camera
        found = []
        for turn, ahead, right in product((-LIMIT * TURN_RAD, LIMIT * TURN_RAD), (-KEPT, LIMIT), (-LIMIT, LIMIT)):
            c, s = cos(turn), sin(turn)
            points = level.corners_m @ np.array([[c, s], [-s, c]])
            points += (ahead * self._step, right * self._sidestep)
            depth = points[:, 0] * cos(camera.pitch_rad) + camera.height_m * sin(camera.pitch_rad)
            down = (camera.height_m / depth - sin(camera.pitch_rad)) / cos(camera.pitch_rad)
            found.append([camera.cx_px + camera.fx_px * points[:, 1] / depth, camera.cy_px + camera.fy_px * down])
        pixels = np.concatenate(found, axis=1)
        return pixels.min(axis=1), pixels.max(axis=1)
