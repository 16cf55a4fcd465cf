"""The light of lamps as content of the core, and the lamps of a frame that shine into the camera."""

import numpy as np
from highway_env.vehicle.objects import Obstacle

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.night import lamplight, low_beam
from vpf_sim.envs.camera.night.glow import GlowKind, Lamp, glow_picture, kind_of_glow
from vpf_sim.envs.camera.night.ground_light import ASPHALT, BRIGHTEST, COLUMN_PX, FARTHEST_M, ground_points
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.night.lamps import RANGE_M, street_lamps, vehicle_lamps
from vpf_sim.envs.camera.scenery.objects import kind_of, object_size
from vpf_sim.envs.camera.scenery.verge import TALL_RANGE_M
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.view import View
from vpf_sim.geometry import road_row_px
from vpf_sim.types import Camera, Floats

FACTORS, BRIGHTEST_LX = 1024, 3600.0  # of the table; brighter surfaces count as that bright


def set_lamps(core: Core, light: Lamplight) -> None:
    """Set the light of lamps."""
    beam = low_beam
    numbers = [lamplight.LAMP_AHEAD_M, lamplight.LAMP_ASIDE_M, lamplight.LAMP_HEIGHT_M, lamplight.NEAREST_M]
    numbers += [beam.PEAK_CD, beam.ABOVE_CD, beam.ABOVE_WIDE, beam.ABOVE_TALL, beam.DIP, beam.RISE, beam.HIGHEST]
    numbers += [beam.SOFT, beam.OFFSET, *beam.NARROW, *beam.WIDE, *beam.STEEP, *beam.SHALLOW]
    numbers += [lamplight.STREET_CD, lamplight.STREET_RANGE_M, lamplight.RETRO, lamplight.LEAVES, BRIGHTEST]
    scale = (FACTORS - 1) / np.sqrt(BRIGHTEST_LX)
    factors = light.factor((np.arange(FACTORS) / scale) ** 2)
    core.set_lamps(numbers, light.street_lamps_m, factors, scale, _ground(core.camera, light))


def _ground(camera: Camera, light: Lamplight) -> Floats:
    """(rows, columns, 3) ahead and right of the car's middle, and lx of the headlamps, of points of the ground."""
    columns = np.linspace(0.0, camera.width_px - 1.0, -(-camera.width_px // COLUMN_PX) + 1)
    farthest_px = road_row_px(camera, FARTHEST_M)
    rows = np.maximum(np.arange(ground_top(camera), camera.height_px, dtype=float), farthest_px)
    view = View.at(camera, np.zeros(2), 0.0)
    points = ground_points(view, columns, rows)
    return np.concatenate([points[..., :2], (ASPHALT * light.beam_lx(view, points))[..., None]], axis=2)


class FrameLamps:
    """The lamps of street and traffic, as a frame shows them."""

    def __init__(self, core: Core, light: Lamplight) -> None:
        self._core = core
        self._lamplight = light
        self._glows: dict[GlowKind, int] = {}  # numbers of the core's pictures

    def of(self, now: Snapshot) -> Floats:
        """(n, 10) the lamps that shine into the camera, for the core; parked vehicles have none."""
        light, view = self._lamplight.light, now.view
        lamps = street_lamps(view, self._lamplight.lamps_ahead(view, TALL_RANGE_M), light)
        owners = [-1] * len(lamps)
        for index, obj in enumerate(now.objects):
            if isinstance(obj, Obstacle) or np.abs(now.places[index, :2] - view.centre[:2]).max() > RANGE_M:
                continue
            found = vehicle_lamps(view, now.places[index], kind_of(obj), object_size(obj), light)
            lamps += found
            owners += [index] * len(found)
        glows = [self._number(lamp) for lamp in lamps]
        shown = [i for i, glow in enumerate(glows) if glow is not None]
        result = np.array([(*_numbers(lamps[i]), 0.0, 0.0) for i in shown]).reshape(-1, 10)
        result.view(np.int64)[:, 8:] = np.array([(glows[i], owners[i]) for i in shown], np.int64).reshape(-1, 2)
        return result

    def _number(self, lamp: Lamp) -> int | None:
        """The picture of a lamp, made on first use."""
        kind = kind_of_glow(lamp)
        if kind is not None and kind not in self._glows:
            self._glows[kind] = self._core.add_glow(glow_picture(*kind, self._core.camera.fx_px))
        return None if kind is None else self._glows[kind]


def _numbers(lamp: Lamp) -> tuple[float, ...]:
    return lamp.x_px, lamp.y_px, lamp.depth_m, lamp.flux, lamp.size_px, *lamp.colour
