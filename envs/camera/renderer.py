"""The first-person picture of a highway-env road."""

from math import radians

import cv2
import numpy as np
from highway_env.vehicle.objects import Landmark, Obstacle
from highway_env.road.road import Road

from vpf_sim.envs.camera.ground import Grain, ground_top
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.paint import painted
from vpf_sim.envs.camera.painter import Light, paint, project_mesh
from vpf_sim.envs.camera.palette import ground_table
from vpf_sim.envs.camera.shapes import HEIGHTS_M, body_mesh
from vpf_sim.envs.camera.surface import Surface
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image


class Renderer:
    """Draws one road; made anew when the road is."""

    def __init__(self, road: Road, camera: Camera, weather: Weather, seed: int) -> None:
        self._road = road
        self._camera = camera
        self._seed = seed
        self._light = Light(_towards_sun(weather))
        shapes = lane_shapes(road)
        self._grain = Grain(camera, seed)
        self._surface = Surface(camera, painted(shapes, seed))
        self._table = ground_table()
        self._top = ground_top(camera)
        self._meshes: dict[int, object] = {}
        ramp = np.linspace(0, 1, max(self._top, 1))[:, None, None]
        sky = (1 - ramp) * np.array([110, 150, 205]) + ramp * np.array([205, 218, 230])
        self._sky = np.repeat(sky, camera.width_px, axis=1).astype(np.uint8)

    def render(self, ego, time_s: float) -> Image:
        """(H, W, 3) RGB, a fresh array: what the camera on `ego` sees at its present pose."""
        view = View.at(self._camera, ego.position, ego.heading)
        frame = np.empty((self._camera.height_px, self._camera.width_px, 3), np.uint8)
        frame[: self._top] = self._sky[: self._top]
        values = cv2.subtract(self._surface.draw(view), self._grain.mean)
        values = cv2.add(values, self._grain.draw(view))
        cv2.applyColorMap(values, self._table, frame[self._top :])
        for body in self._ahead(view, ego):
            mesh = self._mesh(body)
            paint(frame, project_mesh(view, mesh, body.position, body.heading, self._light))
        return frame

    def truth(self, names: tuple[str, ...]) -> dict[str, Floats]:
        return {}

    def _ahead(self, view: View, ego):
        bodies = [
            b for b in [*self._road.vehicles, *self._road.objects] if b is not ego and not isinstance(b, Landmark)
        ]
        depth = [float(view.axes[2, :2] @ (b.position - view.centre[:2])) for b in bodies]
        order = sorted(range(len(bodies)), key=lambda i: -depth[i])
        return [bodies[i] for i in order if -bodies[i].LENGTH < depth[i] < 200]

    def _mesh(self, body):
        key = id(body)
        if key not in self._meshes:
            kind = getattr(body, "kind", "barrier" if isinstance(body, Obstacle) else "car")
            rng = stream(self._seed, f"body {len(self._meshes)}")
            height = getattr(body, "HEIGHT", HEIGHTS_M[kind])
            self._meshes[key] = body_mesh(kind, body.LENGTH, body.WIDTH, height, rng)
        return self._meshes[key]


def _towards_sun(weather: Weather) -> Floats:
    altitude, azimuth = radians(weather.sun_altitude_angle), radians(weather.sun_azimuth_angle)
    return np.array([np.cos(altitude) * np.cos(azimuth), np.cos(altitude) * np.sin(azimuth), np.sin(altitude)])
