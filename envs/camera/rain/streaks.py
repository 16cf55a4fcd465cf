"""Falling rain in the picture: every drop that stands out from what is behind it, as a speck or a streak."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import GAMMA, Light
from vpf_sim.envs.camera.rain.shower import CELLS, CLASS_MM, NEAREST_M, Shower, Singles, fall_speed_mps, shower
from vpf_sim.envs.camera.scenery.scene import Snapshot
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

EXPOSURE_S, LONGEST_EXPOSURE_S = 0.002, 0.008  # with the sun at 45 deg, and at most
FAINTEST, LEAST_CONTRAST = (
    4.0,
    12.0,
)  # grey levels of the drop as seen, and of its own brightness; fainter ones are left to the sensor's noise
DARKEST, GROUND = 30.0, 75.0  # of what drops are seen before, and mean of the ground in full light, grey levels
STEP_MPS = 1.0  # change of the rain's motion past the camera after which its drops are counted anew
SHOWERS = 32  # such counts that are kept
PIXEL = np.dtype("V3")


@dataclass(frozen=True, slots=True)
class Specks:
    """Drops as they are seen, (n,) each."""

    x_px: Singles  # the middle
    y_px: Singles
    dx_px: Singles  # how far it moves while the shutter is open
    dy_px: Singles
    width_px: Singles
    level: Singles  # grey levels above what is behind

    @property
    def length_px(self) -> Singles:
        return np.hypot(self.dx_px, self.dy_px)

    def part(self, index: NDArray[np.bool_] | NDArray[np.int64]) -> "Specks":
        """Some of them."""
        x, y, dx, dy = self.x_px[index], self.y_px[index], self.dx_px[index], self.dy_px[index]
        return Specks(x, y, dx, dy, self.width_px[index], self.level[index])


class Streaks:
    """Streaks of falling drops, drawn anew in every frame: in between a drop moves farther than its streak is long.

    A drop of diameter D at depth z is w = f D / z wide and moves by l = f T |v| / z pixels in the exposure T; it
    differs from what is behind it by (pi / 4) w^2 / max(1, l) of the difference between their brightnesses. A drop
    shows nearly all of the scene before it, so its brightness is 0.94 of the mean of sky and ground (Garg and Nayar
    2007, doi 10.1007/s11263-006-0028-6) and before the sky none is seen. A `gain` of 1 is physical; more brightens the
    drops that are seen, and shows no others.
    """

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light, gain: float, seed: int) -> None:
        self._camera, self._rain_mmph = camera, atmosphere.rain_mmph
        self._dimming, self._brightening = min(gain, 1.0), max(gain, 1.0)
        self._wind = np.array([*atmosphere.wind_mps, 0.0])
        self._rng = stream(seed, "streaks")
        self.exposure_s = exposure_s(light)
        self.brightness = brightness(light)
        self._none = atmosphere.rain_mmph <= 0.0 or gain <= 0.0 or self.brightness <= DARKEST
        self._showers: dict[tuple[int, ...], Shower] = {}

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the drops of this frame, in place; the camera's velocity is that between the two snapshots."""
        if not self._none:
            self.draw_passing(frame, *self._passing(now, before))

    def skip(self, now: Snapshot, before: Snapshot) -> None:
        """Let the drops of a frame fall that nobody looks at."""
        if not self._none:
            self._chances(self._shower(*self._passing(now, before)))

    def draw_passing(self, frame: Image, drift: Floats, down: Floats) -> None:
        """Draw drops that fall along `down` (3,) and pass the camera at `drift` (3,) m/s besides, in camera axes."""
        add(frame, self.specks(frame, drift, down), self._brightening)

    def specks(self, frame: Image, drift: Floats, down: Floats) -> Specks:
        """The next frame's drops, those that stand out by FAINTEST or more."""
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
        passed = scale * np.float32(self.exposure_s)
        dx = passed * (camera.fx_px * right - (x_px - camera.cx_px) * depth)
        dy = passed * (camera.fy_px * under - (y_px - camera.cy_px) * depth)
        width = (1e-3 * camera.fx_px) * diameter_mm * scale
        level = opacity(width, np.hypot(dx, dy)) * contrast
        return Specks(x_px, y_px, dx, dy, width, level).part(np.flatnonzero(level >= FAINTEST))

    def _passing(self, now: Snapshot, before: Snapshot) -> tuple[Floats, Floats]:
        """How the rain passes the camera besides falling, m/s, and whither it falls: (3,) each, in camera axes."""
        gap_s = now.time_s - before.time_s
        velocity = (now.view.centre - before.view.centre) / gap_s if gap_s > 0.0 else np.zeros(3)
        return now.view.axes @ (self._wind - velocity), -now.view.axes[:, 2]

    def _chances(self, shower: Shower) -> NDArray[np.uint16]:
        """(5, n) what the next frame's n drops are drawn by."""
        return self._rng.integers(0, 65536, (5, int(self._rng.poisson(shower.expected))), dtype=np.uint16)

    def _shower(self, drift: Floats, down: Floats) -> Shower:
        """The drops to choose from, for about this motion of the rain past the camera."""
        key = tuple(np.rint(drift / STEP_MPS).astype(int).tolist())
        if key not in self._showers:
            if len(self._showers) >= SHOWERS:
                self._showers.clear()
            faintest = FAINTEST / (self._dimming * (self.brightness - DARKEST))
            motion = (STEP_MPS * np.array(key, float), down)
            self._showers[key] = shower(self._camera, self._rain_mmph, motion, self.exposure_s, faintest)
        return self._showers[key]


def opacity(width_px: Singles, length_px: Singles) -> Singles:
    """How much of a pixel on its way a drop covers while the shutter is open."""
    return np.asarray(np.float32(0.25 * np.pi) * width_px**2 / np.maximum(length_px, np.float32(1.0)), np.float32)


def exposure_s(light: Light) -> float:
    """As under a covered sky, whose light on the ground goes with the sine of the sun's altitude."""
    sine = max(float(light.sun[2]), 0.05)
    return float(np.clip(EXPOSURE_S * np.sqrt(0.5) / sine, EXPOSURE_S, LONGEST_EXPOSURE_S))


def brightness(light: Light) -> float:
    """Of a drop, grey levels: the mean of sky and ground is that of their light, not of their grey levels."""
    sky = 0.5 * float(np.mean(light.horizon + light.zenith))
    ground = GROUND * float(np.mean(light.ground))
    return float(0.94 * (0.5 * (sky**GAMMA + ground**GAMMA)) ** (1.0 / GAMMA))


def add(frame: Image, specks: Specks, gain: float = 1.0) -> None:
    """Add drops to the picture, in place: points a pixel apart, each shared between the two columns beside it. The few
    that are wider than a pixel are drawn one pixel wide."""
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
    flat = frame.reshape(-1, 3).view(PIXEL)[:, 0]  # whole pixels are looked up and set in half the time
    for index, levels in ((pixels, (level - to_right)[inside]), (pixels + 1, to_right[inside])):
        added = np.minimum(levels + np.float32(0.5), np.float32(255.0)).astype(np.uint8)[:, None]
        behind = flat[index].view(np.uint8).reshape(-1, 3)
        flat[index] = (behind + np.minimum(255 - behind, added)).view(PIXEL)[:, 0]
