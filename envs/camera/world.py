"""The road, its surroundings and its traffic, drawn by the core."""

from math import dist
from typing import Any

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.objects import Landmark, RoadObject

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import NO_LAMPS, Core
from vpf_sim.envs.camera.ground.content import set_ground
from vpf_sim.envs.camera.ground.even_gains import even_gains
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.content import FrameLamps, set_lamps
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.rain.content import WetSurface, wet_surface
from vpf_sim.envs.camera.scenery.bands import banded
from vpf_sim.envs.camera.scenery.content import NO_SUN, add_mesh, set_light, set_roadside
from vpf_sim.envs.camera.scenery.object_meshes import object_mesh
from vpf_sim.envs.camera.scenery.objects import kind_of, object_size
from vpf_sim.envs.camera.scenery.roadside import group_of
from vpf_sim.envs.camera.scenery.static_scenery import StaticScenery
from vpf_sim.envs.camera.scenery.tree_content import plant
from vpf_sim.envs.camera.scenery.verge import lamp_places
from vpf_sim.envs.camera.sky.content import add_sky
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.truth import Shown
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Bools, Camera, Floats, Image

NOT_DRAWN = -1  # no mesh
MESH_RANGE_M = 240.0  # beyond the range at which objects appear, and what the camera is ahead of its car


class World:
    """Everything outside the windscreen. A frame depends on the pose, the objects and the time alone."""

    def __init__(self, road: Road, camera: Camera, light: Light, atmosphere: Atmosphere, seed: int) -> None:
        self._seed = seed
        self._meshes: dict[RoadObject, int] = {}
        self._bodies: dict[RoadObject, int] = {}
        self._core = core = Core(camera, ground_top(camera))
        shapes, haze = lane_shapes(road), Haze(camera, atmosphere, light)
        scenery = StaticScenery(camera, shapes, seed)
        lamplight = Lamplight(light, lamp_places(scenery.furniture)) if light.has_lamps else None
        appearance = getattr(road.network, "appearance", None)
        look = RoadAppearance() if appearance is None else appearance
        shaded = appearance is not None and appearance.shadows and light.shadow < NO_SUN
        shadows = scenery.shadow_polygons(light) if shaded else []
        add_sky(core, light, atmosphere, seed)
        set_ground(core, shapes, light, atmosphere.wetness, seed, look, shadows, haze, even_gains(camera), lamplight)
        set_light(core, light, haze)
        self._lamps: FrameLamps | None = None
        if lamplight is not None:
            set_lamps(core, lamplight)
            self._lamps = FrameLamps(core, lamplight)
        set_roadside(core, group_of(scenery.furniture, camera))
        plant(core, scenery.trees, light, haze)
        self._wet = wet_surface(core, shapes, light, atmosphere, seed)
        self._drawn: tuple[Snapshot, Snapshot] | None = None  # the last frame that was drawn, and the one before
        self._is_copy = False  # whether the core has not drawn that frame itself

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._is_copy = True

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw a frame."""
        self._drawn, self._is_copy = (now, before), False
        self._begin(now, before)
        self._draw_backdrop(frame)
        if self._wet is not None:
            self._draw_wet_road(frame, self._wet, now)
        self._draw_scene(frame)

    def shown(self) -> Shown:
        """What each pixel of the last frame shows."""
        return Shown(*self._core.truth())

    def hidden(self) -> Bools:
        """(H, W) where reflections and spray hide the scene of the last frame."""
        if self._is_copy and self._drawn is not None:
            camera = self._core.camera
            self.draw(np.empty((camera.height_px, camera.width_px, 3), np.uint8), *self._drawn)
        return self._core.hidden_by_rain()

    @timed("render.visible")
    def _begin(self, now: Snapshot, before: Snapshot) -> None:
        objects = np.empty((len(now.objects), 4))
        objects[:, :3] = now.places
        objects.view(np.int64)[:, 3] = self._numbers(now)
        self._core.begin(*now.pose, now.time_s, objects, NO_LAMPS if self._lamps is None else self._lamps.of(now))
        gap_s = now.time_s - before.time_s
        if self._wet is not None and gap_s > 0.0 and now.objects:
            self._core.begin_spray(_moved_m(now, before) / gap_s)

    @timed("render.wet_road")
    def _draw_wet_road(self, frame: Image, wet: WetSurface, now: Snapshot) -> None:
        wet.update(*now.pose)
        self._core.draw_wet_road(frame)

    @timed("render.backdrop")
    def _draw_backdrop(self, frame: Image) -> None:
        self._core.draw_backdrop(frame)

    @timed("render.scene")
    def _draw_scene(self, frame: Image) -> None:
        self._core.draw_scene(frame)

    def _numbers(self, now: Snapshot) -> list[int]:
        """The meshes of objects; NOT_DRAWN for those that are far away, whose meshes are not made yet."""
        unmade = [i for i, obj in enumerate(now.objects) if obj not in self._meshes]
        for i in unmade:
            self._meet(now.objects[i], dist(now.pose[:2], now.places[i, :2]))
        return [self._meshes.get(obj, NOT_DRAWN) for obj in now.objects]

    def _meet(self, obj: RoadObject, distance_m: float) -> None:
        """Number an object by the order in which objects appear on the road, and make its mesh when it is near."""
        if isinstance(obj, Landmark):
            self._meshes[obj] = NOT_DRAWN
            return
        body = self._bodies.setdefault(obj, len(self._bodies))
        if distance_m < MESH_RANGE_M:
            size = object_size(obj)
            mesh = object_mesh(
                kind_of(obj), size, stream(self._seed, f"body {body}")
            )  # part of what a seed means: keep
            self._meshes[obj] = add_mesh(self._core, mesh if self._lamps is None else banded(mesh), size)


def _moved_m(now: Snapshot, before: Snapshot) -> Floats:
    """(n,) m, how far each object has moved."""
    places = now.places
    if before.objects == now.objects:
        earlier = before.places
    else:
        known = dict(zip(before.objects, before.places, strict=True))
        earlier = np.array([known.get(obj, place) for obj, place in zip(now.objects, places, strict=True)])
    dx, dy = (places[:, :2] - earlier[:, :2]).T
    return np.asarray(np.sqrt(dx * dx + dy * dy))
