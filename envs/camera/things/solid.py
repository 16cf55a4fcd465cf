"""A body as the camera sees it: its mesh at a pose, in the light and through the air."""

from math import cos, sin

import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.things.air import Air, contrasts
from vpf_sim.envs.camera.things.mesh import Mesh
from vpf_sim.envs.camera.things.painter import Drawing, drawing
from vpf_sim.envs.camera.veil import Veil
from vpf_sim.envs.camera.view import NEAR_M, View
from vpf_sim.types import Floats

VISIBLE_PX = 0.6  # faces thinner than this are not drawn
RANGE_M, FADED_IN_M = 220.0, 180.0  # bodies appear at the one and are there at the other
ONE = np.zeros(1, np.int64)


class Solid:
    """One body's mesh, and its colours in the light for as long as it keeps its heading."""

    def __init__(self, mesh: Mesh, light: Light, veil: Veil) -> None:
        self._mesh = mesh
        self._light = light
        self._air = Air(light, veil)
        self._offsets_m = np.einsum("ij,ij->i", mesh.normals, mesh.faces_m[:, 0])  # of the faces' planes
        self._reach_m = mesh.reach_m
        self._heading: float | None = None
        self._colours = mesh.colours

    def seen(self, view: View, pose: Floats) -> Drawing | None:
        """The visible faces at a pose (x, y, heading); None if there are none."""
        mesh = self._mesh
        x, y, heading = pose.tolist()
        c, s = cos(heading), sin(heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        eye = (view.centre - np.array([x, y, 0.0])) @ turn  # in body axes
        axes = view.axes @ turn
        depth = float(-axes[2] @ eye)
        away = mesh.normals @ eye - self._offsets_m  # how far the eye is before each face's plane
        visible_m = VISIBLE_PX * max(depth - 2.0, 0.0) / view.camera.fx_px
        shown = ((away > 1e-6) & (mesh.thickness_m >= visible_m)).nonzero()[0]
        if len(mesh.centres_m) > 1:
            nearness = -((mesh.centres_m - eye) ** 2).sum(axis=1)
            shown = shown[np.argsort(nearness[mesh.parts[shown]], kind="stable")]
        faces = mesh.faces_m.take(shown, axis=0)
        points = ((faces.reshape(-1, 3) - eye) @ axes.T).reshape(faces.shape)
        if depth < self._reach_m + NEAR_M:
            ahead = (points[..., 2] > NEAR_M).any(axis=1)
            shown, points = shown[ahead], points[ahead]
        if not len(shown) or depth > RANGE_M:
            return None
        planes = mesh.normals[shown] @ axes.T / -away[shown, None]
        opacity = np.array([min(1.0, (RANGE_M - depth) / (RANGE_M - FADED_IN_M))])
        colours = self._air.colours(self._lit(heading, turn)[shown], np.array([max(depth, 0.0)]), opacity)
        return drawing(view, points, colours, planes, ONE)

    def _lit(self, heading: float, turn: Floats) -> Floats:
        """(F, 4) the contrasts of all faces at a heading."""
        if heading != self._heading:
            mesh, light = self._mesh, self._light
            facing = np.maximum(0.0, mesh.normals @ (light.sun @ turn))[:, None]
            shading = np.where(mesh.lit[:, None], light.sky + light.direct * facing, 1.0)
            self._colours = contrasts(np.minimum(mesh.colours * shading, 255.0), light)
            self._heading = heading
        return self._colours
