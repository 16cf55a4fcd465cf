"""The faces of all road furniture, and their visible subset."""

from dataclasses import dataclass
from functools import partial
from math import atan, tan

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.detail import STALE_M, detail, stale_m
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.painter import Drawing, drawing, in_front, planes_of
from vpf_sim.envs.camera.scenery.aerial_perspective import AerialPerspective, contrasts
from vpf_sim.envs.camera.scenery.mesh import Mesh
from vpf_sim.envs.camera.view import NEAR_M, View
from vpf_sim.types import Bools, Camera, Floats

VERTICES = 4  # of every face
VISIBLE_PX = 0.5  # faces thinner than this are not drawn
WHOLE_RANGE_M = 1e3  # faces drawn up to this distance are drawn over the whole range of their item
CELL_M, SECTORS = 6.0, 36  # candidates are kept while the camera stays in a cell and a heading sector
FADING = 0.15  # last share of the range, in which an item fades
FULL = 1.0 / FADING
COARSE_M = 60.0  # faces drawn at this distance cast shadows; at full detail
EDGE_ON = 0.05  # except faces at grazing sunlight
STALE_RAD_PER_M = 0.02 / STALE_M  # most rotation of the camera before visibility is updated, over most motion
LOWEST_SUN = 0.1  # lowest sine of the altitude for shadow lengths

Placement = tuple[Mesh, Floats, float]  # mesh, pose (x, y, heading), drawing range m
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Group:
    """Items and their faces in world axes; an item's faces are consecutive, in painter's order."""

    middles_m: Floats  # (k, 2)
    radii_m: Floats  # (k,)
    owner: Indices  # (F,) index of the face's item
    faces_m: Floats  # (F, VERTICES, 3)
    normals: Floats  # (F, 3)
    offsets_m: Floats  # (F,) plane offsets
    colours: Floats  # (F, 4) contrasts in daylight, or (F, 3) RGB in full light for the light of lamps
    from_m: Floats  # (F,) distance range of the face
    until_m: Floats  # (F,)
    fading: Floats  # (F,) 1/m, slope of the opacity in the last share of the range
    retro: Bools  # (F,) whether they are retroreflective
    lit: Bools  # (F,) whether light shades them

    def only(self, items: Bools, faces: Bools) -> "Group":
        """The faces `faces` of the items `items`."""
        kept = np.flatnonzero(faces & items[self.owner])
        owner = (np.cumsum(items) - 1)[self.owner[kept]]
        return Group(
            self.middles_m[items],
            self.radii_m[items],
            owner,
            faces_m=self.faces_m[kept],
            normals=self.normals[kept],
            offsets_m=self.offsets_m[kept],
            colours=self.colours[kept],
            from_m=self.from_m[kept],
            until_m=self.until_m[kept],
            fading=self.fading[kept],
            retro=self.retro[kept],
            lit=self.lit[kept],
        )


@dataclass(frozen=True, slots=True)
class VisibleFaces:
    """The visible faces near one view, the farthest item first.

    They and their colours are reused until the camera has moved by `stale_m` or turned as much. Until then new faces,
    which are edge-on, are missed, and colours are slightly off, by at most 1 % at full detail."""

    view: View
    stale_m: float
    faces_m: Floats  # (n, V, 3) world, clipped to before the camera
    normals: Floats  # (n, 3)
    offsets_m: Floats  # (n,)
    colours: list[list[float]]  # (n, 4)
    firsts: Indices  # (k,) the first face of each item
    depths_m: list[float]  # (k,)

    def plane_distances(self, view: View) -> Floats | None:
        """(n,) m, distances of the camera from the faces' planes; None if visibility is stale."""
        x, y, _ = (view.centre - self.view.centre).tolist()
        turned_rad = abs(view.yaw_rad - self.view.yaw_rad)
        if x * x + y * y > self.stale_m**2 or turned_rad > STALE_RAD_PER_M * self.stale_m:
            return None
        distances = self.normals @ view.centre - self.offsets_m
        return distances if distances.min(initial=1.0) > 1e-6 else None


class Roadside:
    """The road furniture of one road."""

    def __init__(
        self, camera: Camera, items: list[Placement], light: Light, haze: Haze, lamplight: Lamplight | None = None
    ) -> None:
        """`lamplight` is the light of lamps in the dark, None by day."""
        self._light, self._lamplight = light, lamplight
        self._slope = 0.5 * camera.width_px / camera.fx_px  # slope of the field of view's sides
        self._stale_m = stale_m(camera)
        self._coarse_m = COARSE_M * detail(camera)
        self._surely_m = NEAR_M + 2.0 * self._stale_m  # nearer parts are clipped, or they might pass the near plane
        self._widest = tan(atan(self._slope) + STALE_RAD_PER_M * self._stale_m)
        self._aerial_perspective = AerialPerspective(light, haze)
        self._all = self._near = group_of(items, None if lamplight is not None else light, camera)
        self._place: tuple[int, int, int] | None = None
        self.cached: VisibleFaces | None = None

    def visible(self, view: View) -> tuple[Drawing | None, list[float]]:
        """The visible faces, the farthest item first, and the depth of each item, m."""
        visible, distances = self._current(view)
        if not len(visible.depths_m):
            return None, []
        moved_m = float(view.axes[2] @ (view.centre - visible.view.centre))
        planes = partial(planes_of, visible.normals, distances, view)
        return drawing(view, visible.faces_m, visible.colours, planes, visible.firsts), [
            far - moved_m for far in visible.depths_m
        ]

    def update(self, view: View) -> None:
        """Update visibility if it is stale."""
        self._current(view)

    def _current(self, view: View) -> tuple[VisibleFaces, Floats]:
        """The visible faces, and (n,) m, distances of the camera from their planes."""
        visible = self.cached
        if visible is None or (distances := visible.plane_distances(view)) is None:
            visible = self.cached = self._find_visible(view)
            distances = visible.normals @ view.centre - visible.offsets_m
        return visible, distances

    def _find_visible(self, view: View) -> VisibleFaces:
        """The faces visible from the view and its surroundings."""
        group, axes, eye = self._close(view), view.axes, view.centre
        ahead = (group.middles_m @ axes[2, :2] - float(axes[2, :2] @ eye[:2])).take(group.owner)
        distances = group.normals @ eye - group.offsets_m
        shown = ((distances > 1e-6) & (ahead >= group.from_m) & (ahead < group.until_m)).nonzero()[0]
        shown = shown[np.argsort(-ahead[shown], kind="stable")]
        points = view.camera_axes(group.faces_m.take(shown, axis=0))
        inside = self._may_show(points)
        shown, points = shown[inside], in_front(points[inside], self._surely_m)
        depth, owner = ahead[shown], group.owner[shown]
        firsts = np.diff(owner, prepend=-1).nonzero()[0]
        colours = self._aerial_perspective.colours(
            self._contrasts(group, shown, view), depth, np.minimum(1.0, FULL - depth * group.fading[shown])
        )
        return VisibleFaces(
            view,
            self._stale_m,
            points @ axes + eye,
            group.normals.take(shown, axis=0),
            group.offsets_m[shown],
            colours.tolist(),
            firsts,
            depth[firsts].tolist(),
        )

    def _contrasts(self, group: Group, shown: Indices, view: View) -> Floats:
        """(n, 4) contrasts of the faces `shown`."""
        colours = group.colours.take(shown, axis=0)
        if self._lamplight is None:
            return colours
        faces, normals = group.faces_m.take(shown, axis=0), group.normals.take(shown, axis=0)
        factor = self._lamplight.on_faces(view, faces, normals, group.retro[shown])
        return contrasts(np.minimum(255.0, colours * factor), self._light)

    def shadow_polygons(self, light: Light) -> list[Floats]:
        """(n, 2) m, shadow outlines on the ground."""
        group = self._all
        coarse = (group.until_m >= self._coarse_m) & (np.abs(group.normals @ light.sun) > EDGE_ON)
        faces = group.faces_m[coarse]
        cast = faces[..., :2] - faces[..., 2:] * (light.sun[:2] / max(light.sun[2], LOWEST_SUN))
        return list(cast)

    def _may_show(self, points: Floats) -> Bools:
        """Which faces (n, VERTICES, 3) in camera axes may be visible until the next update."""
        right, depth = points[..., 0], points[..., 2]
        wide = self._widest * depth + 2.0 * self._stale_m
        beside = (right > wide).all(axis=1) | (right < -wide).all(axis=1)
        return np.asarray(~beside & (depth.max(axis=1) > self._surely_m))

    def _close(self, view: View) -> Group:
        """The candidates for any pose in the camera's cell and heading sector."""
        sector = int(np.floor(view.yaw_rad / (2.0 * np.pi) * SECTORS))
        x, y = (int(np.floor(place / CELL_M)) for place in view.centre[:2])
        if self._place != (x, y, sector):
            self._place = (x, y, sector)
            middle, yaw = CELL_M * (np.array([x, y]) + 0.5), 2.0 * np.pi * (sector + 0.5) / SECTORS
            self._near = _may_be_seen(self._all, middle, yaw, self._slope)
        return self._near


def _may_be_seen(group: Group, middle: Floats, yaw: float, slope: float) -> Group:
    """The items that may be visible from a cell around `middle` in a heading sector around `yaw`."""
    c, s = np.cos(yaw), np.sin(yaw)
    ahead, aside = ((group.middles_m - middle) @ np.array([[c, -s], [s, c]])).T
    spare = CELL_M + group.radii_m
    half = np.arctan(slope) + np.pi / SECTORS
    items = (ahead > -spare) & (np.abs(aside) < np.tan(half) * (ahead + spare) + spare)
    distance = np.hypot(ahead, aside)[group.owner]
    faces = (group.until_m > np.cos(half) * distance - CELL_M) & (group.from_m < distance + CELL_M)
    return group.only(items, faces)


def group_of(items: list[Placement], light: Light | None, camera: Camera) -> Group:
    """All faces in world axes, lit by daylight or by none."""
    poses = np.array([pose for _, pose, _ in items]).reshape(-1, 3)
    meshes = [mesh for mesh, _, _ in items]
    counts = np.array([len(mesh.faces_m) for mesh in meshes], np.int64)
    owner = np.repeat(np.arange(len(items)), counts)
    c, s = np.cos(poses[owner, 2]), np.sin(poses[owner, 2])
    zero, one = np.zeros(len(owner)), np.ones(len(owner))
    turns = np.stack([c, -s, zero, s, c, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
    places = np.column_stack([poses[owner, :2], zero])

    def joined(name: str, *shape: int) -> Floats:
        return np.concatenate([np.empty((0, *shape)), *(getattr(mesh, name) for mesh in meshes)])

    faces = np.concatenate([np.empty((0, VERTICES, 3)), *(mesh.faces_m[:, :VERTICES] for mesh in meshes)])
    faces = np.einsum("fij,fvj->fvi", turns, faces) + places[:, None]
    normals = np.einsum("fij,fj->fi", turns, joined("normals", 3))
    colours = joined("colours", 3)
    if light is not None:
        facing = np.maximum(0.0, normals @ light.sun)[:, None]
        shading = np.where(joined("lit")[:, None] > 0.0, light.sky + light.direct * facing, 1.0)
        colours = contrasts(np.minimum(255.0, colours * shading), light)
    ranges_m = np.array([range_m for _, _, range_m in items], float)[owner]
    share, until_m = detail(camera), joined("until_m")
    until_m = np.where(until_m < WHOLE_RANGE_M, share * until_m, until_m)
    thinnest = joined("thickness_m") * camera.fx_px / VISIBLE_PX
    return Group(
        middles_m=poses[:, :2],
        radii_m=np.array([mesh.reach_m for mesh in meshes]),
        owner=owner,
        faces_m=faces,
        normals=normals,
        offsets_m=np.einsum("fi,fi->f", normals, faces[:, 0]),
        colours=colours,
        retro=joined("retro") > 0.0,
        lit=joined("lit") > 0.0,
        from_m=joined("from_m") * share,
        until_m=np.minimum(np.minimum(until_m, thinnest), ranges_m),
        fading=1.0 / (FADING * ranges_m),
    )
