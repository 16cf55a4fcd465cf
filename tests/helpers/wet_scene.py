"""A core with a wet road and one object, over plain frames."""

import numpy as np
from highway_scenes import WIDTH_M, straight_road

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.rain.content import wet_surface
from vpf_sim.envs.camera.scenery.content import set_light
from vpf_sim.geometry import horizon_px
from vpf_sim.types import Bools, Camera, Image

EGO = (20.0, 1.5 * WIDTH_M)
SKY, ROAD = 200, 40
WALL_M = (2.0, 1.5)  # width, height


class WetScene:
    """A wet road; with `wall_m` an upright wall stands across it so far ahead of the camera, and looks at it."""

    def __init__(self, camera: Camera, name: str, wall_m: float | None = None, seed: int = 1) -> None:
        chosen = weather.load(name)
        light, atmosphere = Light.of(chosen), Atmosphere.of(chosen)
        self.camera = camera
        self.core = Core(camera, ground_top(camera))
        set_light(self.core, light, Haze(camera, atmosphere, light))
        self._wet = wet_surface(self.core, lane_shapes(straight_road()), light, atmosphere, seed)
        self._objects = np.empty((0, 4))
        if wall_m is not None:
            self._objects = np.array([[EGO[0] + camera.forward_m + wall_m, EGO[1], 0.0, 0.0]])
            self._objects.view(np.int64)[0, 3] = _wall(self.core)

    def draw(self, time_s: float = 0.0, speed_mps: float | None = None) -> Image:
        """The reflections over a frame of even sky and even road; with a speed spray as well, and the wall itself."""
        camera = self.camera
        frame = np.full((camera.height_px, camera.width_px, 3), SKY, np.uint8)
        frame[int(np.floor(horizon_px(camera))) + 1 :] = ROAD
        self.core.begin(*EGO, 0.0, time_s, self._objects)
        if self._wet is not None:
            self._wet.update(*EGO, 0.0)
            if speed_mps is not None:
                self.core.begin_spray(np.full(len(self._objects), speed_mps))
            self.core.draw_wet_road(frame)
        if speed_mps is not None:
            self.core.draw_scene(frame)
        return frame

    def hidden(self) -> Bools:
        return self.core.hidden_by_rain()


def _wall(core: Core) -> int:
    wide, tall = WALL_M
    corners = np.array([[[0.0, side, up] for side, up in ((-1.0, 0.0), (-1.0, 1.0), (1.0, 1.0), (1.0, 0.0))]])
    corners *= [1.0, 0.5 * wide, tall]
    faces = corners, np.array([[-1.0, 0.0, 0.0]]), np.full((1, 3), 10.0), np.zeros(1, np.uint8)
    return core.add_mesh((0.1, wide, tall), faces, np.zeros(1, np.int64), np.full(1, 0.1), np.array([[0.0, 0.0, 0.7]]))
