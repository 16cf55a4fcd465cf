"""The road, its surroundings and its traffic in the dark and in the wet, drawn with numpy and OpenCV."""

import cv2
import numpy as np
from highway_env.road.road import Road
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.ground.ground import Ground
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import SHIFT, Sprite
from vpf_sim.envs.camera.rain.spray import Spray
from vpf_sim.envs.camera.rain.wet_road import WetRoad
from vpf_sim.envs.camera.scenery.scene import Scene
from vpf_sim.envs.camera.scenery.shadows import NO_SUN
from vpf_sim.envs.camera.sky.sky import Sky
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.truth import Drawn, Shown
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Bools, Camera, Floats, Image


class PaintedWorld:
    """Everything outside the windscreen except falling rain. It is kept from frame to frame, so skip none."""

    def __init__(self, road: Road, camera: Camera, light: Light, atmosphere: Atmosphere, seed: int) -> None:
        shapes = lane_shapes(road)
        self._sky = Sky(camera, light, atmosphere, seed)
        appearance = getattr(road.network, "appearance", None)
        self._haze = Haze(camera, atmosphere, light)
        self._scene = Scene(camera, shapes, light, self._haze, seed)
        shaded = appearance is not None and appearance.shadows and light.shadow < NO_SUN
        shadows = self._scene.scenery_shadows() if shaded else None
        lamplight = self._scene.lamplight
        self._ground = Ground(camera, shapes, light, atmosphere.wetness, seed, appearance, shadows, lamplight)
        self._wet_road = WetRoad(camera, shapes, atmosphere, seed)
        self._spray = Spray(camera, atmosphere, light, seed)
        self._drawn: list[Drawn] = []
        self._view: View | None = None

    @property
    def is_due(self) -> bool:
        """Whether later frames reuse parts of the next one."""
        return self._wet_road.is_due

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw a frame."""
        self._view = now.view
        self._sky.draw(now.view, frame)
        self._ground.draw(now.view, frame)
        self._haze.ground(frame)
        self._drawn = self._scene.visible(now)
        self._wet_road.draw(frame, now.view, self._drawn)
        self._scene.paint_shadows(frame, now)
        self._scene.paint(frame, self._spray.added(self._drawn, now, before))

    def skip(self, now: Snapshot) -> None:
        """Update what is kept, without drawing."""
        self._ground.update(now.view)
        self._scene.update(now)
        self._wet_road.skip(now.view)

    def shown(self) -> Shown:
        """What each pixel of the last frame shows."""
        assert self._view is not None
        view, drawn = self._view, self._drawn
        label = np.zeros((view.camera.height_px, view.camera.width_px), np.int32)
        instances, planes = [0], [-view.axes[:, 2] / view.centre[2]]
        for item in drawn:
            if isinstance(item.drawing, Sprite):
                x0, y0, x1, y1 = item.drawing.box
                label[y0:y1, x0:x1][item.drawing.through[..., 0] < 128] = len(planes)
                instances.append(item.instance)
                planes.append(np.array([0.0, 0.0, 1.0 / item.drawing.depth_m]))
                continue
            for polygon, plane in zip(_fixed(item.drawing.polygons_px), item.drawing.planes, strict=True):
                cv2.fillConvexPoly(label, polygon, (len(planes),), cv2.LINE_8, SHIFT)
                instances.append(item.instance)
                planes.append(plane)
        return Shown(np.array(instances, np.int32).take(label), np.array(planes).take(label, axis=0))

    def hidden(self) -> Bools:
        """(H, W) where reflections and spray hide or falsify the scene in the last frame."""
        return self._wet_road.hidden() | self._spray.hidden()


def _fixed(polygons: Floats) -> NDArray[np.int32]:
    """Pixels in OpenCV's fixed-point format."""
    return np.asarray(np.rint(polygons * 2**SHIFT), np.int32)
