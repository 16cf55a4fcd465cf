"""Water on the windshield, and the wiper that takes it away."""

from math import ceil

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import HEAVIEST_RAIN_MMPH, Atmosphere
from vpf_sim.envs.camera.droplets import Droplets
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.pane import Pane
from vpf_sim.envs.camera.planes import Planes
from vpf_sim.envs.camera.refraction import Refraction
from vpf_sim.envs.camera.things import Snapshot
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.envs.camera.wipers import Wiper, paint_blade
from vpf_sim.types import Bools, Camera, Image

FILM = 0.05  # share of the light that the film between drops blurs
WARM_UP_S, WARM_UP_MPS = 8.0, 5.5  # drive in the rain before the first frame
LONGEST_STEP_S = 0.1


class Glass:
    """Film, droplets and wiper.

    `Weather.droplets` is a precipitation like CARLA's: as many drops land as that much rain brings. They are there
    whether rain is drawn in the air or not, so that what the glass alone does can be told.
    """

    def __init__(self, camera: Camera, weather: Weather, atmosphere: Atmosphere, light: Light, seed: int) -> None:
        del atmosphere
        self._size = (camera.width_px, camera.height_px)
        self._time_s: float | None = None
        self._speed_mps = WARM_UP_MPS
        pane = Pane.of(camera)
        self._wiper = Wiper(pane, weather.wiper_period_s, seed) if weather.wiper_period_s > 0.0 else None
        self._droplets: Droplets | None = None
        if weather.droplets > 0.0:
            rain = HEAVIEST_RAIN_MMPH * (weather.droplets / 100.0) ** 2
            planes = Planes(camera)
            self._droplets = Droplets(pane, planes, rain, seed)
            self._film: Image = np.full(planes.shape, round(255 * FILM), np.uint8)
            self._refraction = Refraction(camera, planes, light)

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Put the water of this moment before the picture, in place."""
        gap_s = now.time_s - before.time_s
        if gap_s > 0.0:
            self._speed_mps = float(np.linalg.norm(now.view.centre - before.view.centre)) / gap_s
        if self._droplets is not None:
            self._advance(self._droplets, now.time_s)
            self._refraction.apply(frame, np.maximum(self._droplets.planes.alpha, self._film))
        self._time_s = now.time_s
        blade = self._blade()
        if blade is not None:
            paint_blade(frame, blade)

    def hidden(self) -> Bools:
        """(H, W) where water or the blade hides more than half of what is behind."""
        hidden = np.zeros(self._size[::-1], bool)
        if self._droplets is not None:
            hidden |= np.asarray(cv2.resize(self._droplets.planes.alpha, self._size)) > 127
        blade = self._blade()
        if blade is not None:
            hidden |= np.asarray(cv2.resize(blade, self._size)) > 127
        return hidden

    def _blade(self) -> Image | None:
        return None if self._wiper is None or self._time_s is None else self._wiper.blade(self._time_s)

    def _advance(self, droplets: Droplets, time_s: float) -> None:
        """Bring water and wiper to a time; nothing happens when they are there already."""
        since_s = time_s - WARM_UP_S if self._time_s is None else self._time_s
        steps = max(ceil((time_s - since_s) / LONGEST_STEP_S - 1e-9), 0)
        for moment in np.linspace(since_s, time_s, steps + 1)[1:].tolist():
            droplets.advance(moment, moment - since_s, self._speed_mps)
            if self._wiper is not None:
                swath = self._wiper.swath(since_s, moment)
                droplets.wipe(swath.mask(), swath.holds)
            since_s = moment
