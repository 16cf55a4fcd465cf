"""An object's mesh at a pose, lit and hazed."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.detail import stale_m
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.painter import Drawing, drawing, planes_of
from vpf_sim.envs.camera.scenery.aerial_perspective import AerialPerspective, contrasts
from vpf_sim.envs.camera.scenery.mesh import Mesh
from vpf_sim.envs.camera.view import NEAR_M, View, object_to_world
from vpf_sim.geometry import is_same
from vpf_sim.types import Floats

VISIBLE_PX = 0.6  # faces thinner than this are not drawn
RANGE_M, FADED_IN_M = 220.0, 180.0  # distances at which objects appear, and are opaque
SLIVER_PX = 0.25  # width of the faces that are missed until visibility is updated
ON_EDGE_M = 1e-6  # least distance from a visible face's plane
ONE = np.zeros(1, np.int64)


@dataclass(frozen=True, slots=True)
class VisibleFaces:
    """The visible faces of an object near one camera position, and their colours."""

    eye: Floats  # (3,) camera position in object axes
    far_m: float  # radius of validity
    faces_m: Floats  # (n, V, 3)
    normals: Floats  # (n, 3)
    offsets_m: Floats  # (n,)
    colours: list[list[float]]  # (n, 4)

    def plane_distances(self, eye: Floats) -> Floats | None:
        """(n,) m, distances of the camera from the faces' planes; None if visibility is stale."""
        x, y, _ = (eye - self.eye).tolist()
        if not x * x + y * y < self.far_m**2:
            return None
        distances = self.normals @ eye - self.offsets_m
        return distances if distances.min(initial=1.0) > ON_EDGE_M else None


class Solid:
    """One object's lit mesh; its visible faces are cached while the camera stays near.

    A face that becomes visible meanwhile is missed. For an object of radius r at distance d it is at most 2 r f e / d^2
    px wide after a camera motion e; SLIVER_PX bounds it.
    """

    def __init__(self, mesh: Mesh, light: Light, haze: Haze, lamplight: Lamplight | None = None) -> None:
        """`lamplight` is the light of lamps in the dark, None by day."""
        self._mesh = mesh
        self._lamplight = lamplight
        self._light = light
        self._aerial_perspective = AerialPerspective(light, haze)
        self._offsets_m = np.einsum("ij,ij->i", mesh.normals, mesh.faces_m[:, 0])  # plane offsets
        self._reach_m = mesh.reach_m
        self._pose: Floats = np.full(3, np.nan)
        self._to_world = np.eye(4)
        self._contrasts: Floats | None = None  # for the present heading
        self.cached: VisibleFaces | None = None

    def visible(self, view: View, pose: Floats) -> Drawing | None:
        """The visible faces at a pose (x, y, heading); None without any."""
        near, distances = self._current(view, pose)
        visible = self.cached
        if visible is None or distances is None or not len(distances):
            return None
        return drawing(
            near, visible.faces_m, visible.colours, partial(planes_of, visible.normals, distances, near), ONE
        )

    def update(self, view: View, pose: Floats) -> None:
        """Update visibility at a pose if it is stale."""
        self._current(view, pose)

    def _current(self, view: View, pose: Floats) -> tuple[View, Floats | None]:
        """The view in object axes, and (n,) m, distances from the faces' planes; None beyond RANGE_M."""
        self._go(pose)
        near = view.in_object_axes(self._to_world)
        depth = float(-near.axes[2] @ near.centre)
        if depth > RANGE_M:
            return near, None
        visible = self.cached
        if visible is None or (distances := visible.plane_distances(near.centre)) is None:
            visible = self.cached = self._find_visible(view, near, depth)
            distances = visible.normals @ near.centre - visible.offsets_m
        return near, distances

    def _go(self, pose: Floats) -> None:
        """Set the pose."""
        if is_same(pose, self._pose):
            return
        if pose[2] != self._pose[2]:
            self._contrasts = self.cached = None
        self._pose, self._to_world = pose, object_to_world(pose)

    def _find_visible(self, view: View, near: View, depth: float) -> VisibleFaces:
        """The visible faces at a depth, near the present view, in the world and in object axes."""
        mesh, eye = self._mesh, near.centre
        distances = mesh.normals @ eye - self._offsets_m
        visible_m = VISIBLE_PX * max(depth - 2.0, 0.0) / near.camera.fx_px
        shown = ((distances > ON_EDGE_M) & (mesh.thickness_m >= visible_m)).nonzero()[0]
        if len(mesh.centres_m) > 1:
            nearness = -((mesh.centres_m - eye) ** 2).sum(axis=1)
            shown = shown[np.argsort(nearness[mesh.parts[shown]], kind="stable")]
        far_m = min(stale_m(near.camera), SLIVER_PX * depth**2 / (2.0 * self._reach_m * near.camera.fx_px))
        if depth < self._reach_m + NEAR_M + far_m:
            far_m = 0.0
            shown = shown[(near.camera_axes(mesh.faces_m[shown])[..., 2] > NEAR_M).any(axis=1)]
        opacity = np.array([min(1.0, (RANGE_M - depth) / (RANGE_M - FADED_IN_M))])
        lit = self._lit()[shown] if self._lamplight is None else self._lit_by(self._lamplight, view, shown)
        colours = self._aerial_perspective.colours(lit, np.array([max(depth, 0.0)]), opacity)
        faces = mesh.faces_m.take(shown, axis=0)
        return VisibleFaces(eye, far_m, faces, mesh.normals[shown], self._offsets_m[shown], colours.tolist())

    def _lit(self) -> Floats:
        """(F, 4) contrasts of all faces at the present heading."""
        if self._contrasts is None:
            mesh, light = self._mesh, self._light
            facing = np.maximum(0.0, mesh.normals @ (light.sun @ self._to_world[:3, :3]))[:, None]
            shading = np.where(mesh.lit[:, None], light.sky + light.direct * facing, 1.0)
            self._contrasts = contrasts(np.minimum(mesh.colours * shading, 255.0), light)
        return self._contrasts

    def _lit_by(self, lamplight: Lamplight, view: View, shown: NDArray[np.int64]) -> Floats:
        """(n, 4) contrasts of the faces `shown` in the light of lamps."""
        mesh, turn = self._mesh, self._to_world[:3, :3]
        faces = mesh.faces_m[shown] @ turn.T + self._to_world[:3, 3]
        factor = lamplight.on_faces(view, faces, mesh.normals[shown] @ turn.T, mesh.retro[shown])
        factor[~mesh.lit[shown]] = 1.0
        return contrasts(np.minimum(mesh.colours[shown] * factor, 255.0), self._light)
