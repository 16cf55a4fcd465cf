"""What stands beside the road, placed by a seed along the outer edges: posts, guard rails, signs, trees and bushes."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from vpf_sim.envs.camera.layout import LaneShape, outer_edges
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.mesh import Colour, Mesh, MeshBuilder, Point, box
from vpf_sim.envs.camera.nearby import Nearby
from vpf_sim.envs.camera.painter import Drawing
from vpf_sim.envs.camera.view import NEAR_M, View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

POST_SPACING_M, POST_OFFSET_M = 25.0, 1.3
RAIL_OFFSET_M, RAIL_SPAN_M = 1.7, 4.0
TREE_SPACING_M = 18.0
RANGE_M, TREE_RANGE_M = 100.0, 95.0
RANGE_PER_THICKNESS = 550.0  # a face 10 cm thick is drawn up to 55 m, where it is 0.6 px
FACE_RADIUS_M = 2.0
STEEL: Colour = (158, 163, 168)
WHITE: Colour = (232, 233, 230)
BLACK: Colour = (34, 34, 36)


@dataclass(frozen=True, slots=True)
class Trees:
    """All trees of a road."""

    feet_m: Floats  # (T, 2) world
    heights_m: Floats  # (T,)
    variants: list[int]


class Scenery:
    """What stands beside a road and never moves."""

    def __init__(self, camera: Camera, shapes: list[LaneShape], light: Light, seed: int) -> None:
        rng = stream(seed, "scenery")
        lanes = np.concatenate([0.5 * (shape.left_m + shape.right_m) for shape in shapes])
        half = max(0.5 * shape.width_m for shape in shapes)
        self._lanes, self._half = cKDTree(_dense(shapes, lanes)), half
        edges = [edge.resampled(RAIL_SPAN_M) for edge in outer_edges(shapes)]
        stations = [(edge.points_m, edge.outward) for edge in edges]
        meshes: list[tuple[Mesh, Floats]] = []
        for points, outward in stations:
            meshes += self._furniture(points, outward, rng)
        self.trees = self._plant(stations, rng)
        self._faces, self._normals, self._colours, thickness = _in_world(meshes, light)
        ranges = np.minimum(RANGE_M, thickness * RANGE_PER_THICKNESS)
        radii = np.full(len(ranges), FACE_RADIUS_M)
        self._nearby = Nearby(camera, self._faces.mean(axis=1)[:, :2], radii, ranges)

    def draw(self, view: View) -> tuple[Drawing, Floats]:
        """The faces in view, the farthest first, and their depths (n,) m."""
        seen, _ = self._nearby.in_view(view)
        faces = view.camera_axes(self._faces[seen])
        normals = self._normals[seen] @ view.axes.T
        offset = np.einsum("ij,ij->i", normals, faces[:, 0])
        kept = np.flatnonzero((offset < -1e-6) & (faces[..., 2] > NEAR_M).all(axis=1))
        depth = faces[kept, :, 2].mean(axis=1)
        nearer = 1e-6 * np.arange(len(kept))  # what lies on a face is laid after it, however the depths are rounded
        kept, depth = kept[order := np.argsort(nearer - depth)], depth[order]
        pixels = view.pixels(faces[kept])
        return Drawing(pixels, self._colours[seen[kept]], normals[kept] / offset[kept, None]), depth

    def trees_in_view(self, view: View) -> list[tuple[Floats, float, int]]:
        """(foot in camera axes, height, variant) of each tree in view, the farthest first."""
        feet = view.camera_axes(np.column_stack([self.trees.feet_m, np.zeros(len(self.trees.feet_m))]))
        slope = 0.5 * view.camera.width_px / view.camera.fx_px
        seen = (feet[:, 2] > 4.0) & (feet[:, 2] < TREE_RANGE_M)
        seen &= np.abs(feet[:, 0]) < slope * feet[:, 2] + 0.4 * self.trees.heights_m
        order = np.flatnonzero(seen)
        order = order[np.argsort(-feet[order, 2], kind="stable")]
        return [(feet[i], float(self.trees.heights_m[i]), self.trees.variants[i]) for i in order]

    def _clear(self, points: Floats, margin_m: float) -> np.ndarray:
        """Which points are at least `margin_m` away from every lane."""
        distance, _ = self._lanes.query(points)
        return np.asarray(distance > self._half + margin_m - 0.3)

    def _furniture(self, points: Floats, outward: Floats, rng: np.random.Generator) -> list[tuple[Mesh, Floats]]:
        """Posts, and here and there a rail or a sign, along one edge sampled every 4 m."""
        result: list[tuple[Mesh, Floats]] = []
        every = round(POST_SPACING_M / RAIL_SPAN_M)
        heading = np.arctan2(*(points[-1] - points[0])[::-1]) if len(points) > 1 else 0.0
        along = np.arctan2(outward[:, 1], outward[:, 0])
        railed = _railed(len(points), rng)
        places = points + POST_OFFSET_M * outward
        free = self._clear(places, POST_OFFSET_M)
        turned = np.sign(np.sin(along - heading))
        facing = along - turned * np.pi / 2  # back along the lane
        standing = np.flatnonzero(free & ~railed & (np.arange(len(points)) % every == 0))
        result += [(POST, np.array([*places[i], facing[i]])) for i in standing]
        rail = points + RAIL_OFFSET_M * outward
        clear = self._clear(rail, RAIL_OFFSET_M)
        for i in np.flatnonzero(railed[:-1] & railed[1:] & clear[:-1] & clear[1:]).tolist():
            span = rail[i + 1] - rail[i]
            result.append((_rail(round(float(np.hypot(*span)), 2)), np.array([*rail[i], np.arctan2(span[1], span[0])])))
        for i in range(int(rng.integers(10, 40)), len(points), 45):
            place = points[i] + 2.6 * outward[i]
            if self._clear(place[None], 2.6)[0]:
                sign = SIGNS[int(rng.integers(len(SIGNS)))]
                result.append((sign, np.array([*place, facing[i]])))
        return result

    def _plant(self, stations: list[tuple[Floats, Floats]], rng: np.random.Generator) -> Trees:
        feet = []
        for points, outward in stations:
            every = max(1, round(TREE_SPACING_M / RAIL_SPAN_M))
            base, out = points[::every], outward[::every]
            reach = 5.5 + 26.0 * rng.random(len(base)) ** 1.6
            place = base + reach[:, None] * out + rng.uniform(-4.0, 4.0, (len(base), 2))
            feet.append(place[self._clear(place, 4.0) & (rng.random(len(base)) < 0.75)])
        all_feet = np.concatenate([np.empty((0, 2)), *feet])
        variants = rng.integers(0, 8, len(all_feet))
        tall = np.array([9.5, 8.0, 12.0, 2.4])[variants % 4] * rng.uniform(0.7, 1.25, len(all_feet))
        return Trees(all_feet, tall, [int(v) for v in variants])


def _dense(shapes: list[LaneShape], fallback: Floats) -> Floats:
    """Points on the middles of all lanes, at most 2 m apart."""
    points = [fallback]
    for shape in shapes:
        middle = 0.5 * (shape.left_m + shape.right_m)
        steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        s = np.arange(0.0, along[-1], 2.0)
        points.append(np.stack([np.interp(s, along, middle[:, i]) for i in range(2)], axis=1))
    return np.concatenate(points)


def _railed(count: int, rng: np.random.Generator) -> np.ndarray:
    """Which stations have a guard rail: stretches of 40 to 160 m, about a third of the way."""
    flags = np.zeros(count, bool)
    i = int(rng.integers(0, 40))
    while i < count:
        length = int(rng.integers(10, 40))
        flags[i : i + length] = True
        i += length + int(rng.integers(20, 70))
    return flags


def _in_world(meshes: list[tuple[Mesh, Floats]], light: Light) -> tuple[Floats, Floats, Floats, Floats]:
    """Faces (F, 4, 3), normals and shaded colours (F, 3), thickness (F,) of meshes at their poses (x, y, heading)."""
    poses: dict[int, list[Floats]] = {}
    kinds = {id(mesh): mesh for mesh, _ in meshes}
    for mesh, pose in meshes:
        poses.setdefault(id(mesh), []).append(pose)
    faces, normals, colours = [np.empty((0, 4, 3))], [np.empty((0, 3))], [np.empty((0, 3))]
    thickness = [np.empty(0)]
    for key, mesh in kinds.items():
        x, y, heading = np.array(poses[key]).T
        c, s, zero, one = np.cos(heading), np.sin(heading), np.zeros(len(x)), np.ones(len(x))
        turns = np.stack([c, -s, zero, s, c, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
        places = np.stack([x, y, zero], axis=1)
        faces.append((np.einsum("nij,fvj->nfvi", turns, mesh.faces_m[:, :4]) + places[:, None, None]).reshape(-1, 4, 3))
        turned = np.einsum("nij,fj->nfi", turns, mesh.normals)
        shading = light.sky + light.direct * np.maximum(0.0, turned @ light.sun)[..., None]
        colours.append(np.minimum(255.0, mesh.colours * shading).reshape(-1, 3))
        normals.append(turned.reshape(-1, 3))
        thickness.append(np.tile(mesh.thickness_m, len(x)))
    return np.concatenate(faces), np.concatenate(normals), np.concatenate(colours), np.concatenate(thickness)


def _post() -> Mesh:
    """A delineator: a white post with a black band and a reflector."""
    b = MeshBuilder()
    panels = box(b, (-0.05, -0.06, 0.0), (0.05, 0.06, 1.0), WHITE)
    for panel in panels.values():
        b.detail(panel, (0.0, 0.66), (1.0, 0.9), BLACK)
        b.detail(panel, (0.3, 0.7), (0.7, 0.86), (210, 200, 170))
    return b.build()


@lru_cache(maxsize=256)
def _rail(length: float) -> Mesh:
    """One span of a guard rail along x: a folded band on a post; both sides."""
    b = MeshBuilder()
    box(b, (-0.06, -0.05, 0.0), (0.06, 0.05, 0.68), shade_of(STEEL, 0.7))
    bands = (
        (0.45, 0.76, 0.85),
        (0.45, 0.52, 0.8),
        (0.52, 0.58, 1.12),
        (0.58, 0.63, 0.62),
        (0.63, 0.69, 1.12),
        (0.69, 0.76, 0.85),
    )
    for low, high, factor in bands:
        for y, ends in ((-0.1, (length, 0.0)), (0.1, (0.0, length))):
            near, far = ends
            panel: list[Point] = [(near, y, low), (far, y, low), (far, y, high), (near, y, high)]
            b.whole(panel, shade_of(STEEL, factor))
    for y, (near, far) in ((-0.11, (0.18, 0.06)), (0.11, (0.06, 0.18))):
        b.whole([(near, y, 0.56), (far, y, 0.56), (far, y, 0.66), (near, y, 0.66)], (236, 150, 40))
        b.whole(
            [
                (near + length / 2, y, 0.47),
                (far + length / 2, y, 0.47),
                (far + length / 2, y, 0.74),
                (near + length / 2, y, 0.74),
            ],
            (96, 99, 102),
        )
    return b.build()


def shade_of(colour: Colour, factor: float) -> Colour:
    """The colour, lighter or darker."""
    return (colour[0] * factor, colour[1] * factor, colour[2] * factor)


def _sign(colour: Colour, border: Colour, width: float, height: float, low: float) -> Mesh:
    """A sign on a pole that faces back along x, with bars for its writing."""
    b = MeshBuilder()
    box(b, (0.02, -0.04, 0.0), (0.1, 0.04, low + 0.5 * height), shade_of(STEEL, 0.8))
    panels = box(b, (-0.03, -0.5 * width, low), (0.0, 0.5 * width, low + height), border)
    b.detail(panels["rear"], (0.04, 0.05), (0.96, 0.95), colour)
    for i, span in enumerate(((0.15, 0.7), (0.15, 0.85), (0.15, 0.55))):
        v = 0.72 - 0.24 * i
        b.detail(panels["rear"], (span[0], v), (span[1], v + 0.11), border)
    b.whole(panels["front"], shade_of(STEEL, 0.75))
    return b.build()


POST = _post()
SIGNS = (
    _sign((24, 76, 168), WHITE, 1.6, 1.1, 1.6),
    _sign(WHITE, (190, 30, 34), 0.8, 0.8, 1.9),
    _sign((18, 104, 66), WHITE, 2.4, 1.5, 1.8),
    _sign((238, 200, 40), BLACK, 0.9, 0.9, 1.8),
)
