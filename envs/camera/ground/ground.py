"""Renders the ground: paint, grain and colours of road and verge."""

from functools import partial

import cv2
import numpy as np

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.appearance import ramp
from vpf_sim.envs.camera.ground.cast_shadows import LIT, darken, shadow_patches
from vpf_sim.envs.camera.ground.gains import even_gains
from vpf_sim.envs.camera.ground.grain import Grain
from vpf_sim.envs.camera.ground.levels import Level, levels
from vpf_sim.envs.camera.ground.paint import GRASS, painted
from vpf_sim.envs.camera.ground.palette import blotch_strength, grain_strength, ground_table, lamp_table
from vpf_sim.envs.camera.ground.patches import Patch, patch_of, sample
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.ground.surface import Polygons, Surface
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.ground_light import GroundLight, paint_efficiency
from vpf_sim.envs.camera.night.lamplight import Lamplight
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
        shadows: list[Floats] | None = None,
        lamplight: Lamplight | None = None,
    ) -> None:
        """`shadows` are the convex outlines (V, 2) m of the scenery's shadows, None without any.

        `lamplight` is the light of lamps in the dark, None by day.
        """
        look = RoadAppearance() if appearance is None else appearance
        self._top = ground_top(camera)
        self._levels = levels(camera)
        polygons = Polygons(painted(shapes, seed, look))
        self._patches = []
        for level, gain in zip(self._levels, even_gains(camera), strict=True):
            surface = Surface(polygons, level.near_m / detail(camera), _fineness(level))
            self._patches.append(
                patch_of(camera, level, partial(_painted, surface, Grain(level, seed), gain, look.grain))
            )
        self._lamps = None if lamplight is None else GroundLight(camera, lamplight)
        self._table = (
            ground_table(light, wetness, ramp(look))
            if lamplight is None
            else lamp_table(wetness, ramp(look), paint_efficiency(wetness, lamplight.share))
        )
        self._values = np.empty((camera.height_px - self._top, camera.width_px), np.uint8)
        faded = max((len(level.weights) for level in self._levels), default=0)
        self._over = np.empty((faded, camera.width_px), np.uint8)
        self._shadows = [] if shadows is None else shadow_patches(camera, self._levels, shadows, _fineness)
        self._shade = light.shadow

    def update(self, view: View) -> None:
        """Update the rasters for a view."""
        painted = False
        for patch in reversed(self._patches):
            painted |= patch.update(view, may_defer=painted)
        for patch in reversed(self._shadows):
            painted |= patch.update(view, may_defer=painted)

    @timed("render.ground")
    def draw(self, view: View, frame: Image) -> None:
        """Draw the ground into the frame."""
        if not self._levels:
            return
        self.update(view)
        self._sample(self._patches, view, GRASS)
        ground = frame[self._top :]
        cv2.applyColorMap(self._values, self._table, ground)
        if self._shadows:
            self._sample(self._shadows, view, LIT)
            darken(ground, self._values, self._shade)
        if self._lamps is not None:
            self._lamps.apply(ground, view)

    def _sample(self, patches: list[Patch], view: View, outside: int) -> None:
        """Sample all rows from the patches of the levels."""
        to_world = view.ground_homography()
        for level, patch in zip(self._levels, patches, strict=True):
            for band in level.bands:
                target = self._values[band.first : band.last]
                if not band.faded:
                    sample(patch, band, to_world, target, outside)
                    continue
                over = self._over[: len(target)]
                sample(patch, band, to_world, over, outside)
                first = band.first - level.bands[0].first
                _fade(target, over, level.weights[first : first + len(target)])


def _fineness(level: Level) -> tuple[int, int]:
    """Supersampling of a level's raster, across and along."""
    return NEAR_FINE if level.steep else FAR_FINE


def _fade(rows: Image, over: Image, weights: Image) -> None:
    """Blend `over` into `rows` in place; weight 255 is opaque."""
    under = cv2.multiply(rows, cv2.bitwise_not(weights), scale=1 / 255)
    cv2.add(under, cv2.multiply(over, weights, scale=1 / 255), rows)


def _painted(surface: Surface, grain: Grain, gain: Floats, strength: float, raster: Raster) -> Image:
    """(rows, columns) palette values of a raster, with their grain."""
    smooth = surface.paint(raster)
    shortest, longest = GRAINY_M
    shown = strength * np.clip((longest - raster.lengths()) / (longest - shortest), 0.0, 1.0).astype(np.float32)
    steps = np.subtract(grain.draw(raster), 128, dtype=np.float32)
    steps *= gain * shown
    cv2.multiply(steps, cv2.LUT(smooth, grain_strength()), steps)
    blotches = grain.blotches(raster)
    places = cv2.resize(smooth, blotches.shape[::-1], interpolation=cv2.INTER_NEAREST)
    contrast = cv2.LUT(places, blotch_strength()) * shown
    blotches = np.rint((blotches - np.float32(128.0)) * contrast + np.float32(128.0)).astype(np.uint8)
    smooth = np.asarray(cv2.addWeighted(smooth, 1.0, cv2.resize(blotches, smooth.shape[::-1]), 1.0, -128.0), np.uint8)
    return np.asarray(cv2.add(smooth, steps, dtype=cv2.CV_8U), np.uint8)
