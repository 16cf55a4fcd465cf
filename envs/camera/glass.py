"""The windscreen: film, droplets and wiper, drawn by the core (`core/glass/glass.h`)."""

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from vpf_sim.envs.camera.atmosphere import HEAVIEST_RAIN_MMPH
from vpf_sim.envs.camera.core import _core
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Bools, Camera, Image

FIRST_SPEED_MPS = 5.5  # assumed at the first frame, which has none before it
TICK_S = 0.05  # period of the water simulation
MEMORY_US = 20_000_000  # drops dry or run off within 12 s
DROP = np.dtype(
    [
        *((name, "f8") for name in ("x_px", "y_px", "size_mm", "run_mps")),
        *((name, "i8") for name in ("dies_tick", "moved_tick")),
        ("outline", "i4"),
    ],
    align=True,
)


@dataclass(frozen=True, slots=True)
class Drop:
    """A drop on the windscreen."""

    x_px: float
    y_px: float
    size_mm: float  # diameter of a sphere of equal volume
    dies_s: float = 1e9
    outline: int = 0  # one of 4 shapes of larger drops


class Glass:
    """Water on the windscreen, and the wiper.

    `Weather.droplets` is a precipitation like CARLA's. It is independent of the falling rain, so the effect of the
    glass can be measured alone.
    """

    def __init__(self, camera: Camera, weather: Weather, light: Light, seed: int) -> None:
        self._size = (camera.height_px, camera.width_px)
        period_s = weather.wiper_period_s
        self._is_clear = weather.droplets <= 0.0 and period_s <= 0.0
        rain_mmph = HEAVIEST_RAIN_MMPH * (weather.droplets / 100.0) ** 2
        lens = (camera.width_px, camera.height_px, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px)
        offset_s = float(stream(seed, "wiper").uniform(0.0, period_s)) if period_s > 0.0 else 0.0
        sky = tuple(np.rint(light.horizon).astype(int).tolist())
        own_seed = int(stream(seed, "droplets").integers(0, 2**63))
        self._made_of = (lens, rain_mmph, period_s, offset_s, sky, own_seed)
        self._glass = _core.glass_new(*self._made_of)
        self._moments: deque[tuple[int, float]] = deque()  # times and speeds that the water depends on

    def __getstate__(self) -> dict[str, Any]:
        """All but the water itself, which the last moments bring about again."""
        return {name: value for name, value in self.__dict__.items() if name != "_glass"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Let the water run through the last moments."""
        self.__dict__.update(state)
        self._moments = deque(self._moments)
        self._glass = _core.glass_new(*self._made_of)
        for time_us, speed_mps in self._moments:
            _core.glass_advance(self._glass, time_us, speed_mps)

    @timed("render.glass")
    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the water and the blade over the frame, in place."""
        if not self._is_clear:
            self.skip(now, before)
            _core.glass_draw(self._glass, frame)

    def skip(self, now: Snapshot, before: Snapshot) -> None:
        """Go to this moment."""
        if self._is_clear:
            return
        gap_s = now.time_s - before.time_s
        way_m = np.subtract(now.view.centre, before.view.centre)
        speed_mps = float(np.sqrt((way_m**2).sum())) / gap_s if gap_s > 0.0 else FIRST_SPEED_MPS
        moment = (_microseconds(now.time_s), speed_mps)
        self._moments.append(moment)
        while self._moments[0][0] < moment[0] - MEMORY_US:
            self._moments.popleft()
        _core.glass_advance(self._glass, *moment)

    def hidden(self) -> Bools:
        """(H, W) where water or the blade hides more than half of the scene."""
        hidden = np.zeros(self._size, np.uint8)
        _core.glass_hidden(self._glass, hidden)
        return hidden.view(bool)

    def opacity(self) -> Image:
        """(H, W) opacity of the drops, 0..255."""
        opacity = np.zeros(self._size, np.uint8)
        _core.glass_opacity(self._glass, opacity)
        return opacity

    def drops(self) -> list[Drop]:
        """The drops of this moment."""
        found = np.zeros(_core.glass_drops(self._glass, np.zeros(0, DROP)), DROP)
        _core.glass_drops(self._glass, found)
        return [
            Drop(
                float(one["x_px"]),
                float(one["y_px"]),
                float(one["size_mm"]),
                int(one["dies_tick"]) * TICK_S,
                int(one["outline"]),
            )
            for one in found
        ]

    def put(self, drop: Drop) -> None:
        """Add a drop at this moment."""
        dies = round(drop.dies_s / TICK_S)
        _core.glass_put(self._glass, drop.x_px, drop.y_px, drop.size_mm, dies, drop.outline)

    def blade_rad(self, time_s: float) -> float:
        """Angle of the blade: 0 lying, pi / 2 standing."""
        return float(_core.glass_blade_rad(self._glass, _microseconds(time_s)))


def _microseconds(time_s: float) -> int:
    return round(1e6 * time_s)
