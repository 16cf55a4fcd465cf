"""Falling rain: every visible drop as a speck or a streak, drawn by the core (`core/rain/streaks.h`)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core import _core
from vpf_sim.envs.camera.light import GAMMA, Light
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

EXPOSURE_S, LONGEST_EXPOSURE_S = 0.002, 0.008  # with the sun at 45 deg, and the longest
DARKEST, GROUND = 30.0, 75.0  # grey levels: darkest background, mean of the lit ground
LIT_BY_LAMPS = 130.0  # grey levels: a drop that the car's headlamps light from near by


@dataclass(frozen=True, slots=True)
class Specks:
    """Projected drops, (n,) each."""

    x_px: Floats  # centre
    y_px: Floats
    dx_px: Floats  # motion during the exposure
    dy_px: Floats
    width_px: Floats
    level: Floats  # grey levels above the background

    @property
    def length_px(self) -> Floats:
        return np.hypot(self.dx_px, self.dy_px)

    def part(self, index: NDArray[np.bool_] | NDArray[np.int64]) -> "Specks":
        """The drops at an index or mask."""
        x, y, dx, dy = self.x_px[index], self.y_px[index], self.dx_px[index], self.dy_px[index]
        return Specks(x, y, dx, dy, self.width_px[index], self.level[index])


class Streaks:
    """Streaks of falling drops, drawn anew for each moment.

    Between frames a drop moves farther than its streak is long. A drop of diameter D at depth z is w = f D / z wide and
    moves by l = f T |v| / z pixels in the exposure T. Its opacity is (pi / 4) w^2 / max(1, l). Its brightness is 0.94
    of the mean of sky and ground (Garg and Nayar 2007, doi 10.1007/s11263-006-0028-6), so drops are invisible before
    the sky. A `gain` of 1 is physical; a larger one brightens the visible drops.
    """

    def __init__(
        self,
        camera: Camera,
        atmosphere: Atmosphere,
        light: Light,
        gain: float,
        seed: int,
        exposure_s: float | None = None,
    ) -> None:
        self._wind_mps = (*atmosphere.wind_mps.tolist(), 0.0)
        self.brightness = brightness(light)
        self._is_dry = atmosphere.rain_mmph <= 0.0 or gain <= 0.0 or self.brightness <= DARKEST
        if self._is_dry:
            return
        lens = (camera.width_px, camera.height_px, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px)
        exposure_s = exposure_s_of(light) if exposure_s is None else exposure_s
        own_seed = int(stream(seed, "streaks").integers(0, 2**63))
        rain = atmosphere.rain_mmph, exposure_s, self.brightness, gain
        self._made_of = (lens, camera.pitch_rad, *rain, own_seed)
        self._streaks = _core.streaks_new(*self._made_of)

    def __getstate__(self) -> dict[str, Any]:
        """All but the core's part, which is made anew: it depends on nothing before."""
        return {name: value for name, value in self.__dict__.items() if name != "_streaks"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the core's part."""
        self.__dict__.update(state)
        if not self._is_dry:
            self._streaks = _core.streaks_new(*self._made_of)

    @timed("render.streaks")
    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the drops of this moment, in place."""
        if self._is_dry:
            return
        gap_s = now.time_s - before.time_s
        way_m = (now.view.centre - before.view.centre).tolist()
        velocity = (
            wind - (way / gap_s if gap_s > 0.0 else 0.0) for wind, way in zip(self._wind_mps, way_m, strict=True)
        )
        self.draw_drops(frame, tuple(velocity), now.time_s, now.view.yaw_rad)

    def draw_drops(
        self, frame: Image, velocity_mps: tuple[float, ...], time_s: float = 0.0, yaw_rad: float = 0.0
    ) -> None:
        """Draw the drops of air that moves at a velocity (3,) of the world's axes, relative to the camera."""
        if not self._is_dry:
            _core.streaks_draw(self._streaks, velocity_mps, yaw_rad, round(1e6 * time_s), frame)

    def specks(self, frame: Image, velocity_mps: tuple[float, ...], time_s: float = 0.0) -> Specks:
        """The drops that `draw_drops` draws, of a camera that looks along the world's X axis."""
        found, count = np.empty((0, 6)), 0
        while count >= len(found):
            found = np.empty((2 * count + 4096, 6))
            count = _core.streaks_list(self._streaks, velocity_mps, 0.0, round(1e6 * time_s), frame, found)
        return Specks(*found[:count].T)


def exposure_s_of(light: Light) -> float:
    """Exposure time by the sine of the sun's altitude, as under an overcast sky."""
    sine = max(float(light.sun[2]), 0.05)
    return float(np.clip(EXPOSURE_S * np.sqrt(0.5) / sine, EXPOSURE_S, LONGEST_EXPOSURE_S))


def brightness(light: Light) -> float:
    """Brightness of a drop, grey levels; sky and ground are averaged in linear light."""
    sky = 0.5 * float(np.mean(light.horizon + light.zenith))
    ground = GROUND * float(np.mean(light.ground))
    by_day = round(float(0.94 * (0.5 * (sky**GAMMA + ground**GAMMA)) ** (1.0 / GAMMA)), 3)
    return max(by_day, LIT_BY_LAMPS) if light.has_lamps else by_day
