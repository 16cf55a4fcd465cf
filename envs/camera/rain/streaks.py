"""Falling rain: every visible drop as a speck or a streak."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import GAMMA, Light
from vpf_sim.envs.camera.rain.shower import CELLS, CLASS_MM, NEAREST_M, Shower, Singles, fall_speed_mps, shower
from vpf_sim.envs.camera.scenery.scene import Snapshot
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

EXPOSURE_S, LONGEST_EXPOSURE_S = 0.002, 0.008  # with the sun at 45 deg, and the longest
# Least level of a drop in the image and least contrast of its brightness, grey levels; fainter drops are sensor noise.
FAINTEST, LEAST_CONTRAST = 4.0, 12.0
DARKEST, GROUND = 30.0, 75.0  # grey levels: darkest background, mean of the lit ground
LIT_BY_LAMPS = 130.0  # grey levels: a drop that the car's headlamps light from near by
STEP_MPS = 1.0  # resolution of the relative motion of cached showers
SHOWERS = 32  # cached showers
PIXEL = np.dtype("V3")


@dataclass(frozen=True, slots=True)
class Specks:
    """Projected drops, (n,) each."""

    x_px: Singles  # centre
    y_px: Singles
    dx_px: Singles  # motion during the exposure
    dy_px: Singles
    width_px: Singles
    level: Singles  # grey levels above the background

    @property
    def length_px(self) -> Singles:
        return np.hypot(self.dx_px, self.dy_px)

    def part(self, index: NDArray[np.bool_] | NDArray[np.int64]) -> "Specks":
        """The drops at an index or mask."""
        x, y, dx, dy = self.x_px[index], self.y_px[index], self.dx_px[index], self.dy_px[index]
        return Specks(x, y, dx, dy, self.width_px[index], self.level[index])


class Streaks:
    """Streaks of falling drops, drawn independently in every frame.

    Between frames a drop moves farther than its streak is long. A drop of diameter D at depth z is w = f D / z wide and
    moves by l = f T |v| / z pixels in the exposure T. Its opacity is (pi / 4) w^2 / max(1, l). Its brightness is 0.94
    of the mean of sky and ground (Garg and Nayar 2007, doi 10.1007/s11263-006-0028-6), so drops are invisible before
    the sky. A `gain` of 1 is physical; a larger one brightens the visible drops.
    """

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light, gain: float, seed: int) -> None:
        self._camera, self._rain_mmph = camera, atmosphere.rain_mmph
        self._dimming, self._brightening = min(gain, 1.0), max(gain, 1.0)
        self._wind = np.array([*atmosphere.wind_mps, 0.0])
        self._rng = stream(seed, "streaks")
        self.exposure_s = exposure_s(light)
        self.brightness = brightness(light)
        self._is_dry = atmosphere.rain_mmph <= 0.0 or gain <= 0.0 or self.brightness <= DARKEST
        self._showers: dict[tuple[int, ...], Shower] = {}

    @timed("render.streaks")
    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the drops of this frame, in place."""
        if not self._is_dry:
            self.draw_drops(frame, *self._relative_motion(now, before))

    def skip(self, now: Snapshot, before: Snapshot) -> None:
        """Skip the drops of a frame."""
        if not self._is_dry:
            self._chances(self._shower(*self._relative_motion(now, before)))

    def draw_drops(self, frame: Image, drift: Floats, down: Floats) -> None:
        """Draw drops that fall along `down` (3,) and drift at `drift` (3,) m/s, in camera axes."""
        add(frame, self.specks(frame, drift, down), self._brightening)

    def specks(self, frame: Image, drift: Floats, down: Floats) -> Specks:
        """The next frame's drops with a level of at least FAINTEST."""
        camera, shower = self._camera, self._shower(drift, down)
        drawn = self._chances(shower)
        chance = drawn[1:] * np.float32(1.0 / 65536.0)
        stratum = shower.strata[drawn[0]]
        x_px = shower.corners_px[0][stratum] + chance[0] * (camera.width_px / CELLS[0])
        y_px = shower.corners_px[1][stratum] + chance[1] * (camera.height_px / CELLS[1])
        contrast = np.float32(self._dimming) * (
            np.float32(self.brightness) - frame[y_px.astype(int), x_px.astype(int), 1]
        )
        dark = np.flatnonzero(contrast > LEAST_CONTRAST)
        x_px, y_px, contrast, stratum, chance = x_px[dark], y_px[dark], contrast[dark], stratum[dark], chance[2:, dark]
        diameter_mm = shower.diameter_mm[stratum] + chance[0] * CLASS_MM
        cube = np.float32(NEAREST_M**3)
        scale = 1.0 / np.cbrt(cube + chance[1] * (shower.farthest_m3[stratum] - cube))
        fall = fall_speed_mps(diameter_mm)
        right, under, depth = (np.float32(a) + np.float32(b) * fall for a, b in zip(drift, down, strict=True))
        travel = scale * np.float32(self.exposure_s)
        dx = travel * (camera.fx_px * right - (x_px - camera.cx_px) * depth)
        dy = travel * (camera.fy_px * under - (y_px - camera.cy_px) * depth)
        width = (1e-3 * camera.fx_px) * diameter_mm * scale
        level = opacity(width, np.hypot(dx, dy)) * contrast
        return Specks(x_px, y_px, dx, dy, width, level).part(np.flatnonzero(level >= FAINTEST))

    def _relative_motion(self, now: Snapshot, before: Snapshot) -> tuple[Floats, Floats]:
        """Drift of the rain relative to the camera, m/s, and direction of fall: (3,) each, camera axes."""
        gap_s = now.time_s - before.time_s
        velocity = (now.view.centre - before.view.centre) / gap_s if gap_s > 0.0 else np.zeros(3)
        return now.view.axes @ (self._wind - velocity), -now.view.axes[:, 2]

    def _chances(self, shower: Shower) -> NDArray[np.uint16]:
        """(5, n) random numbers of the next frame's n drops."""
        return self._rng.integers(0, 65536, (5, int(self._rng.poisson(shower.expected))), dtype=np.uint16)

    def _shower(self, drift: Floats, down: Floats) -> Shower:
        """The shower for a relative motion, cached by its rounded drift."""
        key = tuple(np.rint(drift / STEP_MPS).astype(int).tolist())
        if key not in self._showers:
            if len(self._showers) >= SHOWERS:
                self._showers.clear()
            faintest = FAINTEST / (self._dimming * (self.brightness - DARKEST))
            motion = (STEP_MPS * np.array(key, float), down)
            self._showers[key] = shower(self._camera, self._rain_mmph, motion, self.exposure_s, faintest)
        return self._showers[key]


def opacity(width_px: Singles, length_px: Singles) -> Singles:
    """Mean opacity of a drop along its path during the exposure."""
    return np.asarray(np.float32(0.25 * np.pi) * width_px**2 / np.maximum(length_px, np.float32(1.0)), np.float32)


def exposure_s(light: Light) -> float:
    """Exposure time by the sine of the sun's altitude, as under an overcast sky."""
    sine = max(float(light.sun[2]), 0.05)
    return float(np.clip(EXPOSURE_S * np.sqrt(0.5) / sine, EXPOSURE_S, LONGEST_EXPOSURE_S))


def brightness(light: Light) -> float:
    """Brightness of a drop, grey levels; sky and ground are averaged in linear light."""
    sky = 0.5 * float(np.mean(light.horizon + light.zenith))
    ground = GROUND * float(np.mean(light.ground))
    by_day = float(0.94 * (0.5 * (sky**GAMMA + ground**GAMMA)) ** (1.0 / GAMMA))
    return max(by_day, LIT_BY_LAMPS) if light.has_lamps else by_day


def add(frame: Image, specks: Specks, gain: float = 1.0) -> None:
    """Add drops to the frame, in place: points a pixel apart, each split between two columns.

    The few drops wider than a pixel are drawn one pixel wide.
    """
    height, width = frame.shape[:2]
    counts = np.maximum(np.abs(specks.dx_px), np.abs(specks.dy_px)).astype(np.intp) + 2
    ends = np.cumsum(counts)
    along = np.arange(ends[-1] if len(ends) else 0, dtype=np.float32) - np.repeat(ends - counts, counts)
    along = along / np.repeat(counts - 1, counts).astype(np.float32) - np.float32(0.5)
    x = np.repeat(specks.x_px, counts) + along * np.repeat(specks.dx_px, counts)
    y = np.rint(np.repeat(specks.y_px, counts) + along * np.repeat(specks.dy_px, counts)).astype(np.intp)
    left = np.floor(x).astype(np.intp)
    inside = (left >= 0) & (left < width - 1) & (y >= 0) & (y < height)
    level = np.repeat(gain * specks.level / np.maximum(specks.width_px, np.float32(1.0)), counts)
    to_right = level * (x - left)
    pixels = (y * width + left)[inside]
    flat = frame.reshape(-1, 3).view(PIXEL)[:, 0]  # access by whole pixels takes half the time
    for index, levels in ((pixels, (level - to_right)[inside]), (pixels + 1, to_right[inside])):
        added = np.minimum(levels + np.float32(0.5), np.float32(255.0)).astype(np.uint8)[:, None]
        behind = flat[index].view(np.uint8).reshape(-1, 3)
        flat[index] = (behind + np.minimum(255 - behind, added)).view(PIXEL)[:, 0]
