"""Objects and static scenery: visibility, drawing order and painting."""

from dataclasses import dataclass
from math import asin, atan2, cos, hypot, inf, pi, remainder, sin

import numpy as np
from highway_env.vehicle.objects import Landmark, Obstacle, RoadObject

from vpf_sim.envs.camera.detail import stale_m
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.glow import Glow, glow
from vpf_sim.envs.camera.night.lamps import vehicle_lamps
from vpf_sim.envs.camera.painter import Drawing, Sprite, footprint, paint
from vpf_sim.envs.camera.scenery.bands import banded
from vpf_sim.envs.camera.scenery.object_meshes import object_mesh
from vpf_sim.envs.camera.scenery.objects import kind_of, object_size
from vpf_sim.envs.camera.scenery.occlusion import far_to_near
from vpf_sim.envs.camera.scenery.shadows import Shadow
from vpf_sim.envs.camera.scenery.solid import RANGE_M, Solid
from vpf_sim.envs.camera.scenery.static_scenery import StaticScenery
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

SHADOW_REACH = 4.0  # longest shadows, in heights


@dataclass(frozen=True, slots=True)
class Shape:
    """An object's mesh and shadow."""

    solid: Solid
    shadow: Shadow


class Scene:
    """The objects and the static scenery of one road."""

    def __init__(self, camera: Camera, shapes: list[LaneShape], light: Light, haze: Haze, seed: int) -> None:
        self._seed = seed
        self._light = light
        self._haze = haze
        self._scenery = StaticScenery(camera, shapes, light, haze, seed)
        self.lamplight = self._scenery.lamplight  # None by day
        self._shapes: dict[RoadObject, Shape] = {}
        self._drawing_order = DrawingOrder()
        self._order: list[int] = []

    @timed("render.visible")
    def visible(self, now: Snapshot) -> list[Drawn]:
        """All visible items, projected, the farthest first."""
        self._make_shapes(now)
        trees = self._scenery.visible_sprites(now.view)
        scenery, depths = self._scenery.visible(now.view)
        drawn: list[Drawn] = []
        first = tree = 0
        self._order, nearest = self._drawing_order.in_view(now)
        for i, behind in [*zip(self._order, nearest, strict=True), (None, -1.0)]:
            while tree < len(trees) and trees[tree].depth_m > behind:
                if scenery is not None and _covers(trees[tree], scenery, depths):
                    first = _add_until(drawn, scenery, depths, first, trees[tree].depth_m)
                drawn.append(Drawn(trees[tree], -1))
                tree += 1
            obj = None if i is None else self._object(now, i)
            if i is None or obj is not None:
                first = _add_until(drawn, scenery, depths, first, behind)
            if obj is not None:
                drawn.append(obj)
            if i is not None and obj is not None and self._light.has_lamps:
                drawn += [Drawn(lamp, -1) for lamp in self._lamps(now, i)]
        return drawn

    def update(self, now: Snapshot) -> None:
        """Update visibility as `visible` does, without drawing."""
        self._make_shapes(now)
        self._scenery.update(now.view)
        self._order, _ = self._drawing_order.in_view(now)
        for i in self._order:
            obj = now.objects[i]
            self._shape(obj).solid.update(now.view, now.poses[obj])

    def scenery_shadows(self) -> list[Floats]:
        """(V, 2) m, outlines of the shadows of furniture, trees and bushes on the ground."""
        return self._scenery.shadow_polygons(self._light)

    @timed("render.scene")
    def paint(self, frame: Image, drawn: list[Drawn]) -> None:
        """Draw items over the image, in their order."""
        paint(frame, [item.drawing for item in drawn])

    @timed("render.shadows")
    def paint_shadows(self, frame: Image, now: Snapshot) -> None:
        """Draw the shadows of the objects found by `visible`."""
        for i in self._order:
            obj = now.objects[i]
            self._shape(obj).shadow.paint(frame, now.view, now.poses[obj])

    def _object(self, now: Snapshot, index: int) -> Drawn | None:
        """An object's visible faces; None without any."""
        obj = now.objects[index]
        pose = now.poses[obj]
        drawing = self._shape(obj).solid.visible(now.view, pose)
        return None if drawing is None else Drawn(drawing, index + 1)

    def _lamps(self, now: Snapshot, index: int) -> list[Glow]:
        """The lamps of a vehicle that shine into the camera; parked vehicles have none."""
        obj = now.objects[index]
        if isinstance(obj, Obstacle):
            return []
        found = vehicle_lamps(now.view, now.poses[obj], kind_of(obj), object_size(obj), self._light)
        glows = [glow(now.view.camera, lamp) for lamp in found]
        return [one for one in glows if one is not None]

    def _make_shapes(self, now: Snapshot) -> None:
        """Make the meshes of all objects in the road's order, which numbers them."""
        for obj in now.objects:
            if obj not in self._shapes and not isinstance(obj, Landmark):
                self._shape(obj)

    def _shape(self, obj: RoadObject) -> Shape:
        """The mesh and shadow of an object, created on first use."""
        if obj not in self._shapes:
            rng = stream(self._seed, f"body {len(self._shapes)}")  # part of what a seed means: keep
            size = object_size(obj)
            mesh = object_mesh(kind_of(obj), size, rng)
            if self.lamplight is not None:
                mesh = banded(mesh)
            solid = Solid(mesh, self._light, self._haze, self.lamplight)
            self._shapes[obj] = Shape(solid, Shadow(size, self._light))
        return self._shapes[obj]


def _covers(tree: Sprite, scenery: Drawing, depths: list[float]) -> bool:
    """Whether a tree may cover scenery items, which then must be drawn before it."""
    left, top, right, bottom = tree.box
    for (x0, y0, x1, y1), depth in zip(scenery.boxes, depths, strict=True):
        if depth <= tree.depth_m:
            return False
        if left < x1 and x0 < right and top < y1 and y0 < bottom:
            return True
    return False


def _add_until(drawn: list[Drawn], scenery: Drawing | None, depths: list[float], first: int, behind: float) -> int:
    """Add the scenery items from `first` on that are farther than `behind`; returns the next index."""
    last = first
    while last < len(depths) and depths[last] > behind:
        last += 1
    if scenery is not None and last > first:
        drawn.append(Drawn(scenery.part(first, last), -1))
    return last


class DrawingOrder:
    """Drawing order of objects. While none moves, it is updated when the camera has moved by `stale_m`."""

    def __init__(self) -> None:
        self._places: list[list[float]] = []
        self._eye = (inf, inf)
        self._order: list[int] = []

    def in_view(self, now: Snapshot) -> tuple[list[int], list[float]]:
        """Indices of the objects that may be visible, farthest first, and depths of their nearest corners.

        An object in front of another comes later, whatever their depths.
        """
        ahead = _ahead(now)
        discs = {i: _disc(now, i) for i in ahead}
        places = [[i, *now.poses[now.objects[i]].tolist()] for i in ahead]
        x, y, _ = now.view.centre.tolist()
        if places != self._places or hypot(x - self._eye[0], y - self._eye[1]) > stale_m(now.view.camera):
            self._places, self._eye, self._order = places, (x, y), _far_to_near(now, discs)
        return self._order, [discs[i].nearest_m for i in self._order]


def _far_to_near(now: Snapshot, discs: "dict[int, Disc]") -> list[int]:
    """The objects in drawing order."""
    ahead = list(discs)
    order = sorted(ahead, key=lambda i: -discs[i].distance_m)
    if not any(_is_ambiguous(discs[i], discs[j]) for n, i in enumerate(order) for j in order[n + 1 :]):
        return order
    corners = np.array([_footprint(now, i) for i in ahead])
    return [ahead[k] for k in far_to_near(corners, now.view.centre[:2])]


@dataclass(frozen=True, slots=True)
class Disc:
    """The bounding circle of an object's footprint, from the camera."""

    distance_m: float
    bearing_rad: float
    radius_m: float
    nearest_m: float  # depth of the nearest corner


def _disc(now: Snapshot, index: int) -> Disc:
    obj, view = now.objects[index], now.view
    x, y, heading = now.poses[obj].tolist()
    eye_x, eye_y, _ = view.centre.tolist()
    axis_x, axis_y, _ = view.axes[2].tolist()
    x, y = x - eye_x, y - eye_y
    length, width, _ = object_size(obj)
    c, s = cos(heading), sin(heading)
    depth = axis_x * x + axis_y * y
    half = 0.5 * length * abs(axis_x * c + axis_y * s) + 0.5 * width * abs(axis_y * c - axis_x * s)
    return Disc(hypot(x, y), atan2(y, x), 0.5 * hypot(length, width), depth - half)


def _is_ambiguous(farther: Disc, nearer: Disc) -> bool:
    """Whether distance alone does not decide which of two objects covers the other."""
    if farther.distance_m - farther.radius_m >= nearer.distance_m + nearer.radius_m:
        return False
    if nearer.distance_m <= nearer.radius_m or farther.distance_m <= farther.radius_m:
        return True
    apart = abs(remainder(farther.bearing_rad - nearer.bearing_rad, 2.0 * pi))
    return apart < sum(asin(disc.radius_m / disc.distance_m) for disc in (farther, nearer))


def _ahead(now: Snapshot) -> list[int]:
    """Indices of the objects whose position allows them or their shadows to be visible."""
    view = now.view
    c, s = cos(view.yaw_rad), sin(view.yaw_rad)
    eye_x, eye_y, _ = view.centre.tolist()
    slope = 0.5 * view.camera.width_px / view.camera.fx_px
    result = []
    for index, obj in enumerate(now.objects):
        x, y, _ = now.poses[obj].tolist()
        ahead, aside = c * (x - eye_x) + s * (y - eye_y), c * (y - eye_y) - s * (x - eye_x)
        if ahead < RANGE_M and not isinstance(obj, Landmark):
            length, width, height = object_size(obj)
            reach = length + width + SHADOW_REACH * height
            if -reach < ahead and abs(aside) < slope * (ahead + reach) + reach:
                result.append(index)
    return result


def _footprint(now: Snapshot, index: int) -> Floats:
    obj = now.objects[index]
    return footprint(now.poses[obj], *object_size(obj)[:2])
