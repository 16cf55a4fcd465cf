"""Reflections on the wet road: sharp in puddles, smeared along the line of sight elsewhere."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.rain.lamp_streaks import lamp_streaks
from vpf_sim.envs.camera.rain.mirror import (
    REFINEMENT,
    erase,
    large_sprites,
    mirrored_faces,
    paint_faces,
    paint_sprite,
)
from vpf_sim.envs.camera.rain.puddles import HeightMap, Puddles
from vpf_sim.envs.camera.rain.wetness import Wetness
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Bools, Camera, Image

Bytes = NDArray[np.uint8]

DARK = 0.3  # darkening of the asphalt with water depth, of 255 per depth level
EVERY = 3  # frames between updates of the reflection in rain, when drops distort it more than motion
HIDDEN_SHARE, HIDDEN_LEVELS = 0.25 * 255, 12


@dataclass(frozen=True, slots=True)
class Water:
    """Water in one frame, (rows, columns) of the canvas each."""

    share: Bytes  # reflected share of light, of 255
    through: Bytes  # remaining share of the road's light, of 255
    standing: Bytes  # 255 in puddles, else 0


@dataclass(frozen=True, slots=True)
class Mirror:
    """The reflected scene of one frame."""

    view: View
    drawn: list[Drawn]
    sky: Bytes  # (rows, columns, 3)
    sharp: Bytes  # with items, as in puddles
    smeared: Bytes  # blurred, as on the film


class WetRoad:
    """Reflects the sky and items on the road.

    Only the visible sky is reflected, so without sky in the image the road is dull.
    """

    def __init__(self, camera: Camera, shapes: list[LaneShape], atmosphere: Atmosphere, seed: int) -> None:
        self._size = (camera.height_px, camera.width_px)
        self._last: tuple[Mirror, Water, list[Drawn]] | None = None
        self._top = ground_top(camera)
        wetness = Wetness.of(camera, atmosphere)
        self._is_dry = wetness is None
        if wetness is None:
            return
        self._camera = camera
        self._rows, self._columns = wetness.reflectance.shape
        self._puddles = Puddles(shapes, seed)
        self._smear, self._level, self._ripple = wetness.smear, wetness.level, wetness.ripple
        self._share_table, self._reflectance = wetness.share, wetness.reflectance
        self._rng = stream(seed, "rain on puddles")
        self._from_row = np.arange(self._rows)
        centre = 0.5 * (REFINEMENT - 1)
        self._to_pixels = np.array([[REFINEMENT, 0.0, centre], [0.0, REFINEMENT, centre + self._top], [0.0, 0.0, 1.0]])
        self._age = 0  # of the reflection, in frames
        size = (self._rows * REFINEMENT, camera.width_px)
        self._dimming, self._added = np.empty((*size, 3), np.uint8), np.empty((*size, 3), np.uint8)
        self._left = np.empty(size, np.uint8)

    @timed("render.wet_road")
    def draw(self, frame: Image, view: View, drawn: list[Drawn]) -> None:
        """Draw the reflections of the sky and of `drawn`, in place."""
        if self._is_dry:
            return
        if self._last is None or not self._ripple or self.is_due:
            mirror = self._mirror(view, self._mirrored_sky(frame), drawn)
            self._age = 0
        else:
            mirror = self._last[0]
        self._age += 1
        self._draw_ripple()
        water = self._water(view)
        self._last = (mirror, water, drawn)
        light = self._light(mirror, water)
        streaks = lamp_streaks(self._camera, drawn, water.share, self._top, 0.4 * self._smear)
        self._blend(frame, water.through, light if streaks is None else np.asarray(cv2.add(light, streaks), np.uint8))

    @property
    def is_due(self) -> bool:
        """Whether the next frames reuse this frame's reflection."""
        return not self._is_dry and self._ripple > 0 and (self._last is None or self._age == EVERY)

    def skip(self, view: View) -> None:
        """Skip a frame that is not due."""
        if self._is_dry:
            return
        self._age += 1
        self._draw_ripple()
        self._height_map(view)

    def hidden(self) -> Bools:
        """(H, W) where the last frame shows reflections of items.

        They make up a quarter of the light, or differ by 12 grey levels from the reflected sky.
        """
        mask = np.zeros(self._size, np.uint8)
        if self._last is None:
            return mask.astype(bool)
        mirror, water, drawn = self._last
        white, black = np.full_like(mirror.sky, 255), np.zeros_like(mirror.sky)
        of_sky, of_nothing, with_things, without, all_sky = (
            self._light(self._mirror(mirror.view, sky, items), water)
            for sky, items in (
                (white, mirror.drawn),
                (black, mirror.drawn),
                (mirror.sky, mirror.drawn),
                (mirror.sky, []),
                (white, []),
            )
        )
        share = cv2.subtract(all_sky, cv2.subtract(of_sky, of_nothing))
        contrast = cv2.absdiff(with_things, without)
        shown = (np.asarray(share).max(axis=2) > HIDDEN_SHARE) | (np.asarray(contrast).max(axis=2) > HIDDEN_LEVELS)
        below = mask[self._top : self._top + self._rows * REFINEMENT]
        below[:] = shown.repeat(REFINEMENT, axis=0).repeat(REFINEMENT, axis=1)[: len(below)]
        for item in drawn:
            erase(mask, item.drawing)
        return mask.astype(bool)

    def _height_map(self, view: View) -> HeightMap:
        x, y, _ = view.centre.tolist()
        return self._puddles.height_map(x, y, view.yaw_rad)

    def _draw_ripple(self) -> None:
        """Draw the random row offsets of one frame's reflections in puddles."""
        if self._ripple:
            self._from_row = self._rng.integers(-self._ripple, self._ripple + 1, self._rows) + np.arange(self._rows)

    def _water(self, view: View) -> Water:
        """The water in a view."""
        depths = self._depths(view)
        dark: Any = cv2.addWeighted(depths, DARK, depths, 0.0, -DARK * self._level)
        share: Any = cv2.multiply(cv2.LUT(depths, self._share_table), self._reflectance, scale=1 / 255)
        through: Any = cv2.subtract(cv2.bitwise_not(share), dark)
        standing: Any = cv2.threshold(depths, self._level, 255.0, cv2.THRESH_BINARY)[1]
        return Water(share, through, standing)

    def _mirror(self, view: View, sky: Bytes, drawn: list[Drawn]) -> Mirror:
        """The reflected scene: items before the reflected sky."""
        sharp = sky.copy()
        for sprite in large_sprites(drawn):
            paint_sprite(sharp, view, self._top, sprite)
        paint_faces(sharp, self._top, mirrored_faces(view, drawn, 0.5 * self._smear * REFINEMENT))
        return Mirror(view, drawn, sky, sharp, np.asarray(cv2.blur(sharp, (1, self._smear)), np.uint8))

    def _light(self, mirror: Mirror, water: Water) -> Bytes:
        """(rows, columns, 3) the reflected light."""
        sharp, light = mirror.sharp, mirror.smeared.copy()
        if self._ripple:
            sharp = sharp.take(self._from_row, axis=0, mode="clip")
        cv2.copyTo(sharp, water.standing, light)
        cv2.multiply(light, cv2.cvtColor(water.share, cv2.COLOR_GRAY2RGB), light, scale=1 / 255)
        return light

    def _blend(self, frame: Image, through: Bytes, light: Bytes) -> None:
        """Dim the road and add the reflected light."""
        rows = frame[self._top : self._top + self._rows * REFINEMENT]
        size = (frame.shape[1], self._rows * REFINEMENT)
        cv2.resize(through, size, self._left)
        cv2.cvtColor(self._left, cv2.COLOR_GRAY2RGB, self._dimming)
        cv2.multiply(rows, self._dimming[: len(rows)], rows, scale=1 / 255)
        cv2.resize(light, size, self._added)
        cv2.add(rows, self._added[: len(rows)], rows)

    def _mirrored_sky(self, frame: Image) -> Bytes:
        """The reflected sky."""
        tall = min(self._rows, self._top // REFINEMENT)
        above = frame[self._top - tall * REFINEMENT : self._top]
        sky = cv2.flip(cv2.resize(above, (self._columns, tall), interpolation=cv2.INTER_AREA), 0)
        if tall < self._rows:
            sky = cv2.copyMakeBorder(sky, 0, self._rows - tall, 0, 0, cv2.BORDER_REPLICATE)
        return np.asarray(sky, np.uint8)

    def _depths(self, view: View) -> Bytes:
        """(rows, columns) puddle depth at each pixel of the canvas."""
        height_map = self._height_map(view)
        matrix = height_map.from_world() @ view.ground_homography() @ self._to_pixels
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self._columns, self._rows)
        return np.asarray(cv2.warpPerspective(height_map.depths, matrix, size, flags=flags), np.uint8)
