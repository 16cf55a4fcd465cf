"""The windscreen: film, droplets and wiper."""

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import HEAVIEST_RAIN_MMPH
from vpf_sim.envs.camera.glass.droplets import Droplets
from vpf_sim.envs.camera.glass.film import Film
from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.planes import ROWS, Planes
from vpf_sim.envs.camera.glass.refraction import Refraction
from vpf_sim.envs.camera.glass.wipers import Wiper, paint_blade
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.scene import Snapshot
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.timing import timed
from vpf_sim.types import Bools, Camera, Image

TICK_S = 0.05  # period of the water simulation and of the refracted image
WARM_UP_TICKS, WARM_UP_STRIDE, WARM_UP_MPS = 160, 2, 5.5  # rain before the first frame, in coarser steps


class Glass:
    """Water on the windscreen, and the wiper.

    `Weather.droplets` is a precipitation like CARLA's. It is independent of the falling rain, so the effect of the
    glass can be measured alone.
    """

    def __init__(self, camera: Camera, weather: Weather, light: Light, seed: int) -> None:
        self._size = (camera.width_px, camera.height_px)
        self._time_s: float | None = None
        self._tick = 0
        self._changed = False  # whether the water changed since it was last refracted
        self._speed_mps = WARM_UP_MPS
        pane = Pane.of(camera)
        self.wiper = Wiper(pane, weather.wiper_period_s, seed) if weather.wiper_period_s > 0.0 else None
        self.droplets: Droplets | None = None
        if weather.droplets > 0.0:
            rain = HEAVIEST_RAIN_MMPH * (weather.droplets / 100.0) ** 2
            planes = Planes(camera)
            self.droplets = Droplets(pane, planes, rain, seed)
            self._film = Film(planes.shape, self.wiper, TICK_S, seed)
            self._refraction = Refraction(planes, light)

    @timed("render.glass")
    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the water and the blade over the frame, in place."""
        due = self.is_due(now.time_s)
        self.skip(now, before)
        if self.droplets is not None:
            if due:
                self._refraction.capture(frame)
            if self._changed:
                cover = np.asarray(cv2.max(self.droplets.planes.alpha, self._film.cover), np.uint8)
                self._refraction.refract(cover)
                self._changed = False
            self._refraction.apply(frame)
        blade = self._blade()
        if blade is not None:
            paint_blade(frame, blade)

    def is_due(self, time_s: float) -> bool:
        """Whether the next frames' water refracts the image of this moment."""
        return self.droplets is not None and (self._time_s is None or _tick_at(time_s) > self._tick)

    def skip(self, now: Snapshot, before: Snapshot) -> None:
        """Advance water and wiper to this moment."""
        gap_s = now.time_s - before.time_s
        if gap_s > 0.0:
            self._speed_mps = float(np.linalg.norm(now.view.centre - before.view.centre)) / gap_s
        if self.droplets is not None:
            self._changed |= self._advance(self.droplets, now.time_s)
        self._time_s = now.time_s

    def hidden(self) -> Bools:
        """(H, W) where water or the blade hides more than half of the scene."""
        hidden = np.zeros(self._size[::-1], bool)
        if self.droplets is not None:
            hidden |= np.repeat(self.droplets.planes.alpha > 127, ROWS, axis=0)[: len(hidden)]
        blade = self._blade()
        if blade is not None:
            hidden |= np.asarray(cv2.resize(blade, self._size)) > 127
        return hidden

    def _blade(self) -> Image | None:
        return None if self.wiper is None or self._time_s is None else self.wiper.blade(self._time_s)

    def _advance(self, droplets: Droplets, time_s: float) -> bool:
        """Advance water and wiper to a time; returns whether anything changed."""
        now = _tick_at(time_s)
        if self._time_s is None:
            with droplets.suspended():
                self._tick_through(droplets, range(now - WARM_UP_TICKS, now + 1, WARM_UP_STRIDE))
            self._wipe(droplets, now * TICK_S, time_s)
            return True
        before = self._tick
        if now > before:
            self._tick_through(droplets, range(max(before, now - WARM_UP_TICKS), now + 1))
        return self._wipe(droplets, self._time_s, time_s) or now > before

    def _tick_through(self, droplets: Droplets, ticks: range) -> None:
        """Simulate the water from the first to the last tick."""
        gap_s = ticks.step * TICK_S
        for tick in ticks[1:]:
            until_s = tick * TICK_S
            droplets.advance(until_s, gap_s, self._speed_mps)
            self._film.advance(until_s)
            self._wipe(droplets, until_s - gap_s, until_s)
        self._tick = ticks[-1]

    def _wipe(self, droplets: Droplets, from_s: float, until_s: float) -> bool:
        """Wipe over a span of time; returns whether the blade was in the image."""
        swath = None if self.wiper is None or until_s <= from_s else self.wiper.swath(from_s, until_s)
        if swath is None:
            return False
        droplets.wipe(swath)
        self._film.wipe(swath, until_s)
        return True


def _tick_at(time_s: float) -> int:
    """The last tick up to a time."""
    return int(time_s / TICK_S + 1e-6)
