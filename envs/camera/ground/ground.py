"""Renders the ground: paint, grain and colours of road and verge."""

from functools import partial

import cv2
import numpy as np

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.appearance import ramp
from vpf_sim.envs.camera.ground.gains import even_gains
from vpf_sim.envs.camera.ground.grain import Grain
from vpf_sim.envs.camera.ground.levels import levels
from vpf_sim.envs.camera.ground.paint import painted
from vpf_sim.envs.camera.ground.palette import RAMP, blotch_strength, grain_strength, ground_table
from vpf_sim.envs.camera.ground.patches import patch_of, sample
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.ground.surface import Surface
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.view import View
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

GRAINY_M = (10.0, 30.0)  # texel lengths at which grain starts to fade, and has faded
NEAR_FINE, FAR_FINE = (2, 2), (2, 4)  # supersampling of the raster, across and along


class Ground:
    """Paints every row below the horizon."""

    def __init__(
        self,
        camera: Camera,
        shapes: list[LaneShape],
        light: Light,
        wetness: float,
        seed: int,
        appearance: RoadAppearance | None = None,
    ) -> None:
        self._top = ground_top(camera)
        self._levels = levels(camera)
        batches = painted(shapes, seed)
        self._patches = []
        for level, gain in zip(self._levels, even_gains(camera), strict=True):
            surface = Surface(batches, level.near_m / detail(camera), NEAR_FINE if level.steep else FAR_FINE)
            self._patches.append(patch_of(camera, level, partial(_painted, surface, Grain(level, seed), gain)))
        self._table = ground_table(
            light, wetness, RAMP if appearance is None else ramp(appearance.verge, appearance.surface, appearance.worn)
        )
        self._values = np.empty((camera.height_px - self._top, camera.width_px), np.uint8)
        faded = max((len(level.weights) for level in self._levels), default=0)
        self._over = np.empty((faded, camera.width_px), np.uint8)

    def update(self, view: View) -> None:
        """Update the rasters for a view."""
        painted = False
        for patch in reversed(self._patches):
            painted |= patch.update(view, may_defer=painted)

    @timed("render.ground")
    def draw(self, view: View, frame: Image) -> None:
        """Draw the ground into the frame."""
        if not self._levels:
            return
        self.update(view)
        to_world = view.ground_homography()
        for level, patch in zip(self._levels, self._patches, strict=True):
            for band in level.bands:
                target = self._values[band.first : band.last]
                if not band.faded:
                    sample(patch, band, to_world, target)
                    continue
                over = self._over[: len(target)]
                sample(patch, band, to_world, over)
                first = band.first - level.bands[0].first
                _fade(target, over, level.weights[first : first + len(target)])
        cv2.applyColorMap(self._values, self._table, frame[self._top :])


def _fade(rows: Image, over: Image, weights: Image) -> None:
    """Blend `over` into `rows` in place; weight 255 is opaque."""
    under = cv2.multiply(rows, cv2.bitwise_not(weights), scale=1 / 255)
    cv2.add(under, cv2.multiply(over, weights, scale=1 / 255), rows)


def _painted(surface: Surface, grain: Grain, gain: Floats, raster: Raster) -> Image:
    """(rows, columns) palette values of a raster, with their grain."""
    smooth = surface.paint(raster)
    shortest, longest = GRAINY_M
    shown = np.clip((longest - raster.lengths()) / (longest - shortest), 0.0, 1.0).astype(np.float32)
    steps = np.subtract(grain.draw(raster), 128, dtype=np.float32)
    steps *= gain * shown
    cv2.multiply(steps, cv2.LUT(smooth, grain_strength()), steps)
    blotches = grain.blotches(raster)
    places = cv2.resize(smooth, blotches.shape[::-1], interpolation=cv2.INTER_NEAREST)
    strength = cv2.LUT(places, blotch_strength()) * shown
    blotches = np.rint((blotches - np.float32(128.0)) * strength + np.float32(128.0)).astype(np.uint8)
    smooth = np.asarray(cv2.addWeighted(smooth, 1.0, cv2.resize(blotches, smooth.shape[::-1]), 1.0, -128.0), np.uint8)
    return np.asarray(cv2.add(smooth, steps, dtype=cv2.CV_8U), np.uint8)
