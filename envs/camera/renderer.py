"""The first-person picture of a highway-env road."""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Protocol

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.objects import Landmark, Obstacle, RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.camera.bodies import HEIGHTS_M, body_mesh
from vpf_sim.envs.camera.ground import Ground
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.mesh import Mesh
from vpf_sim.envs.camera.occlusion import far_to_near
from vpf_sim.envs.camera.painter import Drawing, Light, footprint, paint, project_mesh
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.scenery import Scenery
from vpf_sim.envs.camera.sensor import Noise
from vpf_sim.envs.camera.shadows import paint_shadow
from vpf_sim.envs.camera.sky import Sky
from vpf_sim.envs.camera.trees import paint_tree
from vpf_sim.envs.camera.truth import STILL, Drawn, Moment, Motion, truth
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

RANGE_M = 200.0  # bodies farther ahead are not drawn


class Carrier(Protocol):
    """What carries the camera: a highway-env vehicle."""

    position: Floats  # (2,) m
    heading: float  # rad


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What moved, at one frame."""

    view: View
    time_s: float
    poses: dict[int, Floats]  # (x, y, heading) of each body, by its id


class Renderer:
    """Draws one road; made anew when the road is.

    The road is read through its lanes (`position`, `heading_at`, `width_at`, `length`, `line_types`) and through its
    vehicles and objects (`position`, `heading`, LENGTH, WIDTH, and where they have them HEIGHT and `kind`: without
    one a vehicle is a car and an obstacle a barrier; landmarks are not drawn).
    """

    def __init__(self, road: Road, camera: Camera, weather: Weather, seed: int, noise_sd: float | None = None) -> None:
        rig = Rig(camera) if noise_sd is None else Rig(camera, noise_sd)
        self._road = road
        self._camera = camera
        self._seed = seed
        self._light = Light(_towards_sun(weather))
        shapes = lane_shapes(road)
        self._sky = Sky(camera, seed)
        self._ground = Ground(camera, shapes, seed)
        self._scenery = Scenery(camera, shapes, self._light, seed)
        self._noise = Noise(rig, seed)
        self._meshes: dict[int, tuple[RoadObject, Mesh]] = {}
        self._drawn: list[Drawn] = []
        self._now: Snapshot | None = None
        self._before: Snapshot | None = None
        self.bodies: list[RoadObject] = []  # what `truth`'s instance i + 1 stands for

    def render(self, ego: Carrier, time_s: float) -> Image:
        """(H, W, 3) RGB, a fresh array: what the camera on `ego` sees at its present pose."""
        view = View.at(self._camera, ego.position, ego.heading)
        self._advance(view, ego, time_s)
        frame = np.empty((self._camera.height_px, self._camera.width_px, 3), np.uint8)
        self._sky.draw(view, frame)
        self._ground.draw(view, frame)
        self._draw_things(view, frame)
        self._noise.add(frame)
        return frame

    def truth(self, names: tuple[str, ...]) -> dict[str, NDArray[np.generic]]:
        """The arrays called `names` for the frame rendered last (see `vpf_sim.envs.camera.truth`)."""
        if self._now is None or self._before is None:
            raise RuntimeError("no frame has been rendered yet")
        moment = Moment(self._now.view, self._before.view, self._now.time_s - self._before.time_s)
        return truth(names, moment, self._drawn)

    def _advance(self, view: View, ego: Carrier, time_s: float) -> None:
        """Note where everything is now."""
        self.bodies = [body for body in (*self._road.vehicles, *self._road.objects) if body is not ego]
        poses = {id(body): np.array([*body.position, body.heading], float) for body in self.bodies}
        now = Snapshot(view, time_s, poses)
        self._before, self._now = self._now or now, now

    def _draw_things(self, view: View, frame: Image) -> None:
        """Draw what stands up from the ground, and note it for the truth; the farthest first."""
        bodies = self._bodies_in_view(view)
        for i in bodies:
            paint_shadow(frame, view, self._pose(i), self._size(i), self._light)
        trees = self._scenery.trees_in_view(view)
        faces, depths = self._scenery.draw(view)
        self._drawn = []
        drawn_faces = 0
        for body in [*bodies, None]:
            behind = -1.0 if body is None else self._nearest(view, body)
            while trees and trees[0][0][2] > behind:
                sprite = paint_tree(frame, view, *trees.pop(0))
                if sprite is not None:
                    self._drawn.append(Drawn(sprite, -1, STILL))
            until = int(np.searchsorted(-depths, -behind))
            self._paint(frame, faces[drawn_faces:until], -1, STILL)
            drawn_faces = until
            if body is not None:
                self._paint(frame, *self._body(body))

    def _paint(self, frame: Image, drawing: Drawing, instance: int, motion: Motion) -> None:
        """Draw faces and note them for the truth."""
        if len(drawing.polygons_px):
            paint(frame, drawing)
            self._drawn.append(Drawn(drawing, instance, motion))

    def _bodies_in_view(self, view: View) -> list[int]:
        """Indices of the bodies that may be in the picture, the farthest first."""
        eye, axis = view.centre[:2], view.axes[2, :2]
        ahead = [
            i
            for i, body in enumerate(self.bodies)
            if not isinstance(body, Landmark) and -body.LENGTH < float(axis @ (body.position - eye)) < RANGE_M
        ]
        if len(ahead) < 2:
            return ahead
        corners = np.array([footprint(self._pose(i), *self._size(i)[:2]) for i in ahead])
        return [ahead[k] for k in far_to_near(corners, eye)]

    def _nearest(self, view: View, index: int) -> float:
        """Depth of a body's nearest corner."""
        corners = footprint(self._pose(index), *self._size(index)[:2])
        return float(((corners - view.centre[:2]) @ view.axes[2, :2]).min())

    def _pose(self, index: int) -> Floats:
        assert self._now is not None
        return self._now.poses[id(self.bodies[index])]

    def _size(self, index: int) -> tuple[float, float, float]:
        return _size(self.bodies[index])

    def _body(self, index: int) -> tuple[Drawing, int, Motion]:
        """A body's faces in the picture, its instance, and how it moved."""
        assert self._now is not None
        assert self._before is not None
        body = self.bodies[index]
        pose = self._now.poses[id(body)]
        earlier = self._before.poses.get(id(body), pose)
        motion = STILL if np.array_equal(earlier, pose) else Motion.of_body(earlier, pose)
        return project_mesh(self._now.view, self._mesh(body), pose, self._light), index + 1, motion

    def _mesh(self, body: RoadObject) -> Mesh:
        """The body's mesh; the body is kept with it, so that its id stays its own."""
        if id(body) not in self._meshes:
            rng = stream(self._seed, f"body {len(self._meshes)}")
            self._meshes[id(body)] = (body, body_mesh(_kind(body), _size(body), rng))
        return self._meshes[id(body)][1]


def _kind(body: RoadObject) -> str:
    return str(getattr(body, "kind", "barrier" if isinstance(body, Obstacle) else "car"))


def _size(body: RoadObject) -> tuple[float, float, float]:
    """(length, width, height) m."""
    return (float(body.LENGTH), float(body.WIDTH), float(getattr(body, "HEIGHT", HEIGHTS_M[_kind(body)])))


def _towards_sun(weather: Weather) -> Floats:
    altitude, azimuth = radians(weather.sun_altitude_angle), radians(weather.sun_azimuth_angle)
    return np.array([cos(altitude) * cos(azimuth), cos(altitude) * sin(azimuth), sin(altitude)])
